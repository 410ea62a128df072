"""Which measured mode is which of a structure's: by frequency and shape, each at most once."""

import numpy as np
from scipy.optimize import linear_sum_assignment

from fe_models.arrays import ComplexArray, FloatArray, IntArray
from fe_models.modes import mac
from hybrid.diagnosis.modal.config import PAIRING
from hybrid.diagnosis.modal.measured_modes import MeasuredModes


def paired(measured: MeasuredModes, log_omega: FloatArray, shapes: ComplexArray, orders: IntArray) -> IntArray:
    """Return the number of each measured mode's own (..., measured) among those with ``log_omega`` (..., mode) and
    ``shapes`` (..., mode, sensor), -1 where it has none. ``orders`` (sensor,): 0, 1, 2 where displacement, velocity,
    acceleration is sensed.
    """
    found = np.full((*log_omega.shape[:-1], len(measured.log_omega)), -1)
    if not found.shape[-1] or not log_omega.shape[-1]:
        return found
    own = displaced(measured.log_omega, measured.shapes, orders)
    criterion = mac(own.T, displaced(log_omega, shapes, orders).swapaxes(-2, -1))
    criterion[..., ~measured.has_shape, :] = 1.0  # by frequency alone
    apart = np.abs(measured.log_omega[:, None] - log_omega[..., None, :])
    cost = (apart / PAIRING.frequency_scale) ** 2 + (1 - criterion) / PAIRING.mac_scale
    possible = (apart < PAIRING.max_frequency_difference) & (criterion > PAIRING.min_mac) & (cost < PAIRING.max_cost)
    cost = np.where(possible, cost, 2 * PAIRING.max_cost)
    for variant in np.ndindex(found.shape[:-1]):
        rows, columns = linear_sum_assignment(cost[variant])
        made = possible[variant][rows, columns]
        found[variant][rows[made]] = columns[made]
    return found


def displaced(log_omega: FloatArray | float, shapes: ComplexArray, orders: IntArray) -> ComplexArray:
    """Return shapes (..., mode, sensor) of displacements, so that unlike sensors count alike.

    ``log_omega`` (..., mode) of rad/s; ``orders`` (sensor,): see `paired`.
    """
    return np.asarray(shapes * np.exp(-np.asarray(log_omega)[..., None] * orders))
