"""Forces of laws along motions that a filter knows: of what the motion is there, or of the way that led there."""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fe_models.arrays import TINY, FloatArray
from hybrid.diagnosis.discrepancy.hysteresis import Hysteresis

SLOPE_STEP = 1e-5  # of the rms elongation, or rate


@dataclass(frozen=True, eq=False)
class LawForce(ABC):
    """A force along ``pull`` (dof,)."""

    pull: FloatArray

    @abstractmethod
    def along(self, u: FloatArray, v: FloatArray) -> FloatArray:
        """Return the force (part,), N, by which elongations and rates (part,), one after the other, are pulled back."""


@dataclass(frozen=True, eq=False)
class DirectForce(LawForce):
    """A force of elongation and rate (part,), each by itself."""

    force: Callable[[FloatArray, FloatArray], FloatArray]

    def along(self, u: FloatArray, v: FloatArray) -> FloatArray:
        """Return the force (part,)."""
        return self.force(u, v)

    def slopes(self, u: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the slopes (part,) by elongation and rate."""
        steps = [SLOPE_STEP * max(float(np.std(part)), TINY) for part in (u, v)]
        by_u = (self.force(u + steps[0], v) - self.force(u - steps[0], v)) / (2 * steps[0])
        by_v = (self.force(u, v + steps[1]) - self.force(u, v - steps[1])) / (2 * steps[1])
        return by_u, by_v


@dataclass(frozen=True, eq=False)
class RememberedForce(LawForce):
    """The force of a spring with ``hysteresis``."""

    hysteresis: Hysteresis

    def along(self, u: FloatArray, v: FloatArray) -> FloatArray:
        """Return the force (part,)."""
        return np.asarray(self.hysteresis.spring.force_of(self.hysteresis.along(u).z))
