"""What is drawn is the true deformed shape: exact beam curves, straight cables, a stated and sensible exaggeration."""

from collections.abc import Callable
from math import cos, log10, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import eigh
from scipy.sparse import csr_array

from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.causes import SupportSpring
from fe_models.dof_map import DofMap
from fe_models.dofs import structure_dofs
from fe_models.errors import InputError
from fe_models.linear import LinearModel
from fe_models.mesh import mesh
from fe_models.modes import natural_modes
from fe_models.pictures.geometry import (
    bent,
    choose_scale,
    deformed_lines,
    extent,
    largest_displacement,
    nodal_motion,
    outline,
)
from fe_models.sections import Section
from fe_models.structure import Beam, Cable, PointMass, Spring, Structure, Support

STEEL = Section("steel", 2.1e11, 7850.0, 1e-4, 1e-9)
ROUNDING = 1e-12  # a dozen operations on numbers of order one


def cantilever(length: float, divisions: int = 1) -> Structure:
    return Structure(
        name="cantilever",
        nodes=((0.0, 0.0), (length, 0.0)),
        elements=(Beam((1, 2), STEEL),),
        supports=(Support(1, ("x", "y", "rz")),),
        divisions=divisions,
    )


def tip_loaded(x: FloatArray, length: float) -> tuple[FloatArray, FloatArray]:
    """Deflection and slope of a cantilever with unit P / (6 EI) at its tip: v = x^2 (3 L - x)."""
    return x**2 * (3 * length - x), 6 * x * length - 3 * x**2


def tip_loaded_dofs(structure: Structure, length: float) -> FloatArray:
    dofs, x = structure_dofs(structure), mesh(structure).coordinates[:, 0]
    deflection, slope = tip_loaded(x, length)
    displacement = np.zeros(len(dofs))
    displacement[dofs.direction == "y"] = deflection
    displacement[dofs.direction == "rz"] = slope
    return displacement


@pytest.mark.parametrize("divisions", [1, 2, 5])
def test_cantilever_is_drawn_as_its_exact_cubic_at_any_refinement(divisions: int) -> None:
    structure = cantilever(1.7, divisions)
    (lines,) = deformed_lines(outline(structure), tip_loaded_dofs(structure, 1.7), 1.0)
    x, y = lines.points.reshape(-1, 2).T
    np.testing.assert_allclose(y, tip_loaded(x, 1.7)[0], atol=10 * ROUNDING)
    np.testing.assert_allclose(lines.magnitude.ravel(), y, atol=10 * ROUNDING)


@given(st.floats(0, 2 * pi), st.floats(0.1, 10))
def test_beam_in_any_direction_bends_alike(angle: float, length: float) -> None:
    along, across = np.array([cos(angle), sin(angle)]), np.array([-sin(angle), cos(angle)])
    deflection, slope = tip_loaded(np.array([length]), length)
    motion = np.zeros((1, 2, 3))
    motion[0, 1] = *(deflection[0] * across), slope[0]
    moved = bent(np.zeros((1, 2)), (length * along)[None], motion, 9)[0]
    exact = tip_loaded(np.linspace(0, length, 9), length)[0]
    np.testing.assert_allclose(moved, exact[:, None] * across, atol=100 * ROUNDING * length**3)


def test_beam_drawn_from_its_other_end_is_the_same() -> None:
    rng = np.random.default_rng(1)
    start, end, motion = rng.normal(size=(4, 2)), rng.normal(size=(4, 2)), rng.normal(size=(4, 2, 3))
    there, back = bent(start, end, motion, 7), bent(end, start, motion[:, ::-1], 7)
    np.testing.assert_allclose(there, back[:, ::-1], atol=ROUNDING * 10)


def test_rigid_motion_keeps_beams_straight() -> None:
    start, end, turn, shift = np.array([[0.3, -1.0]]), np.array([[2.0, 1.5]]), 0.01, np.array([0.2, -0.4])
    rotated = [turn * np.array([-point[0, 1], point[0, 0]]) + shift for point in (start, end)]
    motion = np.array([[[*rotated[0], turn], [*rotated[1], turn]]])
    s = np.linspace(0, 1, 11)[:, None]
    points = (1 - s) * start + s * end
    expected = turn * np.stack([-points[:, 1], points[:, 0]], axis=1) + shift
    np.testing.assert_allclose(bent(start, end, motion, 11)[0], expected, atol=ROUNDING)


def simply_supported(length: float, divisions: int) -> Structure:
    return Structure(
        name="simply supported beam",
        nodes=((0.0, 0.0), (length, 0.0)),
        elements=(Beam((1, 2), STEEL),),
        supports=(Support(1, ("x", "y")), Support(2, ("y",))),
        divisions=divisions,
    )


