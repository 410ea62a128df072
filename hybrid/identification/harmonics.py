"""Lines of machines among identified modes: no damping, and one line of the spectrum, or an amplitude that stays.

Hann's window leaves a sine in three lines. Of a mode under random forces all lines within its peak are of one size, and
their powers are exponentially distributed: a line over the mean of n others has an F distribution of 2 and 2 n degrees
of freedom (Thomson, Proc. IEEE 70, 1982). Where a machine's speed wanders, its amplitude stays: of a sine E |z|^4 =
(E |z|^2)^2, of normal noise twice that, a kurtosis of the band-passed signal of 1.5 and of 3 (Jacobsen, Andersen and
Brincker, IMAC XXV, 2007).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import f

from fe_models.arrays import TINY, BoolArray, ComplexArray, FloatArray
from hybrid.identification.config import HARMONIC
from hybrid.identification.identified_modes import IdentifiedModes
from hybrid.identification.narrow_band import amplitude_of


@dataclass(frozen=True)
class Harmonic:
    """A line at a ``frequency`` (Hz): its ``amplitude`` (sensor,) in the channels' units, and the ``share`` of the
    recording's energy.
    """

    frequency: float
    amplitude: FloatArray
    share: float


def harmonics_among(
    modes: IdentifiedModes, motions: Sequence[FloatArray], rate: float
) -> tuple[BoolArray, tuple[Harmonic, ...]]:
    """Return which ``modes`` (mode,) of ``motions`` (time, sensor), sampled at ``rate`` Hz, are lines; and these."""
    undamped = modes.ratios < np.maximum(HARMONIC.ratio_sigma * modes.ratio_errors, HARMONIC.largest_ratio)
    found, lines = np.zeros(len(modes.roots), dtype=bool), list[Harmonic]()
    longest = max(motions, key=len)
    power = np.mean((longest - longest.mean(axis=0)) ** 2, axis=0)
    total = np.sum(power / modes.sizes**2)
    for mode in np.flatnonzero(undamped):
        weight = modes.shapes[:, mode].conj() / np.maximum(power, TINY)
        frequency, over = _line(longest, rate, float(modes.frequencies[mode]), weight)
        steady = _fourth_moment(longest, rate, frequency, weight) < HARMONIC.largest_fourth_moment
        if steady or over > _least_over():
            found[mode] = True
            amplitude = np.abs(_at(longest, rate, np.array([frequency])))[0]
            share = float(np.sum((amplitude / modes.sizes) ** 2 / 2) / total)
            lines.append(Harmonic(frequency, amplitude, min(share, 1.0)))
    return found, tuple(lines)


def _at(data: FloatArray, rate: float, frequencies: FloatArray) -> ComplexArray:
    """Return the amplitudes (frequency, sensor) of sines in data (time, sensor), with Hann's window."""
    window = np.hanning(len(data) + 2)[1:-1]
    waves = np.exp(-2j * np.pi * np.outer(frequencies, np.arange(len(data)) / rate))
    return np.asarray((waves * window) @ (data - data.mean(axis=0)) * 2 / window.sum())


def _line(data: FloatArray, rate: float, near: float, weight: ComplexArray) -> tuple[float, float]:
    """Return the frequency (Hz) of the highest line ``near`` another, and its power over that of those about it."""
    half = HARMONIC.steps * HARMONIC.band_lines // 2
    frequencies = near + np.arange(-half, half + 1) * rate / len(data) / HARMONIC.steps
    lines = np.abs(_at(data, rate, frequencies) @ weight) ** 2
    peak = int(np.argmax(lines))
    away = np.abs(np.arange(len(lines)) - peak) / HARMONIC.steps
    about = lines[(away >= HARMONIC.nearest_lines) & (away <= HARMONIC.farthest_lines)]
    return float(frequencies[peak]), float(lines[peak] / max(np.mean(about), TINY))


def _least_over() -> float:
    """Return the power of the highest line over that of those about it that noise has in one of many bands only."""
    independent = HARMONIC.farthest_lines - HARMONIC.nearest_lines  # on both sides, every other one: Hann's overlap
    return float(f.isf(HARMONIC.false_alarms / HARMONIC.band_lines, 2, 2 * independent))


def _fourth_moment(data: FloatArray, rate: float, frequency: float, weight: ComplexArray) -> float:
    """Return E |z|^4 over (E |z|^2)^2 of a narrow band about a ``frequency`` (Hz), but for the recording's ends."""
    amplitudes = amplitude_of(data, rate, frequency, HARMONIC.band_lines * rate / len(data))
    ends = len(amplitudes) // HARMONIC.end_share  # where what ends leaks out of the band
    power = np.abs(amplitudes[ends : len(amplitudes) - ends] @ weight) ** 2
    return float(np.mean(power**2) / max(np.mean(power) ** 2, TINY))
