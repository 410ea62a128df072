"""Matrices in space that tests share, assembled by textbook formulas, apart from what the project assembles itself."""

import numpy as np

from fe_models.arrays import FloatArray

FOLLOWED = 4  # the node that a rigid link joins to node 2
FIRST_ROOT = 1.8751040687119611  # of cos b cosh b = -1: a clamped and free beam


def bending(E: float, inertia: float, per_length: float, length: float) -> tuple[FloatArray, FloatArray]:
    """Return K and consistent M (4, 4) of a beam in one plane: v1, r1, v2, r2 (Przemieniecki, 1968, ch. 5 and 11)."""
    L = length
    K = np.array(
        [
            [12, 6 * L, -12, 6 * L],
            [6 * L, 4 * L**2, -6 * L, 2 * L**2],
            [-12, -6 * L, 12, -6 * L],
            [6 * L, 2 * L**2, -6 * L, 4 * L**2],
        ]
    )
    M = np.array(
        [
            [156, 22 * L, 54, -13 * L],
            [22 * L, 4 * L**2, 13 * L, -3 * L**2],
            [54, 13 * L, 156, -22 * L],
            [-13 * L, -3 * L**2, -22 * L, 4 * L**2],
        ]
    )
    return E * inertia / L**3 * K, per_length * L / 420 * M


def cantilever_arrays(elements: int) -> tuple[dict[str, np.ndarray], float, float]:
    """Return the arrays of a cantilever along x that bends in z and in y, and its first natural frequency in each,
    rad/s.
    """
    E, weak, strong, per_length, span = 2.1e11, 1e-8, 4e-8, 3.0, 2.0
    length = span / elements
    directions = ("y", "rz", "z", "ry")
    size = 4 * (elements + 1)
    K, M = np.zeros((size, size)), np.zeros((size, size))
    for element in range(elements):
        for offset, inertia, sign in ((0, strong, 1.0), (2, weak, -1.0)):  # ry turns z the other way round
            turn = np.diag([1.0, sign, 1.0, sign])
            own = [4 * element + offset, 4 * element + offset + 1, 4 * element + 4 + offset, 4 * element + 5 + offset]
            stiff, mass = (turn @ part @ turn for part in bending(E, inertia, per_length, length))
            K[np.ix_(own, own)] += stiff
            M[np.ix_(own, own)] += mass
    free = np.arange(4, size)
    arrays = {
        "K": K[np.ix_(free, free)],
        "M": M[np.ix_(free, free)],
        "nodes": np.column_stack([np.linspace(0, span, elements + 1), np.zeros((elements + 1, 2))]),
        "dof_node": free // 4 + 1,
        "dof_direction": np.array([directions[row % 4] for row in free]),
    }
    first = [(FIRST_ROOT / span) ** 2 * np.sqrt(E * inertia / per_length) for inertia in (weak, strong)]
    return arrays, float(first[0]), float(first[1])


def two_storeys() -> dict[str, np.ndarray]:
    """Return two rigid floors on springs, each with x, y and rz, node 4 at a corner of the lower one."""
    one = np.diag([4e5, 9e5, 5e6])
    K_1, K_2 = np.zeros((6, 6)), np.kron(np.array([[1.0, -1.0], [-1.0, 1.0]]), 0.8 * one)
    K_1[:3, :3] = one
    M_1, M_2 = np.diag([1e3, 1e3, 4e3, 0, 0, 0]), np.diag([0, 0, 0, 8e2, 8e2, 3e3])
    return {
        "K": K_1 + K_2,
        "M": M_1 + M_2,
        "K_1": K_1,
        "K_2": K_2,
        "M_1": M_1,
        "M_2": M_2,
        "groups": np.array(["storey 1", "storey 2"]),
        "nodes": np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 3.0], [0.0, 0.0, 6.0], [2.0, 1.0, 3.0]]),
        "dof_node": np.array([2, 2, 2, 3, 3, 3]),
        "dof_direction": np.array(["x", "y", "rz"] * 2),
        "rigid_links": np.array([[2, FOLLOWED]]),
        "lines": np.array([[1, 2], [2, 3]]),
        "modal_ratios": np.array([0.01]),
    }
