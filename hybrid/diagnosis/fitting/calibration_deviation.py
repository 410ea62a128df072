"""How far nominal values are calibrated off, and whether beyond what is normal: a cause may hide behind that."""

import numpy as np
from scipy.stats import norm

from fe_models.arrays import FloatArray
from hybrid.diagnosis.fitting.config import CALIBRATION
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.nominal.config import SCATTER


def within(item: Fit, most: float) -> FloatArray:
    """Return the theta (parameter,) of a fit, nominal values no further off than ``most`` standard deviations.

    As far as its ``deviations`` measure them.
    """
    count, factors = item.hypothesis.nuisances, item.hypothesis.nominal.factors
    farthest = most * item.hypothesis.width[:count]
    least, whole = -farthest, farthest[:factors] >= 1  # which no factor can be below nominal
    least[:factors] = np.where(whole, -np.inf, np.log1p(-np.where(whole, 0.0, farthest[:factors])))
    return np.append(np.clip(item.theta[:count], least, farthest), item.theta[count:])


def deviation_of(item: Fit) -> float:
    """Return how far the calibration of a fit goes, at most, in stated standard deviations."""
    return float(np.abs(item.deviations).max())


def deviation_of_groups(item: Fit) -> float:
    """Return how far it goes where an element by itself may be as far off as its group: nobody stated how far one
    differs from it, and the quarter of the group's uncertainty that a search takes is a guess.
    """
    nominal, off = item.hypothesis.nominal, np.abs(item.deviations)
    return float(np.append(off[: nominal.factors], SCATTER.element_std_share * off[nominal.factors :]).max())


def goes_far(item: Fit) -> bool:
    """Return whether the calibration of a fit goes further than is normal, so that it may hide what led it there."""
    return deviation_of(item) > CALIBRATION.max_deviation_sigma


def farthest_of(factors: int) -> float:
    """Return how many stated standard deviations off one of so many factors is by chance: 3.5 of 12, 3.9 of 42."""
    return float(norm.isf(0.5 / CALIBRATION.structures_per_false_alarm / factors))


def factors_off(item: Fit) -> bool:
    """Return whether the calibrated factors are further off than their owner thinks normal: one, or all together."""
    return bool(np.abs(item.deviations).max() > farthest_of(len(item.deviations))) or off_together(item)


def off_together(item: Fit) -> bool:
    """Return whether the calibrated factors are off by more than chance has it of so many."""
    return bool(np.mean(item.deviations**2) > 1 + CALIBRATION.max_joint_sigma * np.sqrt(2 / len(item.deviations)))
