"""Forces that a frame's geometry adds to the elastic ones: what bends is stretched, what sways is shortened.

The nominal model exerts them itself, so they are no cause of their own. They are quadratic and cubic in the modal
coordinates, and small.
"""

from dataclasses import dataclass

import numpy as np

from fe_models.arrays import FloatArray, IntArray


@dataclass(frozen=True)
class Geometry:
    """Geometric forces in the nominal modes that are followed, on top of the elastic ones.

    ``weighted`` (dof, mode): M phi, which picks modal coordinates and distributes modal forces; ``size`` (mode,): rms
    of the coordinates; ``powers`` (product, mode); for each product of coordinates in units of ``size``, ``forces``
    (product, mode), modal forces, and ``bends`` (product, dof), m, what gives way in modes that are not followed.
    """

    weighted: FloatArray
    size: FloatArray
    powers: IntArray
    forces: FloatArray
    bends: FloatArray

    def at(self, coordinates: FloatArray) -> FloatArray:
        """Return the modal forces (..., mode) at modal ``coordinates`` (..., mode)."""
        return self._sum(coordinates, self.forces)

    def bent_at(self, coordinates: FloatArray, rows: FloatArray) -> FloatArray:
        """Return what ``rows`` (sensor, dof) show of what gives way (..., sensor) at modal ``coordinates``."""
        return self._sum(coordinates, self.bends @ rows.T)

    def _sum(self, coordinates: FloatArray, weights: FloatArray) -> FloatArray:
        """Return the sums (..., entry) of all products at ``coordinates`` (..., mode) times their ``weights`` (product,
        entry).
        """
        scaled = (coordinates / self.size).reshape(-1, len(self.size))
        return np.asarray(products(scaled, self.powers) @ weights).reshape(*coordinates.shape[:-1], weights.shape[1])


def products(scaled: FloatArray, powers: IntArray) -> FloatArray:
    """Return the products (point, product) of ``scaled`` coordinates (point, mode) with ``powers`` (product, mode)."""
    rows = np.ascontiguousarray(scaled.T)  # one coordinate of all points after the other
    found = np.ones((len(powers), len(scaled)))
    for product, degrees in zip(found, powers, strict=True):
        for mode in np.repeat(np.arange(len(degrees)), degrees):
            product *= rows[mode]
    return found.T
