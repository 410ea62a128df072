"""A structure in few modes, as forces on it and sensors meet it."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from fe_models.arrays import FloatArray
from hybrid.diagnosis.response.dashpots import Trailing


@dataclass(frozen=True)
class ReducedModel:
    """``mass``, ``damping``, ``stiffness`` (variant, mode, mode) and ``shapes`` (variant, dof, mode) of the modes, the
    mass that a moving base carries along in them, ``carried`` (variant, mode, load), zero of other loads, and what is
    ``trailing`` them, None where nothing does.
    """

    mass: FloatArray
    damping: FloatArray
    stiffness: FloatArray
    shapes: FloatArray
    carried: FloatArray
    trailing: Trailing | None = None

    def feed(self, pulls: list[FloatArray], inverse: Any) -> FloatArray:
        """Return the accelerations (variant, mode, force) by unit forces along ``pulls`` (dof,); see `fed`."""
        feed = np.zeros((*self.mass.shape[:2], len(pulls)))
        for number, pull in enumerate(pulls):
            feed[:, :, number] = self.fed(pull, inverse)
        return feed

    def fed(self, pull: FloatArray, inverse: Any) -> FloatArray:
        """Return the accelerations (variant, mode) by a unit force along ``pull`` (dof,); ``inverse`` of the mass."""
        return np.asarray(np.einsum("pij,pj->pi", inverse, pull @ self.shapes))