def clamped_mode(s: FloatArray) -> FloatArray:
    """First mode of a cantilever, 1 at its tip: cosh - cos - sigma (sinh - sin) of beta s, cos beta cosh beta = -1."""
    beta = 1.8751040687119611
    sigma = (np.cosh(beta) + np.cos(beta)) / (np.sinh(beta) + np.sin(beta))
    return np.asarray((np.cosh(beta * s) - np.cos(beta * s) - sigma * (np.sinh(beta * s) - np.sin(beta * s))) / 2)


@pytest.mark.parametrize(
    ("structure", "exact", "error"),
    [  # what one or two cubics leave of the analytic mode; straight lines between nodes are 9 to 20 times as far off
        (simply_supported(2.0, 1), lambda s: np.sin(pi * s), 0.057),
        (simply_supported(2.0, 2), lambda s: np.sin(pi * s), 0.011),
        (cantilever(2.0, 1), clamped_mode, 0.012),
        (cantilever(2.0, 2), clamped_mode, 0.0014),
    ],
    ids=["simply supported, 1 element", "2 elements", "cantilever, 1 element", "2 elements"],
)
def test_the_first_mode_is_drawn_as_the_beam_bends_between_few_nodes(
    structure: Structure, exact: Callable[[FloatArray], FloatArray], error: float
) -> None:
    mode = natural_modes(linearise(structure), 1).shapes[:, 0]
    (lines,) = deformed_lines(outline(structure), mode, 1.0)
    x, y = lines.points.reshape(-1, 2).T
    np.testing.assert_allclose(y / y[np.argmax(np.abs(y))], exact(x / 2.0), atol=error)


def test_the_first_mode_of_one_element_is_the_cubic_of_its_two_degrees_of_freedom() -> None:
    """Ends that turn against each other: a parabola. A cantilever: the eigenvector (v, r L) of the 2 x 2 problem."""
    (parabola,) = deformed_lines(
        outline(simply_supported(2.0, 1)), natural_modes(linearise(simply_supported(2.0, 1)), 1).shapes[:, 0], 1.0
    )
    x, y = parabola.points[0].T
    np.testing.assert_allclose(y / y[np.argmax(np.abs(y))], x * (2.0 - x), atol=1e-9)  # of the eigenvalue solver
    stiffness, mass = np.array([[12.0, -6.0], [-6.0, 4.0]]), np.array([[156.0, -22.0], [-22.0, 4.0]])
    v, turn = eigh(stiffness, mass)[1][:, 0]
    (cubic,) = deformed_lines(outline(cantilever(2.0)), natural_modes(linearise(cantilever(2.0)), 1).shapes[:, 0], 1.0)
    x, y = cubic.points[0].T
    s = x / 2.0
    exact = (3 * s**2 - 2 * s**3) + (s**3 - s**2) * turn / v
    np.testing.assert_allclose(y / y[-1], exact, atol=1e-9)


@pytest.mark.parametrize("divisions", [1, 4, 100])
def test_curves_are_cut_finely_enough_and_no_finer_at_any_number_of_elements(divisions: int) -> None:
    """A piece of a sixtieth of the structure is a dozen pixels long; every piece costs time in a film."""
    (lines,) = deformed_lines(outline(cantilever(3.0, divisions)), np.zeros(3 * (divisions + 1)), 0.0)
    pieces = np.diff(lines.points[..., 0], axis=1)
    assert pieces.max() <= 3.0 / 60 + ROUNDING
    assert pieces.size <= 200


def test_cables_stay_straight_and_scale_multiplies_displacements_only() -> None:
    structure = Structure("stay", ((0.0, 0.0), (3.0, 4.0)), (Cable((1, 2), STEEL),))
    displacement = np.array([0.0, 0.0, 9.0, 0.03, 0.04, 7.0])  # the rotations must not matter
    (lines,) = deformed_lines(outline(structure), displacement, 10.0)
    np.testing.assert_allclose(lines.points, [[[0.0, 0.0], [3.3, 4.4]]], atol=ROUNDING)
    np.testing.assert_allclose(lines.magnitude, [[0.0, 0.05]], atol=ROUNDING)


def test_largest_displacement_between_nodes_is_found() -> None:
    turn, length = 0.02, 2.0  # ends rotate against each other: v = turn L / 4 at midspan, 0 at both nodes
    displacement = np.array([0.0, 0.0, turn, 0.0, 0.0, -turn])
    found = largest_displacement(outline(cantilever(length)), [displacement])
    assert found == pytest.approx(turn * length / 4, rel=ROUNDING)


def test_extent_holds_the_undeformed_and_every_deformed_shape() -> None:
    shape = outline(cantilever(2.0))
    up = np.array([0.0, 0.0, 0.0, 0.5, 1.0, 0.0])
    reach = extent(shape, [up, -up], 2.0)
    np.testing.assert_allclose(reach, [[0.0, -2.0], [3.0, 2.0]], atol=ROUNDING)


