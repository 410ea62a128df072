"""How well modes are known: the covariance of roots and shapes, with the noise that each mode meets.

Least squares over white noise have the covariance H^-1, H = J^T J in units of the noise. What a fit leaves is not
white: between modes there is noise, about a mode whose frequency moves while it decays there is more. All that a mode's
parameters change lies in a narrow band about its frequency; so its columns of J are weighed, channel by channel, with
the power of what is left there.
"""

from collections.abc import Sequence

import numpy as np
from scipy.stats import f

from fe_models.arrays import BoolArray, FloatArray
from hybrid.identification.config import FREE_DECAY
from hybrid.identification.shared_modes import Linearised, SharedModes

TAKEN = 2.0  # lines of a spectrum: what a mode's amplitude and root take of the noise about it


def left_by(
    motions: Sequence[FloatArray], rate: float, modes: SharedModes, parts: Sequence[Linearised], noise: FloatArray
) -> list[FloatArray]:
    """Return what the modes leave of each motion, (time, sensor)."""
    shapes = modes.shapes / (noise / noise[modes.reference][:, None])
    left = []
    for part, own in zip(motions, parts, strict=True):
        waves = np.exp(np.outer(np.arange(len(part)) / rate, modes.roots))
        left.append(part - noise * (own.offset + np.real((waves * own.amplitudes) @ shapes)))
    return left


def covariance_of(modes: SharedModes, parts: Sequence[Linearised], level: FloatArray, noise: FloatArray) -> FloatArray:
    """Return the covariance (mode, parameter, parameter) of each mode's Re s, Im s, Re v, Im v, zero in the reference.

    ``level`` (mode, sensor): see `noise_at`; ``noise`` (sensor,): what ``parts`` and it are in units of.
    """
    free, (count, sensors) = modes.free, modes.shapes.shape
    weight = 1 / level
    size = int(free.sum())
    H = np.zeros((size, size))
    for part in parts:
        J = (part.slopes * weight.T[:, :, None])[:, :, free].reshape(-1, size)
        H += J.T @ J
    scale = 1 / np.sqrt(np.maximum(np.diag(H), np.finfo(float).tiny))
    normal = H * np.outer(scale, scale) + np.finfo(float).eps * size * np.eye(size)
    whole = np.zeros((free.size, free.size))
    whole[np.ix_(free.ravel(), free.ravel())] = np.linalg.inv(normal) * np.outer(scale, scale)
    to_units = np.ones((count, 2 + 2 * sensors))
    to_units[:, 2:] = np.tile(noise / noise[modes.reference][:, None], 2)
    whole = whole * np.outer(to_units, to_units)
    own = whole.reshape(count, 2 + 2 * sensors, count, 2 + 2 * sensors)
    return own[np.arange(count), :, np.arange(count)]


def noise_at(
    modes: SharedModes, left: Sequence[FloatArray], rate: float, noise: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the standard deviation (mode, sensor) of noise that is everywhere as loud as what is left (time, sensor)
    of each motion about a mode's frequency, in units of the ``noise`` (sensor,); and of how many lines that is known.
    """
    frequency, decay = np.abs(modes.roots) / (2 * np.pi), -modes.roots.real
    power, count = np.zeros((len(frequency), len(noise))), np.zeros(len(frequency))
    for part in left:
        lines, time = np.fft.rfftfreq(len(part), 1 / rate), np.arange(len(part)) / rate
        for mode, middle in enumerate(frequency):
            window = np.exp(-decay[mode] * time)  # noise counts while the mode is there to meet it
            spectrum = np.abs(np.fft.rfft(window[:, None] * part / noise, axis=0)) ** 2 / np.sum(window**2)
            resolution = max(rate / len(part), decay[mode] / np.pi)
            reach = max(FREE_DECAY.noise_band_lines * resolution, FREE_DECAY.noise_band_share * middle)
            apart = np.abs(lines - middle)
            own = spectrum[apart <= max(reach, float(apart.min()))]  # a root on its way may be beyond all lines
            independent = 2 * reach / resolution
            power[mode] += own.mean(axis=0) * independent / (independent - TAKEN)
            count[mode] += independent - TAKEN
    found = np.sqrt(power / len(left))
    return np.maximum(found, FREE_DECAY.least_noise * max(float(found.max()), 1.0)), count


def is_above_noise(energy: FloatArray, level: FloatArray, lines: FloatArray, samples: int) -> BoolArray:
    """Return which modes (mode,) noise alone has in one recording of many only: an F-test of their energy.

    ``energy`` (mode, sensor) over that of the ``noise`` of `noise_at`, whose ``level`` is known of so many ``lines``. A
    mode takes an amplitude in each sensor and a root, the best of all that ``samples`` can tell apart.
    """
    taken, known = 2 * level.shape[1] + 2, 2 * lines * level.shape[1]
    least = taken * f.isf(FREE_DECAY.false_alarms / samples, taken, known)
    return np.asarray(np.sum(energy / level**2, axis=1) > least)
