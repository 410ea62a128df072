"""Effects that change M, C or K against closed forms, hand-made matrices and Exudyn's nonlinear elements."""

from dataclasses import replace
from itertools import chain

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import brentq

from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.built_in.bridge import bridge
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import (
    AddedMass,
    AxialForce,
    CubicSpring,
    DeadLoad,
    Effect,
    ModalDamping,
    PointDamper,
    StiffnessChange,
    SupportSpring,
)
from fe_models.damping import full_damping
from fe_models.errors import InputError
from fe_models.items import gravity_load
from fe_models.matrix_changes import matrix_changes
from fe_models.modes import natural_modes
from fe_models.simulation import FreeConfig, ReleaseConfig, simulate_free, simulate_release
from fe_models.statics import PointLoad, rest_state
from fe_models.structure import Cable, Damping, PointMass, Spring, Structure, Support
from tests.problems import TIMBER, WIRE, bending_frequencies, cantilever, chain_motion, newmark

BUCKLING = np.pi**2 * TIMBER.bending_stiffness / 2.0**2  # N, of a simply supported beam of 2 m

BRIDGE_EFFECTS: dict[str, tuple[Effect, ...]] = {
    "stiffness": (StiffnessChange((5, 33, 54), (0.7, 1.2, 0.5)),),
    "lost cable": (StiffnessChange((54,), 0.0),),
    "mass": (AddedMass(9, 0.4), AddedMass(15, -0.2)),
    "restraint": (SupportSpring(12, "y", 300.0),),
    "soft support": (SupportSpring(4, "y", 2e4),),
    "axial force": (AxialForce((3, 35, 53), (30.0, -20.0, 15.0)),),
    "dead load": (DeadLoad(0.8),),
    "dampers": (PointDamper((9, 21), "y", 3.0), PointDamper((40,), "x", 1.0)),
    "modal damping": (ModalDamping((1, 3), (0.02, 0.001)),),
}
BRIDGE_EFFECTS["all"] = tuple(chain.from_iterable(BRIDGE_EFFECTS.values()))


def simply_supported(divisions: int) -> Structure:
    return replace(cantilever(divisions=divisions), supports=(Support(1, ("x", "y")), Support(2, ("y",))))


def dense(structure: Structure) -> tuple[FloatArray, FloatArray, FloatArray]:
    model = linearise(structure)
    return model.mass.toarray(), full_damping(model), model.stiffness.toarray()


def test_stiffness_mass_and_restraint_of_the_chain_are_those_written_by_hand() -> None:
    structure = four_dof().with_effects(
        StiffnessChange((2,), 0.7), AddedMass(3, -0.5), SupportSpring(4, "x", 0.6), PointDamper((2, 4), "x", 0.2)
    )
    mass, damping, stiffness = dense(structure)
    k = np.array([1.0, 2.0 * 0.7, 3.0, 4.0])
    K = np.diag(k + np.append(k[1:], 0.0)) - np.diag(k[1:], 1) - np.diag(k[1:], -1)
    between = np.array([0, -1.0, 0, 1.0])
    np.testing.assert_allclose(mass, np.diag([1, 2, 2.5, 4]), atol=1e-15)
    np.testing.assert_allclose(stiffness, K + np.diag([0, 0, 0, 0.6]), atol=1e-14)
    np.testing.assert_allclose(damping, 0.1 * np.eye(4) + 0.2 * np.outer(between, between), atol=1e-15)
    found = natural_modes(linearise(structure), 4).omega
    np.testing.assert_allclose(found**2, eigh(stiffness, mass, eigvals_only=True), rtol=1e-10)


def test_factors_multiply_where_an_element_is_named_twice() -> None:
    once = linearise(four_dof().with_effects(StiffnessChange((1, 2), (0.4, 0.5))))
    twice = linearise(four_dof().with_effects(StiffnessChange((2,), 0.5), StiffnessChange((1,), 0.8)))
    again = linearise(four_dof().with_effects(StiffnessChange((1,), 0.8), StiffnessChange((2, 1), 0.5)))
    np.testing.assert_allclose(again.stiffness.toarray(), once.stiffness.toarray(), atol=1e-15)
    assert abs(twice.stiffness - once.stiffness).max() == pytest.approx(0.4)


