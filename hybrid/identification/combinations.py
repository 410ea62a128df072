"""Sums and differences of two modes' frequencies: lines there are the mark of a force that is not linear."""

from dataclasses import dataclass

import numpy as np

from fe_models.arrays import FloatArray

COMBINATIONS = ((-1, 1), (2, 0), (-1, 2), (1, 1))  # of the two modes: those that lie between no other lines
NEAR = 0.06  # Hz: how far from its place a line may be
ROUND = 0.6  # Hz on both sides: what a line is held against, less the middle of it


@dataclass(frozen=True)
class Combination:
    """``first`` f_a + ``second`` f_b = ``expected`` Hz; ``found`` (Hz) the highest value near it, its ``level`` over
    the recording's highest line and over the median of what is round it (``over``), all of power.
    """

    first: int
    second: int
    expected: float
    found: float
    level: float
    over: float


def combinations_of(data: FloatArray, rate: float, modes: tuple[float, float]) -> list[Combination]:
    """Return how high a recording (time, sensor) stands at each of `COMBINATIONS` of two frequencies (Hz)."""
    window = np.hanning(len(data))[:, None]
    power = np.sum(np.abs(np.fft.rfft(data * window, axis=0)) ** 2, axis=1)
    frequencies = np.fft.rfftfreq(len(data), 1 / rate)
    found = []
    for first, second in COMBINATIONS:
        expected = first * modes[0] + second * modes[1]
        away = np.abs(frequencies - expected)
        near = np.flatnonzero(away <= max(NEAR, 1 / len(data) * rate))
        peak = int(near[np.argmax(power[near])])
        middle = float(np.median(power[(away <= ROUND) & (away > 2 * NEAR)]))
        level = float(power[peak])
        found.append(
            Combination(first, second, expected, float(frequencies[peak]), level / float(power.max()), level / middle)
        )
    return found
