"""Which row of a vector over all degrees of freedom belongs to which node and direction, and which rows are free."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fe_models.arrays import BoolArray, FloatArray, IntArray
from fe_models.causes.laws import with_parts
from fe_models.structure import Beam, Structure


@dataclass(frozen=True)
class DofMap:
    """``node`` (dof,) 1-based, ``direction`` (dof,) "x", "y" or "rz", ``free`` (dof,): False where a support holds."""

    node: IntArray
    direction: NDArray[np.str_]
    free: BoolArray

    def __len__(self) -> int:
        return len(self.node)

    @property
    def free_rows(self) -> IntArray:
        """Rows of the free degrees of freedom, in order; shape (free,)."""
        return np.flatnonzero(self.free)

    def row(self, node: int, direction: str) -> int:
        """Return the row of one degree of freedom; `KeyError` where the model has none there."""
        hits = np.flatnonzero((self.node == node) & (self.direction == direction))
        if len(hits) != 1:
            raise KeyError(f"node {node} has no degree of freedom {direction!r}")
        return int(hits[0])

    def released(self) -> "DofMap":
        """Return the same degrees of freedom as if no support held any."""
        return replace(self, free=np.ones(len(self), dtype=bool))

    def expand(self, free_values: FloatArray) -> FloatArray:
        """Return values (free, ...) as (dof, ...) with zeros at the supports."""
        full = np.zeros((len(self), *free_values.shape[1:]))
        full[self.free] = free_values
        return full


def structure_dofs(structure: Structure) -> DofMap:
    """Return the degrees of freedom of a structure and of the nodes that its refinement adds, supports marked as held.

    Node by node, each with all ``structure.directions`` in their order; first the nodes of the structure, then the
    ``divisions - 1`` inner nodes of each beam, element by element (the numbering of `mesh.mesh`). What a support holds
    is free where an effect puts a spring in the support's place.
    """
    beams = sum(isinstance(element, Beam) for element in structure.elements)
    nodes = len(structure.nodes) + beams * (structure.divisions - 1)
    per_node = len(structure.directions)
    free = np.ones((nodes, per_node), dtype=bool)
    for support in with_parts(structure).supports:
        for direction in support.directions:
            free[support.node - 1, structure.directions.index(direction)] = False
    return DofMap(
        node=np.repeat(np.arange(1, nodes + 1, dtype=np.int64), per_node),
        direction=np.tile(np.array(structure.directions, dtype=np.str_), nodes),
        free=free.ravel(),
    )