def test_a_member_s_mass_and_weight_stay_when_its_stiffness_changes() -> None:
    weaker = bridge().with_effects(StiffnessChange((5, 33, 54), 0.3))
    np.testing.assert_array_equal(linearise(weaker).mass.toarray(), linearise(bridge()).mass.toarray())
    np.testing.assert_array_equal(gravity_load(weaker), gravity_load(bridge()))
    heavier = gravity_load(bridge().with_effects(AddedMass(9, 2.0))) - gravity_load(bridge())
    assert heavier[3 * 8 + 1] == pytest.approx(-2.0 * 9.81)


def test_a_tip_mass_lowers_the_cantilever_as_the_closed_form_says() -> None:
    """1 + cos b cosh b = mu b (sin b cosh b - cos b sinh b), mu the mass over that of the beam."""
    mass = 0.3 * TIMBER.mass_per_length * 2.0
    heavy = cantilever(divisions=8).with_effects(AddedMass(2, mass))
    root = brentq(
        lambda b: 1 + np.cos(b) * np.cosh(b) - 0.3 * b * (np.sin(b) * np.cosh(b) - np.cos(b) * np.sinh(b)), 1.0, 1.875
    )
    found = natural_modes(linearise(heavy), 1).frequencies[0]
    assert found == pytest.approx(bending_frequencies((root,), 2.0)[0], rel=1e-5)  # order 4: (b / 8)^4 / 720


@pytest.mark.parametrize("ratio", [0.0, 1.0, 30.0, 1e7])
def test_a_soft_support_lies_between_a_free_and_a_held_end(ratio: float) -> None:
    """b^3 (1 + cos b cosh b) + kappa (sin b cosh b - cos b sinh b) = 0, kappa = k L^3 / (E I)."""
    held = replace(cantilever(divisions=8), supports=(Support(1, ("x", "y", "rz")), Support(2, ("y",))))
    stiffness = ratio * TIMBER.bending_stiffness / 2.0**3
    soft = held.with_effects(SupportSpring(2, "y", stiffness))
    lacking = cantilever(divisions=8).with_effects(SupportSpring(2, "y", stiffness))

    def characteristic(b: float) -> float:
        return float(b**3 * (1 + np.cos(b) * np.cosh(b)) + ratio * (np.sin(b) * np.cosh(b) - np.cos(b) * np.sinh(b)))

    root = brentq(characteristic, 1.87, 3.95)
    for structure in (soft, lacking):
        found = natural_modes(linearise(structure), 1).frequencies[0]
        assert found == pytest.approx(bending_frequencies((root,), 2.0)[0], rel=2e-4)  # (b / 8)^4 / 720, b = 3.9
    assert linearise(soft).mass.shape == linearise(lacking).mass.shape


@pytest.mark.parametrize("share", [-0.9, -0.3, 0.5, 4.0])
def test_axial_force_tunes_a_beam_as_the_closed_form_says(share: float) -> None:
    """f_n = f_n0 sqrt(1 + N / (n^2 N_cr)), exact for simple supports: tension raises, compression lowers."""
    force = share * BUCKLING
    structure = simply_supported(16).with_effects(AxialForce((1,), force))
    exact = bending_frequencies((np.pi, 2 * np.pi), 2.0) * np.sqrt(1 + share / np.array([1, 4]))
    found = natural_modes(linearise(structure), 2).frequencies
    # Cubic shapes: (n pi / 16)^4 / 720, 3e-5 for n = 2, more near buckling, where the frequency is a small difference.
    np.testing.assert_allclose(found, exact, rtol=6e-5)


def test_compression_beyond_buckling_is_refused_where_it_is_linearised() -> None:
    linearise(simply_supported(8).with_effects(AxialForce((1,), -0.999 * BUCKLING)))
    with pytest.raises(InputError, match="unstable"):
        linearise(simply_supported(8).with_effects(AxialForce((1,), -1.001 * BUCKLING)))


@pytest.mark.parametrize("force", [-100.0, 300.0])
def test_axial_force_is_the_tangent_of_a_loaded_nonlinear_beam(force: float) -> None:
    """The geometrically exact beam of Exudyn, pulled along its axis, against K_G on the unloaded one."""
    loaded = cantilever(divisions=16)
    tangent = linearise(loaded, rest_state(loaded, 0.0, (PointLoad(2, "x", force),)))
    effect = linearise(loaded.with_effects(AxialForce((1,), force)))
    found, expected = (natural_modes(model, 2).frequencies for model in (effect, tangent))
    plain = natural_modes(linearise(loaded), 2).frequencies
    assert np.abs(plain / expected - 1)[0] > 0.1
    np.testing.assert_allclose(found, expected, rtol=2e-3)  # linear shapes in P-delta: order 2, (b / 16)^2 / 12


