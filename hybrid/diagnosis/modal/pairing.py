"""Which measured mode is which of a structure's: by frequency and shape, each at most once."""

import numpy as np
from scipy.optimize import linear_sum_assignment

from fe_models.arrays import ComplexArray, FloatArray, IntArray
from fe_models.modes import mac
from hybrid.diagnosis.modal.config import PAIRING
from hybrid.diagnosis.modal.measured_modes import MeasuredModes


def paired(measured: MeasuredModes, log_omega: FloatArray, shapes: ComplexArray, orders: IntArray) -> IntArray:
    """Return the number of each measured mode's own among those with ``log_omega`` (mode,) and ``shapes`` (mode,
    sensor), -1 where it has none. ``orders`` (sensor,): 0, 1, 2 where displacement, velocity, acceleration is sensed.
    """
    if not len(log_omega) or not len(measured.log_omega):
        return np.full(len(measured.log_omega), -1)
    criterion = mac(_displaced(measured.log_omega, measured.shapes, orders).T, _displaced(log_omega, shapes, orders).T)
    if measured.shown is not None:
        criterion[~measured.shown] = 1.0  # by frequency alone
    apart = np.abs(measured.log_omega[:, None] - log_omega)
    cost = (apart / PAIRING.frequency_scale) ** 2 + (1 - criterion) / PAIRING.mac_scale
    possible = (apart < PAIRING.max_frequency_difference) & (criterion > PAIRING.min_mac) & (cost < PAIRING.max_cost)
    rows, columns = linear_sum_assignment(np.where(possible, cost, 2 * PAIRING.max_cost))
    found = np.full(len(measured.log_omega), -1)
    made = possible[rows, columns]
    found[rows[made]] = columns[made]
    return found


def _displaced(log_omega: FloatArray, shapes: ComplexArray, orders: IntArray) -> ComplexArray:
    """Return shapes (mode, sensor) of displacements, so that unlike sensors count alike."""
    return np.asarray(shapes * np.exp(-np.outer(log_omega, orders)))
