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
        return np.asarray(products(coordinates / self.size, self.powers) @ self.forces)

    def bent_at(self, coordinates: FloatArray, rows: FloatArray) -> FloatArray:
        """Return what ``rows`` (sensor, dof) show of what gives way (..., sensor) at modal ``coordinates``."""
        return np.asarray(products(coordinates / self.size, self.powers) @ (self.bends @ rows.T))


def products(scaled: FloatArray, powers: IntArray) -> FloatArray:
    """Return the products (..., product) of ``scaled`` coordinates (..., mode) with ``powers`` (product, mode)."""
    found = np.ones((*scaled.shape[:-1], len(powers)))
    for mode in range(scaled.shape[-1]):
        for degree in range(1, int(powers.max()) + 1):
            found[..., powers[:, mode] == degree] *= scaled[..., mode, None] ** degree
    return found