@given(st.floats(1e-12, 1e6), st.floats(1e-3, 1e4))
def test_scale_is_round_and_draws_the_largest_near_a_twelfth_of_the_size(largest: float, size: float) -> None:
    scale = choose_scale(np.array([0.0, -largest, largest / 3]), size)
    digit = scale / 10 ** np.floor(log10(scale) + 1e-9)
    assert min(abs(digit - wanted) for wanted in (1, 2, 5)) < 1e-6
    # neighbours in 1, 2, 5 are at most a factor 2.5 apart, so the nearest is within sqrt(2.5) of 8 %
    assert 0.08 / 2.5**0.5 * 0.999 <= scale * largest / size <= 0.08 * 2.5**0.5 * 1.001


def test_scale_of_a_structure_at_rest_is_one() -> None:
    assert choose_scale(np.zeros(5), 3.0) == 1.0


def test_groups_keep_their_kind_and_a_chain_shows_its_masses() -> None:
    chain = Structure(
        name="chain",
        nodes=((1.0, 0.0), (2.0, 0.0)),
        elements=(Spring((1,), "x", 1.0), Spring((1, 2), "x", 1.0)),
        point_masses=(PointMass(1, 1.0), PointMass(2, 1.0)),
        directions=("x",),
    )
    shape = outline(chain)
    assert shape.masses == (0, 1)
    assert shape.grounded == ((0, "x"),)
    assert [(group.name, group.kind, group.ends.tolist()) for group in shape.groups] == [("spring", "spring", [[0, 1]])]
    np.testing.assert_array_equal(nodal_motion(shape, np.array([0.1, 0.2])), [[0.1, 0, 0], [0.2, 0, 0]])


def matrices(stiffness: FloatArray, coordinates: FloatArray) -> LinearModel:
    count = len(coordinates)
    dofs = DofMap(np.arange(1, count + 1), np.full(count, "x"), np.ones(count, dtype=bool))
    sparse = csr_array(stiffness)
    return LinearModel(sparse, sparse, sparse, dofs, coordinates)


def test_a_spring_in_a_support_s_place_is_drawn_as_a_spring() -> None:
    structure = cantilever(1.0).with_effects(SupportSpring(1, "rz", 5.0), SupportSpring(2, "y", 3.0))
    shape = outline(structure)
    assert shape.supports == (Support(1, ("x", "y")),)
    assert shape.grounded == ((0, "rz"), (1, "y"))
    assert [group.kind for group in shape.groups] == ["beam"]


def test_imported_matrices_show_nodes_and_what_the_stiffness_couples() -> None:
    stiffness = np.array([[2.0, -1, 0], [-1, 2, -1], [0, -1, 1]])
    lines, points = outline(matrices(stiffness, np.array([[0.0, 0], [1, 0], [2, 1]]))).groups
    assert (lines.kind, lines.ends.tolist()) == ("cable", [[0, 1], [1, 2]])
    assert (points.kind, len(points.ends)) == ("point", 3)


def test_imported_matrices_of_a_frame_are_drawn_bent_and_held_as_the_structure_is() -> None:
    frame = Structure(
        "frame",
        ((0.0, 0.0), (0.0, 3.0), (4.0, 3.0), (4.0, 0.0)),
        (Beam((1, 2), STEEL), Beam((2, 3), STEEL), Beam((4, 3), STEEL), Cable((2, 4), STEEL)),
        supports=(Support(1, ("x", "y", "rz")), Support(4, ("x",))),
    )
    model = linearise(frame)
    mode = natural_modes(model, 1).shapes[:, 0]
    shape = outline(model)
    assert {support.node: support.directions for support in shape.supports} == {1: ("x", "y", "rz"), 4: ("x",)}
    groups = {group.kind: group.ends.tolist() for group in shape.groups}
    assert groups["cable"] == [[1, 3]]
    assert groups["beam"] == [[1, 2], [2, 3]]  # what goes to a clamped node is in no free row
    drawn = {lines.kind: lines for lines in deformed_lines(shape, mode, 1.0)}
    own = deformed_lines(outline(frame), mode, 1.0)[0].points
    np.testing.assert_allclose(drawn["beam"].points[0], own[1], atol=ROUNDING)


def test_condensed_matrices_show_nodes_only() -> None:
    stiffness = np.ones((12, 12)) + 12 * np.eye(12)  # every node coupled with every other
    (points,) = outline(matrices(stiffness, np.random.default_rng(0).normal(size=(12, 2)))).groups
    assert points.kind == "point"


def test_nodes_all_at_one_place_are_spread_out() -> None:
    shape = outline(matrices(np.eye(3), np.zeros((3, 2))))
    assert len(np.unique(shape.coordinates, axis=0)) == 3


@pytest.mark.parametrize("bad", [np.zeros(5), np.zeros((6, 1)), np.array([0, 0, 0, np.nan, 0, 0])])
def test_displacements_that_do_not_fit_are_refused(bad: FloatArray) -> None:
    with pytest.raises(InputError, match="each of the model's 6 degrees of freedom"):
        nodal_motion(outline(cantilever(1.0)), bad)
