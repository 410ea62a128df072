"""Whether nominal values are calibrated further off than their owner thinks normal: a cause may hide behind that."""

import numpy as np
from scipy.stats import norm

from hybrid.diagnosis.fitting.fitting import Fit

ONE_IN = 200  # structures: in which chance has one calibrated factor as far off as `farthest_of`
TOGETHER = 3.0  # standard deviations of the mean square of all of them over its mean


def farthest_of(factors: int) -> float:
    """Return how many stated standard deviations off one of so many factors is by chance: 3.5 of 12, 3.9 of 42."""
    return float(norm.isf(0.5 / ONE_IN / factors))


def factors_off(item: Fit) -> bool:
    """Return whether the calibrated factors are further off than their owner thinks normal: one, or all together."""
    return bool(np.abs(item.deviations).max() > farthest_of(len(item.deviations))) or off_together(item)


def off_together(item: Fit) -> bool:
    """Return whether the calibrated factors are off by more than chance has it of so many."""
    return bool(np.mean(item.deviations**2) > 1 + TOGETHER * np.sqrt(2 / len(item.deviations)))
