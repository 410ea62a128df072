"""What is drawn is the true deformed shape: exact beam curves, straight cables, a stated and sensible exaggeration."""

from math import cos, log10, pi, sin

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_array

from fe_models.arrays import FloatArray
from fe_models.dofs import DofMap, structure_dofs
from fe_models.effects import SupportSpring
from fe_models.errors import InputError
from fe_models.linear import LinearModel
from fe_models.mesh import mesh
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