def test_axial_forces_of_several_effects_add_up() -> None:
    once = linearise(simply_supported(2).with_effects(AxialForce((1,), 70.0))).stiffness.toarray()
    twice = linearise(simply_supported(2).with_effects(AxialForce((1,), 100.0), AxialForce((1,), -30.0)))
    np.testing.assert_allclose(twice.stiffness.toarray(), once, rtol=1e-12)  # another order of sums


def test_a_weaker_cable_carries_less_of_its_prestress() -> None:
    """All its forces are multiplied: E A / L0 along it and N / L across, until it is lost."""
    elements = Cable((1, 2), WIRE, 50.0, tension_only=False), Spring((2,), "x", 1.0), Spring((2,), "y", 1.0)
    cable = Structure("c", ((0, 0), (2, 0)), elements, supports=(Support(1, ("x", "y")),), directions=("x", "y"))
    full = linearise(cable, np.zeros(4)).stiffness.toarray() - np.eye(2)
    assert full[1, 1] == pytest.approx(50.0 / 2.0, rel=1e-9)
    for factor in (0.4, 0.0):
        found = linearise(cable.with_effects(StiffnessChange((1,), factor)), np.zeros(4)).stiffness.toarray()
        np.testing.assert_allclose(found - np.eye(2), factor * full, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("vector", [(2.0, 0.0), (0.3, -0.4)])
def test_axial_force_is_the_prestress_of_a_cable(vector: tuple[float, float]) -> None:
    supports = (Support(1, ("x", "y")), Support(2, ()))
    cable = Structure("c", ((0, 0), vector), (Cable((1, 2), WIRE, tension_only=False),), (), (), supports[:1])
    cable = replace(cable, directions=("x", "y"), elements=(*cable.elements, Spring((2,), "x", 1.0)))
    cable = replace(cable, elements=(*cable.elements, Spring((2,), "y", 1.0)))
    tight = replace(cable, elements=(replace(cable.elements[0], prestress=50.0), *cable.elements[1:]))  # type: ignore[arg-type]
    at_rest = linearise(tight, np.zeros(4))  # in the drawn geometry it has its prestress
    across = np.array([-vector[1], vector[0]]) / np.hypot(*vector)
    effect = linearise(cable.with_effects(AxialForce((1,), 50.0))).stiffness
    assert across @ effect @ across == pytest.approx(1.0 + 50.0 / np.hypot(*vector), rel=1e-12)
    assert across @ effect @ across == pytest.approx(across @ at_rest.stiffness @ across, rel=1e-9)  # twelve digits


def test_axial_force_tips_a_storey() -> None:
    """P-delta: a column of height h that sways with stiffness k resists with k + N / h."""
    storey = Structure(
        "storey",
        ((0.0, 0.0), (0.0, 3.0)),
        (Spring((1, 2), "x", 1000.0),),
        point_masses=(PointMass(2, 10.0),),
        supports=(Support(1, ("x",)),),
        directions=("x",),
    )
    stiffness = linearise(storey.with_effects(AxialForce((1,), -600.0))).stiffness.toarray()
    np.testing.assert_allclose(stiffness, [[1000.0 - 600.0 / 3.0]])


def test_modal_damping_replaces_the_ratios_of_its_modes_alone() -> None:
    structure = replace(bridge(), damping=Damping(stiffness_factor=1e-4, modal_ratios=(0.01, 0.02)))
    plain = natural_modes(linearise(structure), 6)
    model = linearise(structure.with_effects(ModalDamping((2, 5), (0.05, 0.0))))
    modal = natural_modes(model, 6)
    expected = plain.damping_ratio.copy()
    expected[[1, 4]] = 0.05, 0.0
    np.testing.assert_allclose(modal.damping_ratio, expected, rtol=1e-12)
    shapes = modal.shapes[modal.dofs.free]
    reduced = shapes.T @ full_damping(model) @ shapes
    scale = 2 * np.sqrt(np.outer(modal.omega, modal.omega))
    np.testing.assert_allclose(reduced / scale, np.diag(expected), atol=1e-9)  # dense eigenvectors, condition 1e8


def test_a_mode_of_the_chain_decays_with_its_new_ratio() -> None:
    structure = replace(four_dof(), dashpots=(), damping=Damping(modal_ratios=(0.01,)))
    structure = structure.with_effects(ModalDamping((2,), 0.04))
    modal = natural_modes(linearise(structure), 4)
    for mode, ratio in ((1, 0.04), (2, 0.01)):
        shape, omega = modal.shapes[:, mode], modal.omega[mode]
        found = simulate_free(structure, shape[None], np.zeros((1, 4)), FreeConfig(10.0, 10.0, 0.02))
        t, damped = found.time, omega * np.sqrt(1 - ratio**2)
        decay = np.exp(-ratio * omega * t) * (np.cos(damped * t) + ratio * omega / damped * np.sin(damped * t))
        np.testing.assert_allclose(found.displacement[0], decay[:, None] * shape, atol=1e-9)  # (0.02 w)^6


@pytest.mark.parametrize("name", BRIDGE_EFFECTS)
def test_changes_of_matrices_are_the_differences(name: str) -> None:
    structure, effects = bridge(), BRIDGE_EFFECTS[name]
    changes = matrix_changes(structure, *effects)
    extended = linearise(structure.with_effects(*effects))
    free = changes.dofs.free
    np.testing.assert_array_equal(free, extended.dofs.free)
    nominal = linearise(replace(structure, supports=_supports(structure, effects)))
    damping = changes.damping.toarray() + (changes.modal_vectors * changes.modal_weights) @ changes.modal_vectors.T
    for before, change, after in (
        (nominal.mass.toarray(), changes.mass.toarray(), extended.mass.toarray()),
        (nominal.damping.toarray(), damping, full_damping(extended)),
        (nominal.stiffness.toarray(), changes.stiffness.toarray(), extended.stiffness.toarray()),
    ):
        error = np.abs(before + change[np.ix_(free, free)] - after).max()
        assert error < 1e-9 * np.abs(after).max()  # shapes of modal damping; rounding elsewhere
    if name not in ("modal damping", "dead load", "all"):
        total = sum(matrix.nnz for matrix in (changes.mass, changes.damping, changes.stiffness))
        assert 0 < total < 400  # sparse: of 165 x 165; a dead load acts in every element


def _supports(structure: Structure, effects: tuple[Effect, ...]) -> tuple[Support, ...]:
    """The supports that are left where a spring takes the place of one; all of these hold one direction."""
    springs = {(effect.node, effect.direction) for effect in effects if isinstance(effect, SupportSpring)}
    return tuple(s for s in structure.supports if (s.node, s.directions[0]) not in springs or len(s.directions) > 1)


@pytest.mark.slow
@pytest.mark.parametrize("name", BRIDGE_EFFECTS)
def test_small_release_of_the_bridge_with_effects_is_that_of_its_tangent(name: str) -> None:
    structure = bridge().with_effects(*BRIDGE_EFFECTS[name])
    response = simulate_release(structure, (PointLoad(19, "y", -1e-3),), ReleaseConfig(0.1, 500.0, 1e-3))
    tangent = linearise(structure, rest_state(structure))
    free = tangent.dofs.free
    matrices = tangent.mass.toarray(), full_damping(tangent), tangent.stiffness.toarray()
    expected = newmark(matrices, response.displacement[0, free], 1e-3, 100)[::2]
    # The same rule on the same grid: what is left is the square of the pull, 1e-3 N against 10 N of weight, and Newton.
    np.testing.assert_allclose(response.displacement[:, free], expected, atol=2e-3 * np.abs(expected).max())
    plain = linearise(bridge(), rest_state(bridge()))
    if name not in ("modal damping", "dampers", "dead load"):  # which the tangent at rest has by itself
        assert abs(natural_modes(plain, 8).frequencies / natural_modes(tangent, 8).frequencies - 1).max() > 1e-4


CHAIN: dict[str, Effect] = {
    "stiffness": StiffnessChange((2, 3), (0.8, 1.1)),
    "mass": AddedMass(2, -0.5),
    "restraint": SupportSpring(3, "x", -0.1),
    "damper": PointDamper((1, 3), "x", 0.2),
    "modal damping": ModalDamping((1, 4), 0.05),
}


@pytest.mark.parametrize("name", CHAIN)
def test_the_chain_with_its_changes_moves_as_exudyn_s(name: str) -> None:
    """M + dM, C + dC, K + dK, integrated by scipy, against Exudyn's run of the extended structure."""
    changes = matrix_changes(four_dof(), CHAIN[name])
    modal = (changes.modal_vectors * changes.modal_weights) @ changes.modal_vectors.T
    added = changes.mass.toarray(), changes.damping.toarray() + modal, changes.stiffness.toarray()
    matrices = tuple(nominal + change for nominal, change in zip(dense(four_dof()), added, strict=True))
    x0, v0 = np.array([1.0, -0.6, 0.8, 0.5]), np.array([0.2, 0.4, -0.5, 0.1])
    found = simulate_free(four_dof().with_effects(CHAIN[name]), x0[None], v0[None], FreeConfig(20.0, 10.0, 0.02))
    expected = chain_motion(matrices, lambda u, v, t: 0 * u, np.concatenate([x0, v0]), found.time)
    np.testing.assert_allclose(found.displacement[0], expected[:, :4], atol=1e-8)  # order 6 at 0.02 s: 1e-10
    silent = simulate_free(four_dof(), x0[None], v0[None], FreeConfig(20.0, 10.0, 0.02))
    assert np.abs(silent.displacement - found.displacement).max() > 0.05


def test_reduced_changes_are_those_of_the_modes() -> None:
    """In all modes of the chain, the reduced matrices have the extended structure's own frequencies."""
    modal = natural_modes(linearise(four_dof()), 4)
    effects = StiffnessChange((3,), 0.5), AddedMass(1, 0.3)
    mass, _, stiffness = matrix_changes(four_dof(), *effects).reduced(modal.shapes)
    found = eigh(np.diag(modal.omega**2) + stiffness, np.eye(4) + mass, eigvals_only=True)
    exact = natural_modes(linearise(four_dof().with_effects(*effects)), 4).omega
    np.testing.assert_allclose(np.sqrt(found), exact, rtol=1e-12)


def test_changes_at_a_loaded_rest_are_those_of_the_tangent() -> None:
    state = rest_state(bridge())
    effect = StiffnessChange((54,), 0.6)
    changes = matrix_changes(bridge(), effect, state=state)
    free = changes.dofs.free
    before, after = (linearise(s, state).stiffness for s in (bridge(), bridge().with_effects(effect)))
    error = abs(before + changes.stiffness[free][:, free] - after).max()
    assert error < 1e-9 * abs(after).max()


@pytest.mark.parametrize(
    ("effects", "fault"),
    [
        ((AddedMass(1, -1.0),), "effects leave node 1 a mass of 0 kg in x; remove less there"),
        ((AddedMass(1, -0.6), AddedMass(1, -0.6)), "effects leave node 1 a mass of -0.2 kg in x"),
        ((SupportSpring(1, "x", -4.0),), "the stiffness at node 1 in x is negative, -1: the state at rest is unstable"),
        ((SupportSpring(4, "x", -0.6),), "the state at rest is unstable, most of all node 4 in x"),
        ((DeadLoad(),), "nodes move in x only; weight changes small motions where they move in x and y"),
        ((ModalDamping((1, 5), 0.01),), "modal_damping: there is no mode 5; the structure has 4"),
    ],
)
def test_effects_that_take_more_than_there_is_are_refused(effects: tuple[Effect, ...], fault: str) -> None:
    with pytest.raises(InputError, match=fault.replace("(", r"\(")):
        linearise(four_dof().with_effects(*effects))


def test_removed_mass_may_not_make_a_beam_s_inertia_negative() -> None:
    """M stays positive on its diagonal, and yet some motion of the consistent mass would have negative energy."""
    own = linearise(cantilever()).mass.toarray()[0, 0]
    with pytest.raises(InputError, match="M is not positive"):
        linearise(cantilever().with_effects(AddedMass(2, -0.95 * own)))


def test_a_chain_cut_from_the_ground_is_a_mechanism() -> None:
    cut = linearise(four_dof().with_effects(StiffnessChange((1,), 0.0)))
    with pytest.raises(InputError, match="can move in x without resistance"):
        natural_modes(cut, 4)


def test_a_structure_with_force_laws_alone_keeps_its_matrices() -> None:
    model = linearise(bridge().with_effects(CubicSpring((12,), "y", 1e9)))
    np.testing.assert_array_equal(model.stiffness.toarray(), linearise(bridge()).stiffness.toarray())
    assert matrix_changes(bridge(), CubicSpring((12,), "y", 1e9)).stiffness.nnz == 0
