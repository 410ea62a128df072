"""The mesh keeps the drawn geometry and the numbering, whatever its refinement."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fe_models.dofs import structure_dofs
from fe_models.mesh import FiniteElement, mesh, nodes_in_finer
from fe_models.sections import Section
from fe_models.structure import Beam, Cable, Spring, Structure, Support

STEEL = Section("steel", 2.1e11, 7850.0, 1e-4, 1e-9)


def portal() -> Structure:
    """Two beams in a row over a cable and a spring to ground."""
    return Structure(
        name="portal",
        nodes=((0.0, 0.0), (3.0, 4.0), (6.0, 4.0)),
        elements=(Beam((1, 2), STEEL), Cable((1, 3), STEEL), Beam((3, 2), STEEL), Spring((3,), "y", 5.0)),
        supports=(Support(1, ("x", "y", "rz")), Support(3, ("y",))),
    )


def test_unrefined_mesh_is_the_structure() -> None:
    result = mesh(portal())
    np.testing.assert_array_equal(result.coordinates, portal().nodes)
    assert [element.nodes for element in result.elements] == [(1, 2), (1, 3), (3, 2), (3,)]
    assert [element.parent for element in result.elements] == [1, 2, 3, 4]


def test_beams_split_in_their_own_direction_and_nothing_else_does() -> None:
    result = mesh(portal().refined(3))
    assert result.elements == (
        FiniteElement((1, 4), 1),
        FiniteElement((4, 5), 1),
        FiniteElement((5, 2), 1),
        FiniteElement((1, 3), 2),
        FiniteElement((3, 6), 3),
        FiniteElement((6, 7), 3),
        FiniteElement((7, 2), 3),
        FiniteElement((3,), 4),
    )
    # Thirds of a 3-4-5 triangle and of the beam from x = 6 back to x = 3; equal to rounding.
    expected = [(1, 4 / 3), (2, 8 / 3), (5, 4), (4, 4)]
    np.testing.assert_allclose(result.coordinates[3:], expected, rtol=1e-15)


@given(divisions=st.integers(1, 12))
def test_lengths_add_up_and_every_node_is_used(divisions: int) -> None:
    structure = portal().refined(divisions)
    result = mesh(structure)
    lengths = np.zeros(len(structure.elements))
    used: set[int] = set()
    for element in result.elements:
        used.update(element.nodes)
        if len(element.nodes) == 2:
            first, last = (result.coordinates[node - 1] for node in element.nodes)
            lengths[element.parent - 1] += np.hypot(*(last - first))
    np.testing.assert_allclose(lengths, [5.0, np.hypot(6, 4), 3.0, 0.0], rtol=1e-14)  # a dozen roundings
    assert used == set(range(1, len(result.coordinates) + 1))
    assert len(result.dofs) == 3 * len(result.coordinates)


def test_dofs_are_ordered_by_node_and_held_at_supports() -> None:
    dofs = structure_dofs(portal().refined(2))
    assert dofs.node.tolist() == [1] * 3 + [2] * 3 + [3] * 3 + [4] * 3 + [5] * 3
    assert dofs.direction.tolist() == ["x", "y", "rz"] * 5
    assert np.flatnonzero(~dofs.free).tolist() == [0, 1, 2, 7]
    assert dofs.row(3, "y") == 7


def test_a_chain_has_one_direction() -> None:
    chain = Structure("chain", ((0.0, 0.0), (1.0, 0.0)), (Spring((1, 2), "x", 1.0),), directions=("x",))
    dofs = structure_dofs(chain)
    assert dofs.direction.tolist() == ["x", "x"]
    with pytest.raises(KeyError, match="no degree of freedom 'y'"):
        dofs.row(1, "y")


@given(divisions=st.integers(1, 5), times=st.integers(1, 5))
def test_a_finer_mesh_has_the_nodes_of_a_coarser_one_where_asked_for(divisions: int, times: int) -> None:
    coarse, fine = mesh(portal().refined(divisions)), mesh(portal().refined(times * divisions))
    found = fine.coordinates[nodes_in_finer(portal().refined(divisions), times) - 1]
    np.testing.assert_allclose(found, coarse.coordinates, rtol=1e-14)


def test_pull_of_an_elongation_adds_up_its_coefficients() -> None:
    dofs = structure_dofs(portal())
    pull = dofs.pull([(1, "x", 2.0), (3, "rz", -1.0), (1, "x", 0.5)])
    assert (pull[dofs.row(1, "x")], pull[dofs.row(3, "rz")]) == (2.5, -1.0)
    assert np.count_nonzero(pull) == 2
    with pytest.raises(KeyError, match="node 9 has no degree of freedom 'y'"):
        dofs.pull([(1, "x", 1.0), (9, "y", 1.0)])
