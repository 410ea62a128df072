"""Damped cosines about an offset, whose frequencies and damping all channels share, fitted by variable projection.

    y(t) = c + Re sum_k a_k exp(s_k t),   s_k = -xi_k w_k + i w_k sqrt(1 - xi_k^2)

The offset c and the amplitudes a_k, a complex vector of the channels each, are linear and projected out (Golub and
Pereyra, SIAM J. Numer. Anal. 10, 1973), with Kaufman's Jacobian. All that a step needs of the samples is in the R of
one QR decomposition of the columns, their products with time, and the channels: as few rows as these are.
"""

import numpy as np
from scipy.optimize import least_squares

from fe_models.arrays import ComplexArray, FloatArray
from hybrid.identification.config import FREE_DECAY

NO_ROOTS: ComplexArray = np.zeros(0, dtype=complex)


def columns_of(roots: ComplexArray, samples: int, rate: float) -> FloatArray:
    """Return what real and imaginary parts of each pole's amplitude do, (time, 2 pole)."""
    decays = np.exp(np.outer(np.arange(samples) / rate, roots))
    return np.hstack([decays.real, -decays.imag])


def amplitudes_of(data: FloatArray, roots: ComplexArray, rate: float) -> tuple[ComplexArray, FloatArray]:
    """Return the amplitudes (pole, sensor) at the first sample and the offset (sensor,) that fit best."""
    columns = np.hstack([columns_of(roots, len(data), rate), np.ones((len(data), 1))])
    found = np.linalg.lstsq(columns, data, rcond=None)[0]
    poles = len(roots)
    return found[:poles] + 1j * found[poles : 2 * poles], found[-1]


def fit_roots(data: FloatArray, roots: ComplexArray, rate: float, held: ComplexArray = NO_ROOTS) -> ComplexArray:
    """Return the ``roots`` (pole,) after least squares over all of them, beside those ``held`` as they are.

    ``data`` (time, sensor) is sampled at ``rate`` Hz; the roots stay within 50 % of their frequencies.
    """
    if not len(roots):
        return roots
    poles, linear = len(roots), 1 + 2 * len(held) + 2 * len(roots)
    time = np.arange(len(data))[:, None] / rate
    fixed = np.hstack([np.ones_like(time), columns_of(held, len(data), rate)])

    def residual_and_slopes(parameters: FloatArray) -> tuple[FloatArray, FloatArray]:
        """In coordinates of all that is orthogonal to the columns; any change of these leaves a step as it is."""
        columns = columns_of(parameters[:poles] + 1j * parameters[poles:], len(data), rate)
        R: FloatArray = np.linalg.qr(np.hstack([fixed, columns, time * columns, data])).R
        channels = R[:, -data.shape[1] :]
        real, imaginary = np.linalg.lstsq(R[:linear, :linear], channels[:linear], rcond=None)[0][-2 * poles :].reshape(
            2, poles, -1
        )
        first, second = R[linear:, linear : linear + poles], R[linear:, linear + poles : linear + 2 * poles]
        slopes = [
            np.einsum("rl,ls->rsl", first, real) + np.einsum("rl,ls->rsl", second, imaginary),  # d / d Re s
            np.einsum("rl,ls->rsl", second, real) - np.einsum("rl,ls->rsl", first, imaginary),  # d / d Im s
        ]
        return channels[linear:].ravel(), -np.concatenate(slopes, axis=2).reshape(-1, 2 * poles)

    last: list[tuple[bytes, tuple[FloatArray, FloatArray]]] = []

    def at(parameters: FloatArray) -> tuple[FloatArray, FloatArray]:
        """The solver asks for residual and slopes one after the other."""
        key = parameters.tobytes()
        if not last or last[0][0] != key:
            last[:] = [(key, residual_and_slopes(parameters))]
        return last[0][1]

    most = np.concatenate([-1e-6 * roots.imag, 1.5 * roots.imag])
    least = np.concatenate([-FREE_DECAY.max_damping_ratio * roots.imag, 0.5 * roots.imag])
    start = np.clip(np.concatenate([roots.real, roots.imag]), least + 1e-9, most - 1e-9)
    found = least_squares(
        lambda parameters: at(parameters)[0],
        start,
        lambda parameters: at(parameters)[1],
        (least, most),
        x_scale=np.full(2 * poles, FREE_DECAY.step_scale),
        max_nfev=FREE_DECAY.max_evaluations,
    ).x
    return np.asarray(found[:poles] + 1j * found[poles:])
