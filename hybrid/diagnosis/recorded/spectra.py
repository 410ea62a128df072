"""Where the energy of recordings is: near which natural frequency, and at which lines of a weak nonlinearity."""

from collections.abc import Callable

import numpy as np
from scipy.stats import gamma

from fe_models.arrays import TINY, FloatArray
from fe_models.spectra import line_frequencies, power_spectrum
from hybrid.diagnosis.recorded.config import SPECTRA


def falling(samples: int) -> FloatArray:
    """Return the second half of a Hann window: what is fast dies early, where the whole one is blind."""
    return np.hanning(2 * samples)[samples:]


def energy_near(
    frequencies: FloatArray,
    parts: tuple[FloatArray, ...],
    rate: float,
    window_of: Callable[[int], FloatArray] = np.hanning,
) -> FloatArray:
    """Return the shares (mode,) of energy nearest to each frequency (Hz), through a window of so many samples.

    ``parts`` (recording, time, sensor) in units of the noise, whose energy is taken off; so are means, where none of
    the frequencies is zero.
    """
    found = np.zeros(len(frequencies))
    for part in parts if len(frequencies) else ():  # below a low-pass there may be none
        window = window_of(part.shape[1])
        mean = part.mean(axis=1, keepdims=True) if np.all(frequencies) else 0.0
        power = power_spectrum(part - mean, window).sum(axis=(0, 2))
        power -= np.sum(window**2) * part.shape[0] * part.shape[2]
        nearest = np.abs(line_frequencies(part.shape[1], rate)[:, None] - frequencies).argmin(axis=1)
        found += np.bincount(nearest, power, len(frequencies))
    found = np.maximum(found, 0.0)
    return np.asarray(found / max(float(found.sum()), TINY))


def strongest_apart(
    frequencies: FloatArray, width: FloatArray, parts: tuple[FloatArray, ...], rate: float
) -> float | None:
    """Return the frequency (Hz) of the strongest line of ``parts`` (recording, time, sensor), in units of the noise,
    that lies more than ``width`` (mode,) away from each of the ``frequencies``; None where noise is as strong.
    """
    strongest, found = SPECTRA.min_line_ratio, None
    for part in parts:
        window = falling(part.shape[1])
        power = power_spectrum(part, window).mean(axis=(0, 2)) / np.sum(window**2)
        lines = line_frequencies(part.shape[1], rate)
        power[np.any(np.abs(lines[:, None] - frequencies) <= width, axis=1)] = 0.0
        if power.max() > strongest:
            strongest, found = float(power.max()), float(lines[power.argmax()])
    return found


def clearest_line(parts: tuple[FloatArray, ...], rate: float, cutoff: float) -> tuple[int, float] | None:
    """Return which sensor has the line that white noise makes most rarely, and its frequency (Hz); None where noise may
    make all of them.

    ``parts`` (recording, time, sensor); only lines below the ``cutoff`` (rad/s) of a low-pass are looked at.
    """
    clearest, found = -np.log(SPECTRA.max_chance_of_line), None
    for part in parts:
        lines = line_frequencies(part.shape[1], rate)
        noisy = slice(1, int(np.searchsorted(2 * np.pi * lines, cutoff)))
        power = power_spectrum(part).sum(axis=0)[noisy]  # (frequency, sensor)
        rarer = -gamma.logsf(power / power.mean(axis=0) * len(part), len(part)) - np.log(power.size)
        if rarer.size and rarer.max() > clearest:
            at, sensor = np.unravel_index(int(rarer.argmax()), rarer.shape)
            clearest, found = float(rarer.max()), (int(sensor), float(lines[noisy][at]))
    return found


def combination_lines(frequencies: FloatArray, energies: FloatArray) -> FloatArray:
    """Return (Hz) the multiples, sums and differences of the frequencies (mode,) with the largest ``energies`` (mode,).

    A structure whose shape changes with its motion shows such lines, weakly; a machine would hardly run at one.
    """
    strongest = frequencies[np.argsort(-energies)[: SPECTRA.strongest_modes]]
    counts = np.stack(
        np.meshgrid(*[np.arange(-SPECTRA.combination_order, SPECTRA.combination_order + 1)] * len(strongest)), axis=-1
    ).reshape(-1, len(strongest))
    order = np.abs(counts).sum(axis=1)
    lines = counts[(order > 1) & (order <= SPECTRA.combination_order)] @ strongest
    return np.unique(lines[lines > 0])
