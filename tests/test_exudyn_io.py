"""Exudyn's matrices are those of the textbook, element by element and as a whole."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.built_in.bridge import bridge
from fe_models.causes import AddedMass, AxialForce, CubicSpring, PointDamper, StiffnessChange, SupportSpring
from fe_models.exudyn.item_matrices import element_matrices, whole_system
from fe_models.exudyn.items import Item, Options
from fe_models.items import gravity_load
from fe_models.mesh import mesh
from fe_models.statics import PointLoad, rest_state
from fe_models.structure import PLANE_FRAME, Beam, Cable, Damping, Dashpot, Direction, PointMass, Spring, Structure
from tests.problems import TIMBER, WIRE, frame_matrices

VECTORS = ([2.0, 0.0], [0.0, -0.5], [0.3, 0.4], [-1.2, 0.7])
RAYLEIGH = Options(damping=Damping(mass_factor=0.3, stiffness_factor=2e-4))


def relative(found: FloatArray, expected: FloatArray) -> float:
    """Return the largest difference over the largest expected value."""
    return float(np.abs(found - expected).max() / np.abs(expected).max())


@pytest.mark.parametrize("vector", VECTORS)
@pytest.mark.parametrize("item", [Beam((1, 2), TIMBER), Cable((1, 2), WIRE)])
def test_members_are_the_textbook_s(item: Beam | Cable, vector: list[float]) -> None:
    structure = Structure("member", ((0.0, 0.0), (vector[0], vector[1])), (item,))
    mass, stiffness = frame_matrices(structure)
    found = element_matrices(PLANE_FRAME, item, np.array(vector), Options(slack=False))
    # A dozen roundings; Exudyn differentiates cables and springs analytically, too.
    assert relative(found.mass, mass) < 1e-14
    assert relative(found.stiffness, stiffness) < 1e-14
    assert not found.damping.any()


@pytest.mark.parametrize(
    "item", [Beam((1, 2), TIMBER), Cable((1, 2), WIRE), Spring((1, 2), "y", 7.0), PointMass(1, 3.0)]
)
def test_rayleigh_damping_is_proportional(item: Item) -> None:
    found = element_matrices(PLANE_FRAME, item, np.array([0.3, 0.4]), replace(RAYLEIGH, slack=False))
    expected = 0.3 * found.mass + 2e-4 * found.stiffness
    assert relative(found.damping, expected) < 1e-14  # roundings


@pytest.mark.parametrize("directions", [("x",), ("x", "y"), ("x", "y", "rz"), ("rz",)])
def test_springs_and_dashpots_act_in_their_direction(directions: tuple[Direction, ...]) -> None:
    direction = directions[-1]
    row = len(directions) - 1
    spring = element_matrices(directions, Spring((1,), direction, 5.0), np.zeros(2), Options())
    dashpot = element_matrices(directions, Dashpot((1, 2), direction, 4.0), np.zeros(2), Options())
    expected = np.zeros((len(directions), len(directions)))
    expected[row, row] = 1.0
    np.testing.assert_allclose(spring.stiffness, 5.0 * expected, atol=1e-14)
    pair = np.kron(np.array([[1.0, -1.0], [-1.0, 1.0]]), expected)
    np.testing.assert_allclose(dashpot.damping, 4.0 * pair, atol=1e-14)


def test_cubic_spring_has_the_tangent_of_its_own_force() -> None:
    effect = CubicSpring((1, 2), "x", stiffness=2.0)
    u = np.array([0.1, 0.6])
    found = element_matrices(("x",), effect, np.zeros(2), Options(), u)
    # d(k w^3)/dw = 3 k w^2 at w = 0.5; Exudyn differentiates user functions numerically, with steps of about 1e-8.
    np.testing.assert_allclose(found.stiffness, 1.5 * np.array([[1.0, -1.0], [-1.0, 1.0]]), rtol=1e-6)


def test_prestressed_cable_has_geometric_stiffness() -> None:
    cable = Cable((1, 2), WIRE, prestress=50.0)
    found = element_matrices(("x", "y"), cable, np.array([2.0, 0.0]), Options(slack=False))
    # N / L across the cable; its strain of 8e-5, a difference of lengths, leaves twelve digits.
    assert found.stiffness[3, 3] == pytest.approx(50.0 / 2.0, rel=1e-10)
    free_length = 2.0 / (1 + 50.0 / WIRE.axial_stiffness)
    assert found.stiffness[2, 2] == pytest.approx(WIRE.axial_stiffness / free_length, rel=1e-12)


def everything() -> Structure:
    """The bridge with one of each kind of item more, and of each effect that is in the matrices."""
    return replace(
        bridge(),
        elements=(*bridge().elements, Spring((15,), "y", 300.0), Spring((40, 53), "x", 20.0)),
        dashpots=(Dashpot((9, 21), "y", 3.0),),
    ).with_effects(
        StiffnessChange((5, 54), (0.8, 0.6)),
        AddedMass(9, 0.3),
        SupportSpring(4, "y", 2e4),
        AxialForce((3, 35, 53), 20.0),
        PointDamper((12, 18), "y", 1.0),
    )


def whole_matrices(structure: Structure, options: Options, state: FloatArray | None = None) -> list[FloatArray]:
    """Return M, K and C of Exudyn's whole system, over all degrees of freedom."""
    import exudyn as exu

    system = whole_system(structure, mesh(structure), options)
    system.mbs.Assemble()
    if state is not None:
        system.mbs.systemData.SetODE2Coordinates(state.tolist(), exu.ConfigurationType.Initial)
    return [np.asarray(matrix) for matrix in system.mbs.ComputeLinearizedSystem()]


