"""Which row of a vector over all degrees of freedom belongs to which node and direction, and which rows are free.

A rigid link makes degrees of freedom follow others: u = T q, with q those that are free and u all of them.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from fe_models.arrays import BoolArray, FloatArray, IntArray


@dataclass(frozen=True)
class DofMap:
    """``node`` (dof,) 1-based, ``direction`` (dof,) "x", "y", "z", "rx", "ry" or "rz", ``free`` (dof,): False where a
    support, or a rigid link, holds. ``links``: T (dof, free) of those that follow others, zero in the rows of all the
    others; None without.
    """

    node: IntArray
    direction: NDArray[np.str_]
    free: BoolArray
    links: csr_array | None = None

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

    @property
    def moves(self) -> BoolArray:
        """Which degrees of freedom move (dof,): the free ones, and those that follow them."""
        return self.free if self.links is None else self.free | (np.diff(self.links.indptr) > 0)

    def released(self) -> "DofMap":
        """Return the same degrees of freedom as if no support held any."""
        return replace(self, free=np.ones(len(self), dtype=bool), links=None)

    def expand(self, free_values: FloatArray) -> FloatArray:
        """Return the motion (dof, ...) of all degrees of freedom from that of the free ones (free, ...)."""
        full = np.zeros((len(self), *free_values.shape[1:]))
        full[self.free] = free_values
        if self.links is not None:
            full += (self.links @ free_values.reshape(len(free_values), -1)).reshape(full.shape)
        return full

    def gathered(self, forces: FloatArray) -> FloatArray:
        """Return forces (dof, ...) as those that do the same work on the free degrees of freedom, (free, ...)."""
        own = np.asarray(forces[self.free])
        if self.links is None:
            return own
        return np.asarray(own + (self.links.T @ forces.reshape(len(self), -1)).reshape(own.shape))

    def pull(self, pulls: Iterable[tuple[int, str, float]]) -> FloatArray:
        """Return the coefficients (dof,) of an elongation, the sum of c u(node, direction) of ``pulls``; `KeyError`
        where the model has no such degree of freedom.
        """
        full = np.zeros(len(self))
        for node, direction, coefficient in pulls:
            full[self.row(node, direction)] += coefficient
        return full
