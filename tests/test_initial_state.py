"""Modal states from displacements and velocities that the user gives at some nodes."""

from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize

from fe_models.assembly import linearise
from fe_models.errors import InputError
from fe_models.four_dof import four_dof
from fe_models.modes import natural_modes
from hybrid.initial_state import NodalState, modal_state, read_nodal_state

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


def test_a_file_is_read(tmp_path: Path) -> None:
    path = tmp_path / "state.csv"
    path.write_text(HEADER + "4,x,0.1,0\n2,x,-0.2,1.5\n")
    state = read_nodal_state(path, MODAL)
    assert state.rows == (3, 1)
    np.testing.assert_array_equal(state.displacement, [0.1, -0.2])
    np.testing.assert_array_equal(state.velocity, [0.0, 1.5])


def test_all_faults_of_a_file_come_at_once(tmp_path: Path) -> None:
    path = tmp_path / "state.csv"
    path.write_text(HEADER + "9,x,0.1,0\n2,y,0,0\ntwo,x,0,0\n1,x,0,0\n3,x,much,0\n3\n")
    with pytest.raises(InputError) as caught:
        read_nodal_state(path, MODAL)
    assert [f"line {n}" in fault for n, fault in zip((2, 3, 4, 6, 7), caught.value.faults, strict=True)] == [True] * 5


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
