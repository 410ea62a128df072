"""What is left where nothing on the list, or a part only, explains the recordings: where, how fast, when it is seen."""

from collections import Counter

import numpy as np

from fe_models.arrays import TINY, FloatArray
from hybrid.diagnosis.fitting.least_squares import Fit, residuals_at
from hybrid.diagnosis.outcome.config import REST
from hybrid.diagnosis.recorded.motions import in_words
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.recorded.spectra import energy_near, falling, strongest_apart

STILL = "0 Hz (it does not swing about zero)"


def rest_of(item: Fit, frequencies: FloatArray, noise_model: NoiseModel) -> str:
    """Return in a sentence what a fit leaves of the recordings that were fitted: in which channels, near which natural
    ``frequencies`` (mode,) in Hz, in which recordings, early or late.
    """
    motion, rest = _motion(item, noise_model), rests(item, noise_model)
    by_channel = sum(np.square(part).sum(axis=(0, 1)) - len(part) * part.shape[1] for part in rest)
    names = np.array([sensor.name for sensor in noise_model.sensors])
    told = [f"in {_most(np.asarray(by_channel), names)}"]
    if len(frequencies):
        tones, known = [STILL], np.append(0.0, frequencies)
        tones += [f"{tone:.4g} Hz (mode {mode})" for mode, tone in enumerate(frequencies, 1)]
        other = elsewhere(rest, frequencies, noise_model.rate)
        if other is not None:
            tones, known = [*tones, f"{other:.4g} Hz (no natural frequency)"], np.append(known, other)
        told.append(f"near {_most(energy_near(known, rest, noise_model.rate, falling), np.array(tones))}")
    told.append(_when(motion, rest))
    apart = _standing_out(item, rest)
    if apart:
        told.append(f"most of it in {apart}")
    return f"what is left of the recordings beyond noise is {', '.join(told)}"


def rests(item: Fit, noise_model: NoiseModel) -> tuple[FloatArray, ...]:
    """Return what a fit leaves of each batch (recording, time, sensor), in units of the noise."""
    residuals = residuals_at(item, item.theta, noise_model)
    return tuple(
        whole if part is None else part for part, whole in zip(residuals, _motion(item, noise_model), strict=True)
    )


def elsewhere(rest: tuple[FloatArray, ...], frequencies: FloatArray, rate: float) -> float | None:
    """Return near which frequency (Hz) the rest stands out that is none of the ``frequencies`` (mode,), nor zero."""
    known = np.append(0.0, frequencies)
    resolution = rate / max(part.shape[1] for part in rest)
    return strongest_apart(known, np.maximum(REST.near_share * known, REST.near_lines * resolution), rest, rate)


def _motion(item: Fit, noise_model: NoiseModel) -> tuple[FloatArray, ...]:
    """Return the recordings that were fitted, each batch (recording, time, sensor), in units of the noise."""
    return tuple(batch.data / batch.sigma(noise_model) for batch in item.batches)


def _most(energies: FloatArray, names: np.ndarray[tuple[int], np.dtype[np.str_]]) -> str:
    """Return the names of the largest energies with their shares, the first of them in any case."""
    shares = np.maximum(energies, 0) / max(float(np.maximum(energies, 0).sum()), TINY)
    order = np.argsort(-shares)
    told = [k for number, k in enumerate(order) if number == 0 or shares[k] >= REST.min_share]
    return " and ".join(f"{names[k]} ({shares[k]:.0%})" for k in told)


def _when(motion: tuple[FloatArray, ...], rest: tuple[FloatArray, ...]) -> str:
    """Return when more is left, beside the motion's own energy: in the first halves of recordings or in the second."""
    left = np.maximum(_by_halves(rest) - [sum(part.size for part in rest) / 2] * 2, 0.0)
    early, late = left / _by_halves(motion)
    if late >= REST.late_ratio * early:
        return "more of it late than early, beside the motion"
    if early >= REST.late_ratio * late:
        return "more of it early than late, beside the motion"
    return "early and late as the motion is"


def _by_halves(parts: tuple[FloatArray, ...]) -> FloatArray:
    """Return the sums of squares of the first and of the second halves of recordings (recording, time, sensor)."""
    halves = [np.array_split(part, 2, axis=1) for part in parts]
    return np.array([sum(float(np.square(half[k]).sum()) for half in halves) for k in (0, 1)])


def _standing_out(item: Fit, rest: tuple[FloatArray, ...]) -> str:
    """Return the names of the recordings in which far more is left than in the others; none where all are alike."""
    squares = np.concatenate([np.square(part).sum(axis=(1, 2)) - part[0].size for part in rest])
    shares = np.maximum(squares, 0) / max(float(np.maximum(squares, 0).sum()), TINY)
    sizes = np.concatenate([np.full(len(part), part[0].size) for part in rest])
    stands = shares > REST.min_times_usual * sizes / sizes.sum()
    if shares[stands].sum() <= REST.min_share_of_outstanding:
        return ""
    return in_words(Counter(np.array(item.names)[stands].tolist()), Counter(item.names))
