"""Samples of a course as a function of time: a spline of degree seven through them.

What is sampled has passed an anti-aliasing filter, and holds nothing above half the sampling rate. Straight lines from
sample to sample would take 3 % away from a force at a tenth of the sampling rate, and 26 % at three tenths; cubic
splines 0.02 % and 4 %, these nothing and 0.1 %.
"""

from math import factorial
from typing import TYPE_CHECKING

import numpy as np

from fe_models.arrays import FloatArray

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

SPLINE_DEGREE = 7
ORDERS = SPLINE_DEGREE + 1  # of such a spline: its value and its derivatives


def interpolant(values: FloatArray, axis: int = 0) -> "BSpline":
    """Return the spline through ``values`` at the samples 0, 1, 2, ... along an ``axis``: time in sampling intervals.

    Of few samples as many degrees as these determine; odd ones, which wiggle least.
    """
    from scipy.interpolate import make_interp_spline  # here, as it takes longer to load than a dataset to read

    samples = values.shape[axis]
    return make_interp_spline(np.arange(samples), values, min(SPLINE_DEGREE, samples // 2 * 2 - 1), axis=axis)


def courses_of(values: FloatArray, step: float) -> FloatArray:
    """Return the courses (order, recording, time, place) of forces with ``values`` (recording, time, place) at samples
    a ``step`` (s) apart; of few samples as many orders as these determine, and zeros.
    """
    samples, spline = np.arange(values.shape[1]), interpolant(values, axis=1)
    return np.stack([spline(samples, order) / step**order for order in range(ORDERS)])


def courses_after(courses: FloatArray, rest: FloatArray) -> FloatArray:
    """Return what courses (order, recording, time, place) are a ``rest`` (time,), s, after each sample."""
    return np.stack(
        [
            sum(courses[order + more] * (rest**more / factorial(more))[:, None] for more in range(ORDERS - order))
            for order in range(ORDERS)
        ]
    )
