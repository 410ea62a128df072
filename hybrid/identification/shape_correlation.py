"""Where shapes differ: the coordinate modal assurance criterion of each sensor.

    CoMAC_s = (sum over modes |a_s b_s|)^2 / (sum a_s^2  sum b_s^2)

over pairs of shapes a, b of unit norm (Lieven and Ewins, IMAC VI, 1988): one where a sensor moves as it should in all
modes. It says where two sets of shapes differ, which need not be where the structure does.
"""

import numpy as np

from fe_models.arrays import TINY, FloatArray


def coordinate_mac(shapes: FloatArray, others: FloatArray) -> FloatArray:
    """Return the criterion (sensor,) of paired ``shapes`` and ``others`` (sensor, mode); NaN without a pair."""
    if not shapes.shape[1]:
        return np.full(len(shapes), np.nan)
    a = shapes / np.maximum(np.linalg.norm(shapes, axis=0), TINY)
    b = others / np.maximum(np.linalg.norm(others, axis=0), TINY)
    together = np.sum(np.abs(a * b), axis=1) ** 2
    return np.asarray(together / np.maximum(np.sum(a**2, axis=1) * np.sum(b**2, axis=1), TINY))
