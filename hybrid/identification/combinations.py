"""Sums and differences of modes' frequencies: peaks there are the mark of a force that is not linear."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations as pairs_of
from types import MappingProxyType

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.spectra import line_frequencies, power_spectrum
from hybrid.identification.config import COMPARISON
from hybrid.identification.identified_modes import IdentifiedModes

COMBINATIONS = ((-1, 1), (2, 0), (-1, 2), (1, 1))  # of two modes: those that lie between no other peaks
HARMONICS = ((2, 0), (3, 0))  # of a single mode


@dataclass(frozen=True)
class Combination:
    """``first`` f_a + ``second`` f_b = ``expected`` Hz; ``found`` (Hz) the highest value near it, its ``level`` over
    the recording's highest peak and over the median of what is round it (``over``), all of power; NaN where the
    recording does not go that high. ``natural``: the recording's own natural mode there (number, from 0), which leaves
    nothing to be said of a combination; -1 where none is.
    """

    first: int
    second: int
    expected: float
    found: float = np.nan
    level: float = np.nan
    over: float = np.nan
    natural: int = -1

    @property
    def is_peak(self) -> bool:
        """Whether there is a peak, and it is no natural mode's."""
        return self.natural < 0 and self.over >= COMPARISON.min_peak_ratio


def combinations_of(
    data: FloatArray,
    rate: float,
    modes: Sequence[float],
    highest: float = np.inf,
    natural: Mapping[int, tuple[float, float]] = MappingProxyType({}),
) -> list[Combination]:
    """Return how high a recording (time, sensor) stands at combinations of the frequencies (Hz) of one or two modes.

    ``highest``: the frequency (Hz) up to which the recording goes, where that is below half its sampling rate.
    ``natural``: frequency (Hz) and damping ratio of each mode of the model that the recording shows, by number.
    """
    power = power_spectrum(data - data.mean(axis=0)).sum(axis=1)
    frequencies = line_frequencies(len(data), rate)
    near_width = max(COMPARISON.max_distance_hz, 1 / len(data) * rate)
    found = []
    for first, second in COMBINATIONS if len(modes) > 1 else HARMONICS:
        expected = first * modes[0] + second * modes[-1]
        if expected + COMPARISON.background_hz > min(highest, rate / 2):
            found.append(Combination(first, second, expected))
            continue
        away = np.abs(frequencies - expected)
        near = np.flatnonzero(away <= near_width)
        peak = int(near[np.argmax(power[near])])
        middle = float(
            np.median(power[(away <= max(COMPARISON.background_hz, 4 * near_width)) & (away > 2 * near_width)])
        )
        level = float(power[peak])
        places = float(frequencies[peak]), level / float(power.max()), level / middle
        found.append(Combination(first, second, expected, *places, _natural(expected, near_width, natural)))
    return found


def sums_of_stronger(modes: IdentifiedModes) -> dict[int, str]:
    """Return which modes, by number, lie at a multiple, a sum or a difference of stronger ones, and of which, in words.

    A motion that is not linear shows there without any mode: a sway of f Hz makes columns shorter at 2 f Hz, say.
    """
    frequency, error = modes.frequencies, modes.frequency_errors
    found = dict[int, str]()
    for line in range(len(frequency)):
        stronger = [int(mode) for mode in np.flatnonzero(modes.energy > modes.energy[line])]
        for words, at, sigma in _sums(frequency, error, stronger):
            reach = COMPARISON.sum_sigma * np.hypot(sigma, error[line]) + COMPARISON.sum_distance * frequency[line]
            if abs(frequency[line] - at) <= reach:
                found[line] = words
                break
    return found


def _sums(frequency: FloatArray, error: FloatArray, modes: Sequence[int]) -> Iterator[tuple[str, float, float]]:
    """Yield multiples, sums and differences of the frequencies of ``modes``: in words, in Hz, and their deviations."""
    for mode in modes:
        for factor in (2, 3):
            yield f"{factor} x {frequency[mode]:.4g}", factor * frequency[mode], factor * error[mode]
    for low, high in pairs_of(modes, 2):
        sigma = float(np.hypot(error[low], error[high]))
        yield f"{frequency[low]:.4g} + {frequency[high]:.4g}", frequency[low] + frequency[high], sigma
        yield f"{frequency[high]:.4g} - {frequency[low]:.4g}", abs(frequency[high] - frequency[low]), sigma


def _natural(expected: float, width: float, natural: Mapping[int, tuple[float, float]]) -> int:
    """Return the mode whose peak reaches a frequency (Hz), -1 where none does.

    A peak is as wide as its damping makes it, and the search of ``width`` (Hz) on both sides finds its foot.
    """
    there = (mode for mode, (own, ratio) in natural.items() if abs(own - expected) <= 2 * (width + ratio * own))
    return next(there, -1)
