"""Covariance-driven stochastic subspace identification: poles out of correlations, and what each segment says of them.

Block Hankel matrices H0 of correlations R(i + j + 1), and H1 of R(i + j + 2), are weighed with the block Toeplitz
matrices T_f, T_p of R(i - j), and of its transpose, which makes singular values canonical correlations (Peeters and De
Roeck, Mech. Syst. Signal Process. 13(6), 1999; van Overschee and De Moor, Subspace Identification, 1996):

    T_f^-1/2 H0 T_p^-1/2 = U S V^T,   (M0, M1) = U_n^T T_f^-1/2 (H0, H1) T_p^-1/2 V_n

The poles of an order n are those of the pencil, M1 a = lambda M0 a and b^H M1 = lambda b^H M0 with b^H M0 a = 1; their
shapes are the first block row of H0 T_p^-1/2 V_n a. To first order (Pintelon, Guillaume and Schoukens, Mech. Syst.
Signal Process. 21(6), 2007; Reynders, Pintelon and De Roeck 22(4), 2008; Doehler and Mevel 38(2), 2013)

    d lambda = b^H (dM1 - lambda dM0) a,

where weights and singular vectors stand still: once the order holds all modes, what they do vanishes with the rest of
the singular values. All of this is linear in the correlations. So each segment of a recording has a say in a pole.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eig

from fe_models.arrays import ComplexArray, FloatArray
from hybrid.identification.config import AMBIENT
from hybrid.identification.output_correlations import Correlations


@dataclass(frozen=True)
class PolesOfOrder:
    """The poles of one ``order``: ``values`` (pole,) of lambda; ``right`` (state, pole) and ``left`` (pole, state), the
    vectors a and b^H; ``shapes`` (pole, sensor).
    """

    order: int
    values: ComplexArray
    right: ComplexArray
    left: ComplexArray
    shapes: ComplexArray


@dataclass(frozen=True)
class CovarianceSubspace:
    """``singular`` values S (state,) and ``shifted`` U^T T_f^-1/2 H1 T_p^-1/2 V (state, state); ``output``: the first
    block row of T_f^1/2 U (sensor, state); ``left`` T_f^-1/2 U and ``right`` T_p^-1/2 V (row, state).
    """

    correlations: Correlations
    singular: FloatArray
    shifted: FloatArray
    output: FloatArray
    left: FloatArray
    right: FloatArray

    @staticmethod
    def of(correlations: Correlations) -> "CovarianceSubspace":
        """Return the decomposition of correlations at all lags from zero to an even one, twice the block rows."""
        mean = correlations.mean
        rows = (len(mean) - 1) // 2
        (root, future), (_, past) = _roots(mean[:rows]), _roots(mean[:rows].swapaxes(1, 2))
        first, later = (future @ _hankel(mean[start : start + 2 * rows - 1]) @ past for start in (1, 2))
        U, S, Vt = np.linalg.svd(first)
        output = root[: mean.shape[1]] @ U
        return CovarianceSubspace(correlations, S, U.T @ later @ Vt.T, output, future @ U, past @ Vt.T)

    def significant(self, samples: float) -> int:
        """Return how many states ``samples`` of the recording show: canonical correlations above those of noise.

        Of two sets of d independent series of N samples they reach 2 sqrt(d / N (1 - d / N)) (Wachter, Ann. Stat. 8,
        1980).
        """
        share = min(len(self.singular) / samples, 0.5)
        return int(np.sum(self.singular > AMBIENT.edge_margin * 2 * np.sqrt(share * (1 - share))))

    def poles(self, order: int) -> PolesOfOrder:
        """Return the poles of an ``order``."""
        root = np.sqrt(np.maximum(self.singular[:order], np.finfo(float).eps * self.singular[0]))
        values, left, right = eig(self.shifted[:order, :order] / np.outer(root, root), left=True)
        right, left = right / root[:, None], left.conj().T / root
        left = left / np.sum(left.T * root[:, None] ** 2 * right, axis=0)[:, None]
        shapes = (self.output[:, :order] * root**2) @ right
        return PolesOfOrder(order, values, right, left, shapes.T)

    def influence(self, poles: PolesOfOrder, pole: int) -> ComplexArray:
        """Return what each segment adds to one ``pole`` and to the entries of its shape, (segment, 1 + sensor).

        Their means over all segments are zero.
        """
        n, value, shapes = poles.order, poles.values[pole], poles.shapes
        sensors = shapes.shape[1]
        apart = value - np.delete(poles.values, pole)
        others = (np.delete(shapes, pole, axis=0).T / apart) @ np.delete(poles.left, pole, axis=0)
        row = np.vstack([poles.left[pole], others]) @ self.left[:, :n].T  # (functional, row)
        column = (self.right[:, :n] @ poles.right[:, pole]).reshape(-1, sensors)
        row, p = row.reshape(1 + sensors, -1, sensors), len(column)
        slopes = np.zeros((1 + sensors, 2 * p + 1, sensors, sensors), dtype=complex)  # by the correlations
        for i in range(p):
            own = row[:, i, None, :, None] * column[:, None, :]
            slopes[:, i + 2 : i + 2 + p] += own
            slopes[:, i + 1 : i + 1 + p] -= value * own
        for sensor in range(sensors):
            slopes[1 + sensor, 1 : 1 + p, sensor] += column
        parts = self.correlations.parts
        return np.asarray(parts.reshape(len(parts), -1) @ slopes.reshape(1 + sensors, -1).T)


def _hankel(correlations: FloatArray) -> FloatArray:
    """Return the block Hankel matrix (rows sensor, rows sensor) of correlations (2 rows - 1, sensor, sensor)."""
    rows, sensors = (len(correlations) + 1) // 2, correlations.shape[1]
    number = np.add.outer(np.arange(rows), np.arange(rows))
    return np.asarray(correlations[number].transpose(0, 2, 1, 3).reshape(rows * sensors, rows * sensors))


def _roots(correlations: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return T^1/2 and T^-1/2 of the block Toeplitz matrix T of correlations (lag, sensor, sensor)."""
    rows, sensors = correlations.shape[:2]
    both = np.concatenate([correlations[:0:-1].swapaxes(1, 2), correlations])  # from the earliest lag to the latest
    number = rows - 1 + np.subtract.outer(np.arange(rows), np.arange(rows))
    values, vectors = np.linalg.eigh(both[number].transpose(0, 2, 1, 3).reshape(rows * sensors, rows * sensors))
    root = np.sqrt(np.maximum(values, AMBIENT.least_noise_power * values.mean()))
    return (vectors * root) @ vectors.T, (vectors / root) @ vectors.T
