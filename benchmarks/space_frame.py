"""A tall frame building in space as matrices by groups, assembled from textbook elements: a large model to diagnose."""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csr_array

from fe_models.arrays import FloatArray, IntArray
from fe_models.dof_map import DofMap
from fe_models.linear import LinearModel, MatrixGroup

DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")
BAY, HEIGHT = 6.0, 3.5  # m, between columns and between floors
E, G, DENSITY = 3.3e10, 1.4e10, 2500.0  # Pa, Pa, kg/m^3: concrete
FLOOR_LOAD = 500.0  # kg/m^2, of slabs and what stands on them


@dataclass(frozen=True)
class Member:
    """A cross-section: ``area`` (m^2), ``torsion`` and second moments ``weak`` and ``strong`` (m^4)."""

    area: float
    torsion: float
    weak: float
    strong: float

    @classmethod
    def rectangle(cls, width: float, height: float) -> "Member":
        """Return a solid rectangle; its torsion constant is about 0.2 times width^3 height."""
        return cls(width * height, 0.2 * width**3 * height, height * width**3 / 12, width * height**3 / 12)


COLUMN, BEAM = Member.rectangle(0.9, 1.4), Member.rectangle(0.4, 0.8)  # else sway in x and y would be alike


def tall_frame(bays: int, floors: int, floors_a_group: int) -> LinearModel:
    """Return a square building of ``bays`` by ``bays`` columns, clamped at its foot, 1 % of damping in each mode.

    Groups: the columns and the floors of each ``floors_a_group`` floors.
    """
    places, index = _nodes(bays, floors)
    free = np.repeat(places[:, 2] > 0, len(DIRECTIONS))
    rows = np.cumsum(free) - 1
    groups = []
    for begin in range(0, floors, floors_a_group):
        levels = range(begin + 1, min(begin + floors_a_group, floors) + 1)
        for name, members, section in (
            ("columns", _columns(index, levels), COLUMN),
            ("floors", _beams(index, levels), BEAM),
        ):
            K, M = _assembled(places, members, section, free, rows)
            if name == "floors":
                M = M + _slabs(index, levels, free, rows)
            groups.append(MatrixGroup(f"{name} {levels[0]} to {levels[-1]}", csr_array(M), csr_array(K)))
    zero = csr_array((int(free.sum()),) * 2)
    nodes = np.arange(1, len(places) + 1)
    return LinearModel(
        mass=csr_array(sum((group.mass for group in groups), start=zero)),
        damping=zero,
        stiffness=csr_array(sum((group.stiffness for group in groups), start=zero)),
        dofs=DofMap(np.repeat(nodes, len(DIRECTIONS)), np.tile(DIRECTIONS, len(places)), free),
        coordinates=places,
        modal_ratios=(0.01,),
        groups=tuple(groups),
        lines=np.vstack([_columns(index, range(1, floors + 1)), _beams(index, range(1, floors + 1))]) + 1,
    )


def corner(bays: int, level: int, far: bool) -> int:
    """Return the number of a corner's node on a ``level``: at the origin, or ``far`` from it."""
    return level * bays**2 + (bays**2 if far else 1)


def _nodes(bays: int, floors: int) -> tuple[FloatArray, IntArray]:
    """Return the places (node, 3), m, and the number of each node by level, y and x, from 0."""
    level, y, x = np.meshgrid(np.arange(floors + 1), np.arange(bays), np.arange(bays), indexing="ij")
    index = np.arange(level.size).reshape(level.shape)
    return np.column_stack([BAY * x.ravel(), BAY * y.ravel(), HEIGHT * level.ravel()]), index


def _columns(index: IntArray, levels: range) -> IntArray:
    own = slice(levels[0], levels[-1] + 1)
    below = slice(levels[0] - 1, levels[-1])
    return np.column_stack([index[below].ravel(), index[own].ravel()])


