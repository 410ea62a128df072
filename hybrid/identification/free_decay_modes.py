"""The lines of one free decay: damped cosines whose frequencies and damping all channels share.

    y(t) = Re sum_k a_k exp(s_k t),   s_k = -xi_k w_k + i w_k sqrt(1 - xi_k^2),   a_k a complex vector of the channels.

The a_k are linear and projected out (variable projection: Golub and Pereyra, SIAM J. Numer. Anal. 10, 1973); lines are
taken one after the other where the spectrum of what is left is highest, and after each all s_k are fitted anew.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from fe_models.arrays import ComplexArray, FloatArray

LOWEST = 0.5  # Hz, or of the lowest natural frequency where that is less than 1 Hz: below are drifts
APART = 0.3  # Hz, or a quarter of the lowest natural frequency, from a line that is there: nearer is the same one, as
# frequencies move while motions decay
FIRST_RATIO = 0.003  # damping ratio where the search begins
MOST_RATIO = 0.2  # of a line: more is no vibration
EVALUATIONS = 30
ENOUGH = 1e-4  # of a recording's energy: with less left, what is taken for lines is noise


@dataclass(frozen=True)
class IdentifiedModes:
    """``frequencies`` (line,) Hz and damping ``ratios`` (line,), by frequency; ``amplitudes`` (line, sensor), complex,
    at the first sample; ``left``: share of the recording's energy that the lines do not explain.
    """

    frequencies: FloatArray
    ratios: FloatArray
    amplitudes: ComplexArray
    left: float

    @property
    def roots(self) -> ComplexArray:
        """The s_k (line,), rad/s."""
        omega = 2 * np.pi * self.frequencies
        return np.asarray(omega * (-self.ratios + 1j * np.sqrt(1 - self.ratios**2)))

    @property
    def shapes(self) -> FloatArray:
        """Real shapes (sensor, line), the largest entry one: amplitudes turned to the phase most channels share."""
        turned = self.amplitudes * np.exp(-0.5j * np.angle(np.sum(self.amplitudes**2, axis=1)))[:, None]
        largest = np.argmax(np.abs(turned.real), axis=1)
        return np.asarray((turned.real / np.take_along_axis(turned.real, largest[:, None], axis=1)).T)


def identify_modes(data: FloatArray, rate: float, first: float, highest: float, count: int) -> IdentifiedModes:
    """Return the strongest lines, at most ``count``, of a recording (time, sensor) up to ``highest`` Hz.

    ``first``: the structure's lowest natural frequency, Hz, which tells what is a drift, and what one line.
    """
    lowest, apart = min(LOWEST, LOWEST * first), min(APART, first / 4)
    window = np.hanning(len(data))[:, None]
    frequencies = np.fft.rfftfreq(len(data), 1 / rate)
    roots: ComplexArray = np.zeros(0, dtype=complex)
    left = data
    for _ in range(count):
        if np.sum(left**2) < ENOUGH * np.sum(data**2):
            break
        power = np.sum(np.abs(np.fft.rfft(left * window, axis=0)) ** 2, axis=1)
        power[(frequencies < lowest) | (frequencies > highest)] = 0.0
        for root in roots:
            power[np.abs(frequencies - abs(root) / (2 * np.pi)) < apart] = 0.0
        omega = 2 * np.pi * frequencies[int(np.argmax(power))]
        roots = _refined(data, np.append(roots, omega * (-FIRST_RATIO + 1j)), rate)
        left = data - _explained(data, roots, rate)[0]
    roots = roots[np.argsort(np.abs(roots))]
    explained, amplitudes = _explained(data, roots, rate)
    share = float(np.sum((data - explained) ** 2) / np.sum(data**2))
    return IdentifiedModes(np.abs(roots) / (2 * np.pi), -roots.real / np.abs(roots), amplitudes, share)


def columns_of(roots: ComplexArray, samples: int, rate: float) -> FloatArray:
    """Return what real and imaginary parts of each line's amplitude do, (time, 2 line)."""
    waves = np.exp(np.outer(np.arange(samples) / rate, roots))
    return np.hstack([waves.real, -waves.imag])


def _explained(data: FloatArray, roots: ComplexArray, rate: float) -> tuple[FloatArray, ComplexArray]:
    """Return the channels (time, sensor) that lines follow best, and their amplitudes (line, sensor)."""
    columns = columns_of(roots, len(data), rate)
    found = np.linalg.lstsq(columns, data, rcond=None)[0]
    return columns @ found, found[: len(roots)] + 1j * found[len(roots) :]


def _refined(data: FloatArray, roots: ComplexArray, rate: float) -> ComplexArray:
    """Return the roots after least squares over all of them; the Jacobian is Kaufman's."""
    lines = len(roots)
    time = np.arange(len(data)) / rate

    def basis(parameters: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        columns = columns_of(parameters[:lines] + 1j * parameters[lines:], len(data), rate)
        Q, R = np.linalg.qr(columns)
        return columns, Q, np.linalg.solve(R, Q.T @ data)  # the last: amplitudes (2 line, sensor)

    def residual(parameters: FloatArray) -> FloatArray:
        columns, _, amplitudes = basis(parameters)
        return np.asarray((data - columns @ amplitudes).ravel())

    def slopes(parameters: FloatArray) -> FloatArray:
        columns, Q, amplitudes = basis(parameters)
        moved = time[:, None] * columns
        changes = []
        for first, second, sign in ((0, lines, 1.0), (lines, 0, -1.0)):  # d/d Re s, then d/d Im s
            for line in range(lines):
                change = np.outer(moved[:, first + line], amplitudes[line])
                change += sign * np.outer(moved[:, second + line], amplitudes[lines + line])
                changes.append(-(change - Q @ (Q.T @ change)).ravel())
        return np.array(changes).T

    start = np.concatenate([roots.real, roots.imag])
    most = np.concatenate([-1e-6 * roots.imag, 1.5 * roots.imag])
    least = np.concatenate([-MOST_RATIO * roots.imag, 0.5 * roots.imag])
    start = np.clip(start, least + 1e-9, most - 1e-9)
    scale = np.full(2 * lines, 0.1)
    found = least_squares(residual, start, slopes, (least, most), x_scale=scale, max_nfev=EVALUATIONS).x
    return np.asarray(found[:lines] + 1j * found[lines:])
