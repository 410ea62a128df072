"""The damping of Levenberg and Marquardt's steps: how large it begins, and what a step makes of it.

A step solves (H + damping D) step = gradient, with H the Gauss-Newton matrix J^T J and D its diagonal (Marquardt, J.
SIAM 11, 1963, 431-441). A step that lowers the cost is taken and eases the damping; one that does not is taken back
and tightens it.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import inf
from typing import Any


@dataclass(frozen=True)
class Damping:
    """The damping begins at ``first``; a step that leads down divides it by ``easing``, another one multiplies it by
    ``tightening``. Beyond ``most`` nothing is tried any more.

    ``free``: where it is given, what stands for no damping at all: where a search begins and where easing leads from
    ``first``, from where tightening leads to ``first``.
    """

    first: float
    easing: float
    tightening: float
    most: float = inf
    free: float | None = None

    @property
    def start(self) -> float:
        """The damping of a search's first step."""
        return self.first if self.free is None else self.free

    def eased(self, damping: float) -> float:
        """Return the damping after a step that led down."""
        return damping / self.easing if self.free is None or damping > self.first else self.free

    def tightened(self, damping: float) -> float:
        """Return the damping after a step that did not."""
        return damping * self.tightening if self.free is None else max(damping * self.tightening, self.first)

    def tries(self, damping: float) -> Iterator[float]:
        """Yield the damping of one step after the other, as long as none of them leads down."""
        while damping < self.most:
            yield damping
            damping = self.tightened(damping)

    def after(self, damping: Any, better: Any) -> Any:
        """Return the damping (search,) of many searches at once, ``better`` (search,) where their steps led down.

        Arrays of NumPy or PyTorch; without ``free``.
        """
        return better * (damping / self.easing) + ~better * (damping * self.tightening)
