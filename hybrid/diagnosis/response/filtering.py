"""Weighted sums over the samples of many channels at once, compiled.

Five times as fast as SciPy's, which walk along each channel apart, and up to 200 weights as fast as its transforms.
"""

import numpy as np

from fe_models.arrays import FloatArray
from hybrid.compiled import compiled

BLOCK_VALUES = 1024  # values at a time, which stay near the processor


def convolved(long: FloatArray, kernel: FloatArray) -> FloatArray:
    """Return the convolution of channels (..., time, sensor) and a ``kernel`` (weight,) where both overlap whole: at
    time - weight + 1 samples.
    """
    *outer, samples, sensors = long.shape
    kept, rows = samples - len(kernel) + 1, int(np.prod(outer))
    values, found = np.ascontiguousarray(long).reshape(rows, samples * sensors), np.empty((rows, kept * sensors))
    _weigh(values, kernel[::-1].copy(), sensors, found)
    return found.reshape(*outer, kept, sensors)


@compiled
def _weigh(values: FloatArray, weights: FloatArray, apart: int, to: FloatArray) -> None:
    """Set ``to`` (row, value) to the sums of as many ``values`` (row, value), ``apart`` from each other, as there are
    ``weights``.
    """
    for row in range(len(to)):
        for begin in range(0, to.shape[1], BLOCK_VALUES):
            block = to[row, begin : begin + BLOCK_VALUES]
            block[:] = 0.0
            for number in range(len(weights)):
                first, weight = begin + number * apart, weights[number]
                part = values[row, first : first + len(block)]
                for i in range(len(block)):
                    block[i] += weight * part[i]
