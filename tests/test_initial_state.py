"""Modal states from displacements and velocities that the user gives at some nodes."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize

from fe_models.assembly import linearise
from fe_models.built_in.four_dof import four_dof
from fe_models.errors import InputError
from fe_models.modes import natural_modes
from hybrid.estimation.given_state import NodalState, modal_state, read_nodal_state
from tests.hybrid_problems import STIFFNESS

MODAL = natural_modes(linearise(four_dof()), 4)
HEADER = "node,direction,displacement,velocity\n"


def test_a_state_at_all_nodes_comes_back() -> None:
    rng = np.random.default_rng(0)
    u, v = rng.standard_normal((2, 4))
    q, q_dot = modal_state(NodalState((0, 1, 2, 3), u, v), MODAL)
    np.testing.assert_allclose(MODAL.shapes @ q, u, atol=1e-12)  # as many rows as modes: exact but for rounding
    np.testing.assert_allclose(MODAL.shapes @ q_dot, v, atol=1e-12)


def test_of_all_shapes_through_one_point_the_softest_is_taken() -> None:
    """A static pull at that node gives it: least strain energy 1/2 sum (omega q)^2 under one displacement."""
    q, _ = modal_state(NodalState((2,), np.array([0.7]), np.zeros(1)), MODAL)
    constraint = {"type": "eq", "fun": lambda x: MODAL.shapes[2] @ x - 0.7}
    softest = minimize(lambda x: np.sum((MODAL.omega * x) ** 2), np.zeros(4), constraints=constraint, tol=1e-12)
    np.testing.assert_allclose(q, softest.x, atol=1e-5)  # the optimiser's own accuracy
    stiffness = linearise(four_dof()).stiffness.toarray()
    pulled = np.linalg.solve(stiffness, np.eye(4)[2])
    np.testing.assert_allclose(MODAL.shapes @ q, 0.7 * pulled / pulled[2], atol=1e-12)


def test_of_all_velocities_the_one_with_the_least_kinetic_energy_is_taken() -> None:
    """The unloaded masses stand still: 1/2 sum q'^2 = 1/2 v^T M v, and M is diagonal."""
    _, q_dot = modal_state(NodalState((1, 3), np.zeros(2), np.array([0.5, -2.0])), MODAL)
    np.testing.assert_allclose(MODAL.shapes @ q_dot, [0, 0.5, 0, -2.0], atol=1e-12)


def test_two_points_are_joined_by_the_shape_of_two_forces() -> None:
    """U = K^-1 B (B^T K^-1 B)^-1 d, Lagrange's conditions by hand."""
    B, d = np.eye(4)[:, [0, 3]], np.array([0.3, -0.1])
    flexible = np.linalg.solve(STIFFNESS, B)
    expected = flexible @ np.linalg.solve(B.T @ flexible, d)
    q, _ = modal_state(NodalState((0, 3), d, np.zeros(2)), MODAL)
    np.testing.assert_allclose(MODAL.shapes @ q, expected, atol=1e-12)


@pytest.mark.parametrize("rows", [(0, 2), (0, 1, 2, 3)])
def test_as_many_points_as_modes_or_more_that_agree_give_the_modes_exactly(rows: tuple[int, ...]) -> None:
    """Of two modes, from two points and from four."""
    two = replace(MODAL, omega=MODAL.omega[:2], damping_ratio=MODAL.damping_ratio[:2], shapes=MODAL.shapes[:, :2])
    q, q_dot = np.array([0.7, -0.3]), np.array([-0.2, 1.1])
    shapes = two.shapes[list(rows)]
    found = modal_state(NodalState(rows, shapes @ q, shapes @ q_dot), two)
    np.testing.assert_allclose(found, (q, q_dot), atol=1e-12)


def test_points_that_contradict_the_modes_are_met_by_least_squares() -> None:
    """What is left over is at right angles to both modes."""
    two = replace(MODAL, omega=MODAL.omega[:2], damping_ratio=MODAL.damping_ratio[:2], shapes=MODAL.shapes[:, :2])
    u, v = np.random.default_rng(1).standard_normal((2, 4))
    q, q_dot = modal_state(NodalState((0, 1, 2, 3), u, v), two)
    np.testing.assert_allclose(two.shapes.T @ (u - two.shapes @ q), 0, atol=1e-12)
    np.testing.assert_allclose(two.shapes.T @ (v - two.shapes @ q_dot), 0, atol=1e-12)


def test_a_file_is_read(tmp_path: Path) -> None:
    path = tmp_path / "state.csv"
    path.write_text(HEADER + "4,x,0.1,0\n2,x,-0.2,1.5\n")
    state = read_nodal_state(path, MODAL)
    assert state.rows == (3, 1)
    np.testing.assert_array_equal(state.displacement, [0.1, -0.2])
    np.testing.assert_array_equal(state.velocity, [0.0, 1.5])


def test_all_faults_of_a_file_come_at_once(tmp_path: Path) -> None:
    path = tmp_path / "state.csv"
    rows = ("9,x,0.1,0", "2,y,0,0", "", "two,x,0,0", "1,x,0,0", "3,x,much,0", "3", "4,x,0,nan", "1,x,1,0", "2,x,0,1,5")
    path.write_text(HEADER + "\n".join(rows))
    words = {
        2: "node 9 has no",
        3: "node 2 has no degree of freedom 'y'",
        5: "whole number",
        7: "found 3,x,much,0",
        8: "found 3",
        9: "not finite",
        10: "given before",
        11: "decimal points",  # 0,1 and 5 of somebody who writes decimal commas
    }
    with pytest.raises(InputError) as caught:
        read_nodal_state(path, MODAL)
    for (line, word), fault in zip(words.items(), caught.value.faults, strict=True):
        assert f"state.csv: line {line}: " in fault
        assert word in fault


def test_a_support_moves_only_by_nothing(tmp_path: Path) -> None:
    held = replace(MODAL.dofs, free=np.array([True, True, True, False]))
    modal = replace(MODAL, dofs=held, shapes=MODAL.shapes * held.free[:, None])
    path = tmp_path / "state.csv"
    path.write_text(HEADER + "1,x,0.1,0\n4,x,0,0\n")
    assert read_nodal_state(path, modal).rows == (0, 3)
    path.write_text(HEADER + "1,x,0.1,0\n4,x,0,0.2\n")
    with pytest.raises(InputError, match="line 3: node 4 is held in x by a support"):
        read_nodal_state(path, modal)


def test_columns_may_come_in_any_order_and_from_a_spreadsheet(tmp_path: Path) -> None:
    """With a byte-order mark, blanks, carriage returns and empty lines."""
    path = tmp_path / "state.csv"
    path.write_bytes("\ufeffvelocity, node,direction ,displacement\r\n\r\n1.5, 2, x ,-0.2\r\n\r\n".encode())
    state = read_nodal_state(path, MODAL)
    assert (state.rows, state.displacement.tolist(), state.velocity.tolist()) == ((1,), [-0.2], [1.5])


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.csv: no such file"):
        read_nodal_state(tmp_path / "none.csv", MODAL)


@pytest.mark.parametrize("text", ["", HEADER, "node,x\n1,2\n", "\x00\x01"])
def test_other_files_are_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "state.csv"
    path.write_text(text)
    with pytest.raises(InputError, match=r"state\.csv"):
        read_nodal_state(path, MODAL)


def test_numbers_must_be_finite(tmp_path: Path) -> None:
    path = tmp_path / "state.csv"
    path.write_text(HEADER + "1,x,nan,0\n")
    with pytest.raises(InputError, match="not finite"):
        read_nodal_state(path, MODAL)
