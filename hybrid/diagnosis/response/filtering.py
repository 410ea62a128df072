"""Weighted sums over the samples of many channels at once, compiled: five times as fast as SciPy's, which walks along
each channel apart.
"""

import numpy as np

from fe_models.dofs import FloatArray
from hybrid.diagnosis.response.compiled import compiled

BLOCK = 1024  # values at a time, which stay near the processor


def convolved(long: FloatArray, kernel: FloatArray) -> FloatArray:
    """Return the convolution of channels (..., time, sensor) and a ``kernel`` (time,), where both overlap whole."""
    *outer, samples, sensors = long.shape
    found = np.empty((*outer, samples - len(kernel) + 1, sensors))
    rows = int(np.prod(outer))
    _weigh(np.ascontiguousarray(long).reshape(rows, -1), kernel[::-1].copy(), sensors, found.reshape(rows, -1))
    return found


@compiled
def _weigh(values: FloatArray, weights: FloatArray, apart: int, to: FloatArray) -> None:
    """Set ``to`` (row, value) to the sums of as many ``values`` (row, value), ``apart`` from each other, as there are
    ``weights``.
    """
    for row in range(len(to)):
        for begin in range(0, to.shape[1], BLOCK):
            block = to[row, begin : begin + BLOCK]
            block[:] = 0.0
            for number in range(len(weights)):
                first, weight = begin + number * apart, weights[number]
                part = values[row, first : first + len(block)]
                for i in range(len(block)):
                    block[i] += weight * part[i]
