"""Correlations of what sensors show under unknown forces, and how they vary over the recording.

    R(l) = mean over samples k of y(k + l) y(k)^T

Under white forces they decay as the structure does: R(l) = C A^(l-1) G (Peeters and De Roeck, Mech. Syst. Signal
Process. 13(6), 1999). White noise of the sensors has none at lags other than zero. The same means over short segments
of the recording tell how well each is known.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil

import numpy as np

from fe_models.arrays import FloatArray


@dataclass(frozen=True)
class Correlations:
    """Correlations at lags of 0, 1, ... samples: their ``mean`` (lag, sensor, sensor), and by how much those of each
    segment differ from it, ``parts`` (segment, lag, sensor, sensor).
    """

    mean: FloatArray
    parts: FloatArray


def correlations_of(motions: Sequence[FloatArray], longest: int, segments: int) -> Correlations:
    """Return the correlations of ``motions`` (time, sensor) at lags of up to ``longest`` samples.

    All motions together are cut into about so many ``segments``, of equal length.
    """
    length = max(1, sum(len(part) - longest for part in motions) // segments)
    parts = np.concatenate([_of_segments(part, longest, length) for part in motions]) / length
    mean = parts.mean(axis=0)
    return Correlations(mean, parts - mean)


def _of_segments(data: FloatArray, longest: int, length: int) -> FloatArray:
    """Return the sum of y(k + l) y(k)^T over each segment, (segment, lag, sensor, sensor), by Fourier transforms."""
    count, sensors = (len(data) - longest) // length, data.shape[1]
    size = 2 ** ceil(np.log2(length + longest))
    windows = np.lib.stride_tricks.sliding_window_view(data, length + longest, axis=0)[: count * length : length]
    found = np.empty((count, longest + 1, sensors, sensors))
    late = np.fft.rfft(windows, size, axis=2)  # (segment, sensor, line)
    early = np.fft.rfft(windows[:, :, :length], size, axis=2).conj()
    for sensor in range(sensors):
        found[..., sensor] = np.fft.irfft(late * early[:, [sensor]], size, axis=2)[..., : longest + 1].swapaxes(1, 2)
    return found