def _beams(index: IntArray, levels: range) -> IntArray:
    own = index[levels[0] : levels[-1] + 1]
    along_x = np.column_stack([own[:, :, :-1].ravel(), own[:, :, 1:].ravel()])
    along_y = np.column_stack([own[:, :-1].ravel(), own[:, 1:].ravel()])
    return np.vstack([along_x, along_y])


def _slabs(index: IntArray, levels: range, free: np.ndarray, rows: IntArray) -> csr_array:
    """Return the floors' load as masses at their nodes, felt by translations."""
    nodes = index[levels[0] : levels[-1] + 1].ravel()
    dofs = (len(DIRECTIONS) * nodes[:, None] + np.arange(3)).ravel()
    own = rows[dofs[free[dofs]]]
    return csr_array((np.full(len(own), FLOOR_LOAD * BAY**2), (own, own)), shape=(int(free.sum()),) * 2)


def _assembled(
    places: FloatArray, members: IntArray, section: Member, free: np.ndarray, rows: IntArray
) -> tuple[csr_array, csr_array]:
    """Return K and M (free, free) of ``members`` (member, 2) of one section, which have a few directions in all."""
    axes = places[members[:, 1]] - places[members[:, 0]]
    found = []
    for axis in np.unique(axes, axis=0):
        own = members[(axes == axis).all(axis=1)]
        dofs = (len(DIRECTIONS) * own[:, :, None] + np.arange(len(DIRECTIONS))).reshape(len(own), 12)
        found += [(dofs, part) for part in [_element(axis, section)]]
    size = int(free.sum())
    total = [csr_array((size, size)), csr_array((size, size))]
    for dofs, parts in found:
        first, second = np.repeat(dofs, 12, axis=1).ravel(), np.tile(dofs, (1, 12)).ravel()
        kept = free[first] & free[second]
        for number, part in enumerate(parts):
            values = np.tile(part.ravel(), len(dofs))[kept]
            total[number] = total[number] + csr_array(
                coo_array((values, (rows[first[kept]], rows[second[kept]])), shape=(size, size))
            )
    return total[0], total[1]


def _element(axis: FloatArray, section: Member) -> tuple[FloatArray, FloatArray]:
    """Return K and M (12, 12), consistent, of an Euler-Bernoulli beam in space (Przemieniecki, 1968, ch. 5 and 11)."""
    L, along = float(np.linalg.norm(axis)), axis / np.linalg.norm(axis)
    up = np.array([0.0, 0.0, 1.0]) if abs(along[2]) < 0.9 else np.array([1.0, 0.0, 0.0])
    side = np.cross(up, along)
    turn = np.kron(np.eye(4), np.array([along, side, np.cross(along, side)]))
    K, M = np.zeros((12, 12)), np.zeros((12, 12))
    per_length, polar = DENSITY * section.area, DENSITY * (section.weak + section.strong)
    for dof, stiffness, mass in ((0, E * section.area, per_length), (3, G * section.torsion, polar)):
        own = np.ix_([dof, dof + 6], [dof, dof + 6])
        K[own] += stiffness / L * np.array([[1, -1], [-1, 1]])
        M[own] += mass * L / 6 * np.array([[2, 1], [1, 2]])
    # across: beams are stiff in bending about the side, which moves them up; a turn about the side lowers what is ahead
    for moved, turned, second, sign in ((1, 5, section.weak, 1.0), (2, 4, section.strong, -1.0)):
        own = np.ix_([moved, turned, moved + 6, turned + 6], [moved, turned, moved + 6, turned + 6])
        s = np.array([1.0, sign * L, 1.0, sign * L])
        K[own] += E * second / L**3 * np.outer(s, s) * _BENT
        M[own] += per_length * L / 420 * np.outer(s, s) * _CARRIED
    return turn.T @ K @ turn, turn.T @ M @ turn


_BENT = np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]])
_CARRIED = np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]])
