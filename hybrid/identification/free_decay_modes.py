"""The modes of one free decay, out of a recording alone: frequency, damping ratio and shape, one line a shape.

An eigensystem realisation of the part that holds most energy gives lines to start from; the strongest are fitted to the
whole recording (`damped_cosines`). A mode whose frequency changes while it decays shows as several lines of one shape:
these are replaced by one, which starts at the mean of their common motion z, weighed by its energy,

    s = sum_t z(t)^H z'(t) / sum_t z(t)^H z(t),

and is fitted in their place.
"""

from dataclasses import dataclass

import numpy as np

from fe_models.arrays import ComplexArray, FloatArray
from fe_models.modes import mac
from hybrid.identification.config import FREE_DECAY
from hybrid.identification.damped_cosines import amplitudes_of, columns_of, fit_roots
from hybrid.identification.realisation import realise


@dataclass(frozen=True)
class IdentifiedModes:
    """``frequencies`` (line,) Hz and damping ``ratios`` (line,), by frequency; real ``shapes`` (sensor, line), their
    largest entry one; ``energy`` (line,) of each line's own motion over the recording's; ``left``: share of the
    recording's energy that all of them do not explain.
    """

    frequencies: FloatArray
    ratios: FloatArray
    shapes: FloatArray
    energy: FloatArray
    left: float

    @property
    def roots(self) -> ComplexArray:
        """The s_k (line,), rad/s."""
        omega = 2 * np.pi * self.frequencies
        return np.asarray(omega * (-self.ratios + 1j * np.sqrt(1 - self.ratios**2)))


def identify_modes(data: FloatArray, rate: float, first: float, highest: float, count: int) -> IdentifiedModes:
    """Return the strongest modes, at most ``count``, of a recording (time, sensor) up to ``highest`` Hz.

    ``first``: the structure's lowest natural frequency, Hz, which says what is a drift, and how long to look.
    """
    roots = _candidates(data, rate, first)
    frequencies, ratios = np.abs(roots) / (2 * np.pi), -roots.real / np.abs(roots)
    lowest = min(FREE_DECAY.min_frequency_hz, FREE_DECAY.min_frequency_hz * first)
    vibrates = (
        (frequencies >= lowest) & (frequencies <= highest) & (ratios > 0) & (ratios < FREE_DECAY.max_damping_ratio)
    )
    roots = _strongest(data, roots[vibrates], rate, round(FREE_DECAY.spare_line_ratio * count))
    for _ in range(FREE_DECAY.max_joins):
        roots = fit_roots(data, roots, rate)
        joined = _joined(roots, amplitudes_of(data, roots, rate)[0], len(data), rate)
        if len(joined) == len(roots):
            break
        roots = joined
    amplitudes, offset = amplitudes_of(data, roots, rate)
    waves = np.exp(np.outer(np.arange(len(data)) / rate, roots))  # (time, line)
    total = np.sum((data - offset) ** 2)
    left = np.sum((data - offset - np.real(waves @ amplitudes)) ** 2) / total
    energy = np.sum(np.real(waves[:, :, None] * amplitudes) ** 2, axis=(0, 2)) / total
    in_phase = _phase_collinearity(amplitudes) >= FREE_DECAY.min_phase_collinearity
    kept = np.flatnonzero(in_phase & (-roots.real < FREE_DECAY.max_damping_ratio * np.abs(roots)))
    kept = kept[np.argsort(-energy[kept])][:count]
    kept = kept[np.argsort(np.abs(roots[kept]))]
    roots, shapes = roots[kept], _real_shapes(amplitudes[kept])
    return IdentifiedModes(np.abs(roots) / (2 * np.pi), -roots.real / np.abs(roots), shapes, energy[kept], float(left))


