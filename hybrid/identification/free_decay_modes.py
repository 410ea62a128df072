"""The modes of free decays, out of recordings alone: frequency, damping ratio and shape, each with its uncertainty.

Poles that stay where they are over the orders of a realisation (`stabilisation`) are where a fit begins that all
channels, and all motions of a recording, share (`shared_modes`). What is known too badly, or moves in no phase, is
noise and left out. Poles in no phase that hold far more energy than all of them leave are several modes that the
recording does not tell apart: they stay in the fit, as others would take their motion, and are no modes. A mode whose
frequency changes while it decays shows as several poles of one shape: these are replaced by one, which starts at the
mean of their common motion z, weighed by its energy,

    s = sum_t z(t)^H z'(t) / sum_t z(t)^H z(t).
"""

from collections.abc import Sequence

import numpy as np

from fe_models.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from fe_models.modes import mac
from hybrid.identification.channel_sizes import channel_sizes
from hybrid.identification.config import FREE_DECAY
from hybrid.identification.identified_modes import IdentifiedModes, no_modes
from hybrid.identification.mode_uncertainty import covariance_of, is_above_noise, left_by, noise_at
from hybrid.identification.shared_modes import Linearised, SharedModes, fit_shared_modes
from hybrid.identification.stabilisation import Stabilisation, stabilisation_of


def identify_modes(
    motions: FloatArray | Sequence[FloatArray], rate: float, first: float, highest: float, count: int | None = None
) -> IdentifiedModes:
    """Return the modes of a recording up to ``highest`` Hz; with ``count`` the strongest, at most so many.

    ``motions``: one free decay (time, sensor), or several that share their modes, of sensors that all show one
    quantity. ``first``: the structure's lowest natural frequency, Hz, which says what is a drift, and how long to look.
    """
    parts = [motions] if isinstance(motions, np.ndarray) and motions.ndim == 2 else list(motions)
    found, _ = identify_free_decay(parts, rate, first, highest, np.zeros(parts[0].shape[1], dtype=int))
    return found if count is None else found.strongest(count)


def identify_free_decay(
    motions: Sequence[FloatArray], rate: float, first: float, highest: float, orders: IntArray
) -> tuple[IdentifiedModes, Stabilisation]:
    """Return the modes of free decays (time, sensor), by frequency, and the poles that their fit began with.

    ``orders`` (sensor,): of the derivatives of displacements that sensors show. See `identify_modes`.
    """
    parts = [np.asarray(part, dtype=float) for part in motions]
    lowest = min(FREE_DECAY.min_frequency_hz, FREE_DECAY.min_frequency_hz * first)
    stabilisation = stabilisation_of(parts, rate, first, (lowest, highest))
    rms = np.sqrt(np.mean(np.concatenate([part - part.mean(axis=0) for part in parts]) ** 2, axis=0))
    rms = np.where(rms > 0, rms, 1.0)
    found = _settled(parts, rate, *stabilisation.modes, rms, orders)
    return found.take(np.argsort(np.abs(found.roots))), stabilisation


def _settled(
    parts: list[FloatArray], rate: float, roots: ComplexArray, shapes: ComplexArray, rms: FloatArray, orders: IntArray
) -> IdentifiedModes:
    """Return the modes that are left when those that are none have gone, and the noise is what they leave."""
    noise, found, kept = rms, no_modes(orders), np.zeros(0, dtype=bool)
    for _ in range(FREE_DECAY.max_rounds):
        if not len(roots):
            return no_modes(orders)
        start = SharedModes.of(roots, shapes, noise)
        modes, linear = fit_shared_modes(parts, rate, start, noise)
        left = left_by(parts, rate, modes, linear, noise)
        level, lines = noise_at(modes, left, rate, noise)
        covariance = covariance_of(modes, linear, level, noise)
        energy = _energy(parts, rate, modes, linear, noise)
        sizes = channel_sizes(modes.roots, energy, orders)
        total, rest = max(_energy_of(parts, sizes), np.finfo(float).tiny), _energy_of(left, sizes)
        share = np.sum(energy / sizes**2, axis=1) / total
        unexplained = min(rest / total, 1.0)
        found = IdentifiedModes(
            modes.roots, modes.shapes.T, modes.reference, covariance, share, unexplained, orders, sizes
        )
        vibrates = _vibrates(found) & is_above_noise(energy / noise**2, level, lines, sum(map(len, parts)))
        kept = vibrates & _has_a_shape(found)
        several = vibrates & (share > FREE_DECAY.min_energy_of_several * unexplained)
        roots, shapes = _joined(parts, rate, found.take(kept | several), rms)
        after = np.sqrt(np.mean(np.concatenate(left) ** 2, axis=0))
        after = np.maximum(after, FREE_DECAY.least_noise * rms)
        settled = np.allclose(after, noise, rtol=FREE_DECAY.noise_tolerance) and len(roots) == len(found.roots)
        noise = after
        if settled:
            break
    return found.take(kept)


