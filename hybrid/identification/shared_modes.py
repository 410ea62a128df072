"""Modes that all motions of one structure share, fitted to their free decays by variable projection.

    y_i(t) = offset_i + Re sum_k c_ki v_k exp(s_k t),   s_k = -xi_k w_k + i w_k sqrt(1 - xi_k^2)

Roots s_k and complex shapes v_k, one entry of each one, are the same in all motions i; amplitudes c_ki and offsets are
each motion's own, linear, and projected out (Golub and Pereyra, SIAM J. Numer. Anal. 10, 1973). All that a step needs
of the samples is in a QR decomposition of exp(s t), t exp(s t) and one, which motions of equal length have in common.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fe_models.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from hybrid.identification.config import FREE_DECAY
from hybrid.levenberg_marquardt import Damping

DAMPING = Damping(first=1e-3, easing=10.0, tightening=10.0, most=1e4)


@dataclass(frozen=True)
class SharedModes:
    """``roots`` (mode,), rad/s; complex ``shapes`` (mode, sensor), the ``reference`` (mode,) entry of each, its largest
    over the noise, one.
    """

    roots: ComplexArray
    shapes: ComplexArray
    reference: IntArray

    @staticmethod
    def of(roots: ComplexArray, shapes: ComplexArray, noise: FloatArray) -> "SharedModes":
        """Return modes of any scale, with their reference entries; ``noise`` (sensor,) of the channels."""
        reference = np.argmax(np.abs(shapes) / noise, axis=1)
        return SharedModes(roots, shapes / np.take_along_axis(shapes, reference[:, None], axis=1), reference)

    def moved(self, step: FloatArray) -> "SharedModes":
        """Return the modes after a ``step`` (mode, 2 + 2 sensor) in Re s, Im s, Re v, Im v."""
        sensors = self.shapes.shape[1]
        roots = self.roots + step[:, 0] + 1j * step[:, 1]
        shapes = self.shapes + step[:, 2 : 2 + sensors] + 1j * step[:, 2 + sensors :]
        return replace(self, roots=roots, shapes=shapes)

    @property
    def free(self) -> BoolArray:
        """Which parameters (mode, 2 + 2 sensor) are free: all but the reference entries."""
        modes, sensors = self.shapes.shape
        free = np.ones((modes, 2 + 2 * sensors), dtype=bool)
        for part in (2, 2 + sensors):
            free[np.arange(modes), part + self.reference] = False
        return free


@dataclass(frozen=True)
class Linearised:
    """One motion at some modes, in an orthonormal frame of time, orthogonal to what amplitudes and offsets can do.

    ``residual`` (frame, sensor); ``slopes`` (frame, sensor, mode, parameter); ``amplitudes`` (mode,) and ``offset``
    (sensor,); ``beyond``: sum of squares of what lies outside of the frame.
    """

    residual: FloatArray
    slopes: FloatArray
    amplitudes: ComplexArray
    offset: FloatArray
    beyond: float

    @property
    def left(self) -> float:
        """The sum of squares that is left."""
        return float(np.sum(self.residual**2)) + self.beyond


def fit_shared_modes(
    motions: Sequence[FloatArray], rate: float, start: SharedModes, noise: FloatArray
) -> tuple[SharedModes, tuple[Linearised, ...]]:
    """Return the modes of least squares over ``motions`` (time, sensor), each channel in units of its ``noise``.

    Levenberg and Marquardt's steps from a ``start``; with them what was linearised there.
    """
    scaled = [part / noise for part in motions]
    present = replace(start, shapes=start.shapes / noise)
    present = SharedModes.of(present.roots, present.shapes, np.ones_like(noise))
    parts = linearised(scaled, rate, present)
    damping = DAMPING.start
    for _ in range(FREE_DECAY.max_iterations):
        cost = sum(part.left for part in parts)
        found = _improved(scaled, rate, present, parts, cost, damping)
        if found is None:
            break
        present, parts, damping = found
        if cost - sum(part.left for part in parts) < FREE_DECAY.min_chi2_fall:
            break
    final = SharedModes.of(present.roots, present.shapes, np.ones_like(noise))
    parts = linearised(scaled, rate, final)
    scale = noise / noise[final.reference][:, None]
    return replace(final, shapes=final.shapes * scale), parts


def _improved(
    scaled: Sequence[FloatArray],
    rate: float,
    present: SharedModes,
    parts: tuple[Linearised, ...],
    cost: float,
    damping: float,
) -> tuple[SharedModes, tuple[Linearised, ...], float] | None:
    """Return modes that leave less than ``cost``, with what they leave and the next damping; None where none do."""
    free = present.free
    H, gradient = np.zeros((int(free.sum()),) * 2), np.zeros(int(free.sum()))
    for part in parts:
        J = part.slopes[:, :, free].reshape(-1, len(gradient))
        H += J.T @ J
        gradient += J.T @ part.residual.ravel()
    diagonal = np.diag(H) + np.finfo(float).eps * np.trace(H)
    for tried in DAMPING.tries(damping):
        step = np.zeros(free.shape)
        step[free] = np.linalg.solve(H + tried * np.diag(diagonal), gradient)
        then = present.moved(step)
        far = np.abs(then.roots - present.roots) > FREE_DECAY.largest_step * np.abs(present.roots)
        least = -FREE_DECAY.max_damping_ratio * np.abs(then.roots)
        if far.any() or (then.roots.imag <= 0).any() or (then.roots.real < least).any():
            continue
        grown = replace(then, roots=np.minimum(then.roots.real, 0.0) + 1j * then.roots.imag)
        found = linearised(scaled, rate, grown)
        if sum(part.left for part in found) <= cost:
            return grown, found, DAMPING.eased(tried)
    return None


def linearised(scaled: Sequence[FloatArray], rate: float, modes: SharedModes) -> tuple[Linearised, ...]:
    """Return each motion (time, sensor), in units of the noise, linearised at ``modes``."""
    frames: dict[int, tuple[FloatArray, FloatArray]] = {}
    for part in scaled:
        if len(part) not in frames:
            time = np.arange(len(part)) / rate
            waves = np.exp(np.outer(time, modes.roots))
            waves = np.hstack([waves.real, -waves.imag])
            frames[len(part)] = np.linalg.qr(np.hstack([np.ones((len(part), 1)), waves, time[:, None] * waves]))
    return tuple(_linearised(part, modes, *frames[len(part)]) for part in scaled)


def _linearised(part: FloatArray, modes: SharedModes, frame: FloatArray, inside: FloatArray) -> Linearised:
    """Return one motion linearised; the columns one, exp and t exp are ``frame`` (time, frame) times ``inside``."""
    count, sensors = modes.shapes.shape
    one, waves, late = inside[:, :1], inside[:, 1 : 1 + 2 * count], inside[:, 1 + 2 * count :]
    data = frame.T @ part  # (frame, sensor)
    size, every = len(data), np.eye(sensors)
    by_amplitude = np.concatenate(_shown(waves, modes.shapes), axis=2)  # (frame, sensor, 2 mode)
    by_offset = one[:, :, None] * every
    columns = np.concatenate([by_amplitude, by_offset], axis=2).reshape(size * sensors, -1)
    solved = np.linalg.lstsq(columns, data.ravel(), rcond=None)[0]
    basis = np.linalg.qr(columns)[0]
    amplitudes = solved[:count] + 1j * solved[count : 2 * count]
    by_root = _shown(late, amplitudes[:, None] * modes.shapes)
    own = _shown(waves, amplitudes[:, None])  # of a sensor that shows a mode with one
    by_shape = [side[:, 0, :, None, None].swapaxes(1, 2) * every[:, None] for side in own]  # (frame, sensor, mode, to)
    slopes = np.concatenate([by_root[0][..., None], by_root[1][..., None], *by_shape], axis=3)
    flat = slopes.reshape(size * sensors, -1)
    flat = flat - basis @ (basis.T @ flat)
    residual = (data.ravel() - columns @ solved).reshape(data.shape)
    beyond = max(float(np.sum(part**2) - np.sum(data**2)), 0.0)
    return Linearised(residual, flat.reshape(slopes.shape), amplitudes, solved[2 * count :], beyond)


def _shown(waves: FloatArray, shapes: ComplexArray) -> tuple[FloatArray, FloatArray]:
    """Return what real and imaginary part of an amplitude show, (time, sensor, mode) each, of ``shapes`` (mode,
    sensor); ``waves`` (time, 2 mode): Re exp, then -Im exp.
    """
    count = len(shapes)
    real, imaginary = waves[:, None, :count], waves[:, None, count:]
    v = shapes.T[None]
    return real * v.real + imaginary * v.imag, imaginary * v.real - real * v.imag
