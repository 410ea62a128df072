"""Samples of a course as a function of time: a spline of degree seven through them, where nothing else is known.

What is sampled has passed an anti-aliasing filter, and holds nothing above half the sampling rate. Straight lines from
sample to sample would take 3 % away from a force at a tenth of the sampling rate, and 26 % at three tenths; cubic
splines 0.02 % and 4 %, these nothing and 0.1 %. A program that applies loads goes in straight lines between their
samples, though, and a converter that drives a shaker holds each of them.
"""

from math import factorial
from typing import TYPE_CHECKING, Literal

import numpy as np

from fe_models.arrays import FloatArray

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

Course = Literal["smooth", "straight", "held"]
"""How a course goes between its samples: as smoothly as it was sampled, in straight lines, or as it was at the last."""
SPLINE_DEGREE = 7
DEGREES: dict[Course, int] = {"smooth": SPLINE_DEGREE, "straight": 1}
ORDERS = SPLINE_DEGREE + 1  # of such a spline: its value and its derivatives


def interpolant(values: FloatArray, axis: int = 0, course: Course = "smooth") -> "BSpline":
    """Return the spline through ``values`` at the samples 0, 1, 2, ... along an ``axis``: time in sampling intervals.

    Of few samples as many degrees as these determine; odd ones, which wiggle least.
    """
    from scipy.interpolate import BSpline, make_interp_spline  # here, as they take longer to load than data to read

    samples = values.shape[axis]
    if course == "held":  # to one interval beyond the last sample, which scipy's own would take for an end
        return BSpline(np.arange(samples + 1.0), values, 0, axis=axis)
    return make_interp_spline(np.arange(samples), values, min(DEGREES[course], samples // 2 * 2 - 1), axis=axis)


def courses_of(values: FloatArray, step: float, course: Course = "smooth") -> FloatArray:
    """Return the courses (order, recording, time, place) of forces with ``values`` (recording, time, place) at samples
    a ``step`` (s) apart; of few samples as many orders as these determine, and zeros.
    """
    samples, spline = np.arange(values.shape[1]), interpolant(values, 1, course)
    return np.stack([spline(samples, order) / step**order for order in range(ORDERS)])


def courses_after(courses: FloatArray, rest: FloatArray) -> FloatArray:
    """Return what courses (order, recording, time, place) are a ``rest`` (time,), s, after each sample."""
    return np.stack(
        [
            sum(courses[order + more] * (rest**more / factorial(more))[:, None] for more in range(ORDERS - order))
            for order in range(ORDERS)
        ]
    )