def test_sum_of_elements_is_exudyn_s_whole_system() -> None:
    structure = everything()
    model = linearise(structure)
    free = np.ix_(model.dofs.free, model.dofs.free)
    options = Options(structure.damping, prestress=False, slack=False)
    for found, whole in zip(
        (model.mass, model.stiffness, model.damping), whole_matrices(structure, options), strict=True
    ):
        assert relative(found.toarray(), whole[free]) < 1e-13  # the same numbers, summed in another order


def test_sum_of_elements_is_the_whole_at_a_loaded_state() -> None:
    structure = everything()
    state = rest_state(structure, loads=(PointLoad(19, "y", -9.81),))
    model = linearise(structure, state)
    free = np.ix_(model.dofs.free, model.dofs.free)
    mass, stiffness, damping = whole_matrices(structure, Options(structure.damping, slack=False), state)
    assert relative(model.mass.toarray(), mass[free]) < 1e-13
    # The same numbers, summed in another order; forces in the beams leave a few digits less.
    assert relative(model.stiffness.toarray(), stiffness[free]) < 1e-12
    assert relative(model.damping.toarray(), damping[free]) < 1e-12


def test_refined_structure_shares_elements_and_weighs_the_same() -> None:
    for divisions in (1, 5):
        weight = gravity_load(bridge().refined(divisions), 1.0)
        members = sum(
            element.section.mass_per_length * bridge().length(element)
            for element in bridge().elements
            if isinstance(element, Beam | Cable)
        )
        points = sum(point.mass for point in bridge().point_masses)
        assert -weight[1::3].sum() == pytest.approx(members + points, rel=1e-12)  # summed in another order
        assert abs(weight[0::3]).max() < 1e-12  # nothing falls sideways


def test_nothing_is_printed_or_written(
    capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    rest_state(bridge())
    assert capfd.readouterr() == ("", "")
    assert list(tmp_path.iterdir()) == []


def test_structures_and_modes_import_without_exudyn() -> None:
    script = (
        "import sys, fe_models.modes, fe_models.files.models, fe_models.simulation; sys.exit('exudyn' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", script], check=False).returncode == 0
