"""A column of times beside recorded channels: whether it goes on steadily, at the sampling rate that is stated.

The step of n samples is (last - first) / (n - 1), which rounding hardly moves: times in whole milliseconds give
29.97 Hz to 0.01 %, where from one to the next it is 33 or 34 ms. Clocks that scatter about a steady rate are fine.
"""

import numpy as np

from fe_models.arrays import BoolArray, FloatArray, IntArray

NAMES = ("time", "t", "time (s)", "time [s]", "t (s)", "t [s]", "time_s", "seconds", "timestamp", "datetime", "zeit")
"""What loggers call it, in small letters or capitals; the first is the one that our documents name."""

MAX_SCATTER = 0.5  # of a step: a time further from its place is nearer to another sample's
MIN_SHIFT = 0.75  # of a step: between that scatter and one lost sample
MEAN_SAMPLES = 20  # on both sides of a jump, whose times are averaged: scatter of half a step leaves 0.1 of one
USUAL_SPAN = 1 / 8  # of a recording, over which steps are measured: few of them have a jump in them ...
MIN_USUAL_SPAN = 10  # samples, or a quarter of a recording, ... while scatter matters little
RATE_TOLERANCE = 0.01  # relative: stated rates are often rounded to two or three digits
MAX_JUMPS_NAMED = 3
MAX_LOST = 1_000_000  # rows in one gap that are given a place: a longer pause of a logger cuts a recording as well
MILLISECONDS = 1000.0  # in a second


def time_column(header: list[str], others: list[str]) -> int | None:
    """Return the number of the column of times, None where there is none; ``others`` are names of something else."""
    names = [None if name in others else name.lower() for name in header]
    return next((names.index(name) for name in NAMES if name in names), None)


def is_time(name: str) -> bool:
    """Whether a column of that name holds times."""
    return name.lower() in NAMES


def time_faults(time: FloatArray, sampling_rate: float | None, what: str) -> list[str]:
    """Return what is wrong with times (sample,) in s: they jump, wander, or contradict ``sampling_rate`` (Hz).

    ``what`` names the column in the sentences.
    """
    if len(time) < 2:
        return []
    if not np.isfinite(time).all():
        return [f"{what} holds NaN or infinite values"]
    usual = _usual_step(time)
    if usual <= 0:
        return [f"{what} does not go forward ({time[0]:g} s to {time[-1]:g} s)"]
    jumps = np.flatnonzero(_jumps(time, usual))
    if len(jumps):
        places = ", ".join(f"from {time[i]:g} to {time[i + 1]:g} s" for i in jumps[:MAX_JUMPS_NAMED])
        more = f" and at {len(jumps) - MAX_JUMPS_NAMED} more places" if len(jumps) > MAX_JUMPS_NAMED else ""
        remedy = "give a recording without gaps, or each part as a recording of its own"
        return [*_rate_faults(time, usual, sampling_rate, what), f"{what} jumps {places}{more}: {remedy}"]
    step = (time[-1] - time[0]) / (len(time) - 1)
    scatter = float(np.ptp(_off_a_steady_rate(time)) / 2)
    if scatter > MIN_SHIFT * step:
        remedy = "resample the recording to a constant rate"
        return [f"{what} leaves a steady rate by up to {scatter / step:.1f} samples: {remedy}"]
    return _rate_faults(time, step, sampling_rate, what)


def places_of_rows(time: FloatArray) -> IntArray | None:
    """Return where rows (row,) with these times (s) belong among all samples, those between them that were lost.

    None where none was lost, and where the clock goes back or jumps by a part of a sample, which `time_faults` names.
    """
    if len(time) < 2 or not np.isfinite(time).all() or (usual := _usual_step(time)) <= 0:
        return None
    jumps = np.flatnonzero(_jumps(time, usual))
    lost = np.rint((time[jumps + 1] - time[jumps]) / usual) - 1
    if not len(jumps) or lost.min() < 1:
        return None
    steps = np.ones(len(time) - 1, dtype=np.int64)
    steps[jumps] += np.minimum(lost, MAX_LOST).astype(np.int64)
    return np.concatenate([[0], np.cumsum(steps)])


def usual_rate_faults(time: FloatArray, sampling_rate: float | None, what: str) -> list[str]:
    """Return a fault where the step that most rows of times (row,), s, have contradicts ``sampling_rate`` (Hz)."""
    return _rate_faults(time, _usual_step(time), sampling_rate, what)


def _rate_faults(time: FloatArray, step: float, sampling_rate: float | None, what: str) -> list[str]:
    if sampling_rate is None:
        return []
    ends = 2 * MAX_SCATTER / (len(time) - 1)  # relative: what two ends that scatter can do to the mean step
    ratio = step * sampling_rate
    if abs(ratio - 1) <= max(RATE_TOLERANCE, ends):
        return []
    unit = "; give times in s (are these ms?)" if abs(ratio / MILLISECONDS - 1) <= RATE_TOLERANCE else ""
    return [f"{what} has a step of {step:g} s ({1 / step:g} Hz), but sampling_rate says {sampling_rate:g} Hz{unit}"]


def _usual_step(time: FloatArray) -> float:
    """Return the step that most samples have, whatever jumps there are."""
    span = max(1, round(USUAL_SPAN * len(time)), min(MIN_USUAL_SPAN, len(time) // 4))
    return float(np.median(time[span:] - time[:-span])) / span


def _jumps(time: FloatArray, step: float) -> BoolArray:
    """Return after which samples but the last the clock has jumped and stays there, unlike one that only scatters."""
    off = time - step * np.arange(len(time))
    sums = np.concatenate([[0.0], np.cumsum(off)])
    now = np.arange(1, len(time))  # the first sample after each interval
    first, last = np.maximum(now - MEAN_SAMPLES, 0), np.minimum(now + MEAN_SAMPLES, len(time))
    moved = (sums[last] - sums[now]) / (last - now) - (sums[now] - sums[first]) / (now - first)
    apart = np.abs(np.diff(off)) > MAX_SCATTER * step
    return np.asarray(apart & (np.abs(moved) > MIN_SHIFT * step))


def _off_a_steady_rate(time: FloatArray) -> FloatArray:
    """Return how far (sample,) times lie from the straight line through them, s."""
    number = np.arange(len(time)) - (len(time) - 1) / 2
    slope = number @ time / (number @ number)
    return np.asarray(time - slope * number)
