"""Which row of a vector over all degrees of freedom belongs to which node and direction, and which rows are free."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from fe_models.arrays import BoolArray, FloatArray, IntArray


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

    def pull(self, pulls: Iterable[tuple[int, str, float]]) -> FloatArray:
        """Return the coefficients (dof,) of an elongation, the sum of c u(node, direction) of ``pulls``; `KeyError`
        where the model has no such degree of freedom.
        """
        full = np.zeros(len(self))
        for node, direction, coefficient in pulls:
            full[self.row(node, direction)] += coefficient
        return full
