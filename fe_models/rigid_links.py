"""Degrees of freedom that follow others: those of a node that a rigid link joins to another one.

    u_s = u_m + theta_m x (r_s - r_m),   theta_s = theta_m

(small rotations), with r the places of the node that leads, m, and of the one that follows, s.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.sparse import csr_array, vstack

from fe_models.arrays import FloatArray, IntArray
from fe_models.dof_map import DofMap
from fe_models.structure import ROTATIONS, TRANSLATIONS

Dof = tuple[int, str]


@dataclass(frozen=True)
class Linked:
    """Node and direction of each of the ``dofs`` that follow, and their motion for that of each free one, ``motion``
    (linked, free); None where none follows.
    """

    dofs: tuple[Dof, ...] = ()
    motion: csr_array | None = field(default=None)

    def and_those_of(self, other: "Linked") -> "Linked":
        """Return these and those of an ``other`` table."""
        motions = [motion for motion in (self.motion, other.motion) if motion is not None]
        return Linked((*self.dofs, *other.dofs), csr_array(vstack(motions)) if motions else None)

    def faults(self, known: Sequence[Dof], free: int) -> list[str]:
        """Return what does not fit a model with the ``known`` degrees of freedom, ``free`` of them free."""
        if self.motion is None:
            return []
        expected = (len(self.dofs), free)
        if self.motion.shape != expected:
            return [f"T, the motion of what is linked, is {self.motion.shape}; expected {expected}, (linked, row)"]
        have = set(known)
        twice = [
            f"node {node} in {direction} is linked, and has a row of its own"
            for node, direction in self.dofs
            if (node, direction) in have
        ]
        return twice if np.isfinite(self.motion.data).all() else [*twice, "T holds numbers that are not finite"]

    def joined(self, dofs: DofMap, free: int) -> DofMap:
        """Return the degrees of freedom with those that follow behind them."""
        if self.motion is None or not self.dofs:
            return dofs
        nothing = csr_array((len(dofs), free))
        return replace(
            dofs,
            node=np.append(dofs.node, [node for node, _ in self.dofs]),
            direction=np.append(dofs.direction, [direction for _, direction in self.dofs]),
            free=np.append(dofs.free, np.zeros(len(self.dofs), dtype=bool)),
            links=csr_array(vstack([nothing, self.motion])),
        )


def rigidly_linked(
    links: IntArray, nodes: FloatArray, dofs: Sequence[Dof], everywhere: Sequence[Dof]
) -> tuple[Linked, list[str]]:
    """Return how nodes follow others by rigid ``links`` (link, 2), numbers of the leading node and of the one that
    follows, and what is wrong with them. ``nodes`` (node, 2 or 3) in m; ``dofs``: of the rows, ``everywhere``: of all.

    A direction of which the node that follows has a row of its own is not linked; nor one that the leading node lacks.
    """
    faults = _link_faults(links, len(nodes))
    if faults:
        return Linked(), faults
    rows, known = {dof: number for number, dof in enumerate(dofs)}, set(everywhere)
    places = np.zeros((len(nodes), 3))
    places[:, : nodes.shape[1]] = nodes
    followed, entries = list[Dof](), list[tuple[int, int, float]]()
    for leading, following in links.tolist():
        arm = places[following - 1] - places[leading - 1]
        for direction in (*TRANSLATIONS, *ROTATIONS):
            if (leading, direction) not in known or (following, direction) in known:
                continue
            for own, part in _moved_by(direction, arm):
                if (leading, own) in rows and part:
                    entries.append((len(followed), rows[leading, own], part))
            followed.append((following, direction))
    number, row, values = np.array(entries, dtype=float).reshape(-1, 3).T
    indices = number.astype(np.int64), row.astype(np.int64)
    return Linked(tuple(followed), csr_array((values, indices), shape=(len(followed), len(dofs)))), []


def _moved_by(direction: str, arm: FloatArray) -> list[tuple[str, float]]:
    """Return which of the leading node's directions move the other one in a ``direction``, and by how much of each."""
    if direction in ROTATIONS:
        return [(direction, 1.0)]
    axis = TRANSLATIONS.index(direction)
    turns = np.cross(np.eye(3), arm)  # (rotation, axis): theta x arm of a unit rotation about each axis
    return [(direction, 1.0), *((name, float(turns[number, axis])) for number, name in enumerate(ROTATIONS))]


def _link_faults(links: IntArray, nodes: int) -> list[str]:
    if links.ndim != 2 or links.shape[1] != 2:
        return [f"rigid_links has shape {links.shape}; expected (link, 2): the leading node and the one that follows"]
    if links.min() < 1 or links.max() > nodes:
        return [f"rigid_links names nodes {links.min()} to {links.max()}; coordinates are given for nodes 1 to {nodes}"]
    following = links[:, 1].tolist()
    faults = [
        f"node {node} follows {following.count(node)} nodes; one can lead it"
        for node in dict.fromkeys(following)
        if following.count(node) > 1
    ]
    chained = sorted(set(following) & set(links[:, 0].tolist()))
    return faults + [f"node {node} leads others and follows one; let all follow the first" for node in chained]