def _candidates(data: FloatArray, rate: float, first: float) -> ComplexArray:
    """Return the roots (root,), rad/s, of a realisation of the part of a recording that holds most of its energy."""
    samples = len(data)
    rows = min(FREE_DECAY.block_rows, samples // 4)
    spacing = max(1, min(round(np.ceil(FREE_DECAY.min_row_periods / first * rate / rows)), samples // (2 * rows)))
    span = rows * spacing + 1
    power = np.cumsum(np.sum((data - data.mean(axis=0)) ** 2, axis=1))
    end = min(samples, max(int(np.searchsorted(power, FREE_DECAY.energy_share * power[-1])), 4 * span))
    stride = max(1, (end - span) // FREE_DECAY.max_columns)
    order = min(FREE_DECAY.order, rows * data.shape[1], (end - span) // stride)
    model = realise([data[None, :end]], order, rows, spacing, stride)
    values = np.linalg.eigvals(model.transition).astype(complex)
    roots = np.log(values[np.abs(values) > np.finfo(float).eps]) * rate
    return np.asarray(roots[roots.imag > 0])


def _strongest(data: FloatArray, roots: ComplexArray, rate: float, count: int) -> ComplexArray:
    """Return at most ``count`` of the roots, one after the other that which explains most beside those before it."""
    columns = columns_of(roots, len(data), rate)
    centred = data - data.mean(axis=0)
    gram, moments = columns.T @ columns, columns.T @ centred
    total, explained = np.sum(centred**2), 0.0
    chosen: list[int] = []
    while len(chosen) < min(count, len(roots)):
        gains = {}
        for line in set(range(len(roots))) - set(chosen):
            own = [part + len(roots) * half for half in (0, 1) for part in (*chosen, line)]
            solved = np.linalg.lstsq(gram[np.ix_(own, own)], moments[own], rcond=None)[0]
            gains[line] = float(np.sum(solved * moments[own]))
        best = max(gains, key=lambda line: gains[line])
        if gains[best] - explained < FREE_DECAY.min_energy_share * total:
            break
        chosen.append(best)
        explained = gains[best]
    return roots[chosen]


def _phase_collinearity(amplitudes: ComplexArray) -> FloatArray:
    """Return the modal phase collinearity (line,) of amplitudes (line, sensor): one where all sensors are in phase.

    (|Re|^2 - |Im|^2)^2 + 4 (Re . Im)^2 over (|Re|^2 + |Im|^2)^2 (Pappa, Elliott and Schenk, J. Guidance 16(5), 1993).
    """
    return np.asarray(np.abs(np.sum(amplitudes**2, axis=1)) ** 2 / np.sum(np.abs(amplitudes) ** 2, axis=1) ** 2)


def _real_shapes(amplitudes: ComplexArray) -> FloatArray:
    """Return real shapes (sensor, line), their largest entry one: amplitudes turned to the phase most sensors share."""
    turned = np.real(amplitudes * np.exp(-0.5j * np.angle(np.sum(amplitudes**2, axis=1)))[:, None])
    largest = np.argmax(np.abs(turned), axis=1)
    return np.asarray((turned / np.take_along_axis(turned, largest[:, None], axis=1)).T)


def _joined(roots: ComplexArray, amplitudes: ComplexArray, samples: int, rate: float) -> ComplexArray:
    """Return the roots, those of one shape that lie close together replaced by the mean of their common motion."""
    waves = np.exp(np.outer(np.arange(samples) / rate, roots))  # (time, line)
    strength = np.sum(np.abs(waves) ** 2, axis=0) * np.sum(np.abs(amplitudes) ** 2, axis=1)
    shapes = _real_shapes(amplitudes)
    omega = np.abs(roots)
    resolution = 2 * np.pi * rate / samples
    near = np.abs(omega[:, None] - omega) <= np.maximum(FREE_DECAY.max_relative_separation * omega, resolution)
    same = near & (mac(shapes, shapes) >= FREE_DECAY.min_mac_of_one_mode)
    waiting, joined = [int(line) for line in np.argsort(-strength)], []
    while waiting:
        group = [line for line in waiting if same[waiting[0], line]]
        waiting = [line for line in waiting if line not in group]
        motion = waves[:, group] @ amplitudes[group]  # (time, sensor)
        change = (waves[:, group] * roots[group]) @ amplitudes[group]
        joined.append(np.sum(motion.conj() * change) / np.sum(np.abs(motion) ** 2))
    return np.array(joined, dtype=complex)