def _energy_of(parts: Sequence[FloatArray], sizes: FloatArray) -> float:
    """Return the sum of squares of motions (time, sensor) about their means, each channel over its size."""
    return sum(float(np.sum(((part - part.mean(axis=0)) / sizes) ** 2)) for part in parts)


def _energy(
    parts: list[FloatArray], rate: float, modes: SharedModes, linear: tuple[Linearised, ...], noise: FloatArray
) -> FloatArray:
    """Return the sum of squares (mode, sensor) of each mode's own motion."""
    energy = np.zeros(modes.shapes.shape)
    for part, own in zip(parts, linear, strict=True):
        waves = np.exp(np.outer(np.arange(len(part)) / rate, modes.roots))
        amplitudes = (own.amplitudes * noise[modes.reference])[:, None] * modes.shapes
        energy += np.sum(np.real(waves[:, :, None] * amplitudes) ** 2, axis=0)
    return energy


def _vibrates(found: IdentifiedModes) -> BoolArray:
    """Return which modes have a frequency that is known well enough, and are damped like a structure's."""
    sure = np.sqrt(found.scatter[:, 0, 0]) < FREE_DECAY.max_frequency_error
    return np.asarray(sure & (found.ratios < 0.99 * FREE_DECAY.max_damping_ratio))


def _has_a_shape(found: IdentifiedModes) -> BoolArray:
    """Return which modes have a shape that is known well enough, and in phase."""
    entries = np.sqrt(np.diagonal(found.covariance, axis1=1, axis2=2)[:, 2:]) / np.tile(found.sizes, 2)
    usual = np.median(entries, axis=1) / np.abs(found.shapes / found.sizes[:, None]).max(axis=0)
    in_phase = found.collinearity >= FREE_DECAY.min_phase_collinearity
    return np.asarray(in_phase & (usual < FREE_DECAY.max_shape_error))


def _is_satellite(found: IdentifiedModes) -> BoolArray:
    """Return which modes (mode, other) have another, far weaker one within the width of their peak."""
    distance = np.abs(found.roots[:, None] - found.roots)
    near = distance < FREE_DECAY.max_satellite_distance * np.abs(found.roots.real)[:, None]
    return np.asarray(near & (found.energy < FREE_DECAY.max_satellite_energy * found.energy[:, None]))


def _joined(
    parts: list[FloatArray], rate: float, found: IdentifiedModes, rms: FloatArray
) -> tuple[ComplexArray, ComplexArray]:
    """Return roots and shapes, those of one shape that lie close together replaced by the mean of their motion."""
    omega, resolution = np.abs(found.roots), 2 * np.pi * rate / max(len(part) for part in parts)
    near = np.abs(omega[:, None] - omega) <= np.maximum(FREE_DECAY.max_relative_separation * omega, resolution)
    scaled = found.shapes / rms[:, None]
    same = (near & (mac(scaled, scaled) >= FREE_DECAY.min_mac_of_one_mode)) | _is_satellite(found)
    samples, waiting = max(len(part) for part in parts), [int(mode) for mode in np.argsort(-found.energy)]
    waves = np.exp(np.outer(np.arange(samples) / rate, found.roots))  # (time, mode)
    size = np.sqrt(found.energy / np.maximum(np.sum(np.abs(waves) ** 2, axis=0), np.finfo(float).tiny))
    sized = found.shapes / found.sizes[:, None]
    size = size / np.linalg.norm(sized, axis=0)
    roots, shapes = [], []
    while waiting:
        group = [mode for mode in waiting if same[waiting[0], mode]]
        waiting = [mode for mode in waiting if mode not in group]
        group = [
            mode for mode in group if found.energy[mode] >= FREE_DECAY.max_satellite_energy * found.energy[group[0]]
        ]
        own = size[group][:, None] * sized[:, group].T
        motion, change = waves[:, group] @ own, (waves[:, group] * found.roots[group]) @ own  # (time, sensor)
        alone = len(group) == 1
        roots.append(found.roots[group[0]] if alone else np.sum(motion.conj() * change) / np.sum(np.abs(motion) ** 2))
        shapes.append(found.shapes[:, group[0]])
    return np.array(roots, dtype=complex), np.array(shapes, dtype=complex).reshape(len(roots), len(rms))
