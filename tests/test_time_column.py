"""Columns of times: rounding and scatter are fine; lost samples, wandering clocks and wrong rates are named."""

import numpy as np
import pytest

from fe_models.arrays import FloatArray
from fe_models.files.time_column import time_column, time_faults

RATE = 29.97  # Hz, a camera's
SAMPLES = 600
STEADY = np.arange(SAMPLES) / RATE


def scattered(size: float) -> FloatArray:
    """Times that lie up to ``size`` steps from their places."""
    return STEADY + size / RATE * np.random.default_rng(0).uniform(-1.0, 1.0, SAMPLES)


@pytest.mark.parametrize(
    "time",
    [
        STEADY,
        1000.0 + STEADY,  # a clock that has run for a while
        np.round(STEADY, 3),
        np.floor(1000 * STEADY) / 1000,
        np.round(STEADY, 2),  # a third of a step at most
        scattered(0.5),
        scattered(0.5)[:32],
        STEADY * (1 + 1e-4),  # of a clock that is slow
    ],
)
def test_times_that_are_rounded_or_scatter_by_half_a_sample_are_fine(time: FloatArray) -> None:
    assert time_faults(time, RATE, "time") == []


@pytest.mark.parametrize("place", [1, 30, 300, 590, 598])
@pytest.mark.parametrize("scatter", [0.0, 0.25])
def test_one_lost_sample_is_found_wherever_it_is(place: int, scatter: float) -> None:
    time = np.delete(scattered(scatter), place)
    (fault,) = time_faults(time, RATE, "time")
    assert f"time jumps from {time[place - 1]:g} to {time[place]:g} s: give a recording without gaps" in fault


def test_each_gap_has_its_place_and_the_rate_is_not_blamed() -> None:
    (fault,) = time_faults(np.delete(STEADY, [*range(100, 105), *range(300, 420)]), RATE, "time")
    assert "jumps from 3.3033 to 3.5035 s, from 9.97664 to 14.014 s: " in fault
    (again,) = time_faults(STEADY % 5.0, RATE, "time")
    assert "time jumps from 4.97164 to 0.00500501 s, from 4.97664 to 0.01001 s, from" in again


def test_a_rate_that_wanders_is_named() -> None:
    wandering = STEADY + 3.0 / RATE * np.sin(2 * np.pi * STEADY / STEADY[-1])
    (fault,) = time_faults(wandering, RATE, "time")
    assert "time leaves a steady rate by up to" in fault
    assert "resample the recording to a constant rate" in fault


@pytest.mark.parametrize(
    ("time", "rate", "words"),
    [
        (STEADY, 30.3, "time has a step of 0.0333667 s (29.97 Hz), but sampling_rate says 30.3 Hz"),
        (1000 * STEADY, RATE, "but sampling_rate says 29.97 Hz; give times in s (are these ms?)"),
        (0 * STEADY, RATE, "time does not go forward (0 s to 0 s)"),
        (-STEADY, RATE, "time does not go forward"),
        (np.where(STEADY > 5, np.nan, STEADY), RATE, "time holds NaN or infinite values"),
    ],
)
def test_what_times_contradict_is_named(time: FloatArray, rate: float, words: str) -> None:
    (fault,) = time_faults(time, rate, "time")
    assert words in fault


def test_an_unknown_rate_contradicts_nothing() -> None:
    assert time_faults(STEADY, None, "time") == []


def test_the_column_is_found_by_its_usual_names_unless_they_are_a_sensor_s() -> None:
    assert time_column(["x", "Time (s)", "t"], []) == 2
    assert time_column(["x", "TIME", "t"], []) == 1
    assert time_column(["t", "x"], ["t", "x"]) is None
    assert time_column(["x", "Timer"], []) is None
