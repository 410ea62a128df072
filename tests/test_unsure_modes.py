"""Modes under something that nobody knows, and less what a force law does: how sure their values are."""

import numpy as np
import pytest

from hybrid.diagnosis.discrepancy.config import LAW_FIT
from hybrid.diagnosis.modal.measured_modes import MeasuredModes
from hybrid.diagnosis.modal.mode_values import value_count
from hybrid.diagnosis.modes_and_motion.modes_less_law import widened_by_law
from hybrid.diagnosis.modes_and_motion.unsure_modes import widened_by_straying

SENSORS, STEP = 3, 0.05  # rad between samples of a random walk


def modes(frequency: float, ratio: float, shape: list[complex]) -> MeasuredModes:
    """Return one mode that is known exactly."""
    covariance = np.zeros((1, value_count(SENSORS), value_count(SENSORS)))
    return MeasuredModes("r", np.log([frequency]), np.array([ratio]), np.array([shape]), covariance)


@pytest.mark.parametrize("ratio", [0.005, 0.02])
def test_a_mode_that_strays_is_known_as_well_as_its_decay_tells_its_root(ratio: float) -> None:
    """Of motions whose logarithms do a random walk the roots are found by least squares, weighed by their energy."""
    rng, size = np.random.default_rng(1), 0.05
    radians = np.arange(0.0, 4 / ratio, STEP)
    weight = np.exp(-2 * ratio * radians)
    about = radians - weight @ radians / weight.sum()
    walks = size * np.sqrt(STEP) * np.cumsum(rng.standard_normal((300, len(radians))), axis=1)
    slopes = walks @ (weight * about) / (weight @ about**2)
    stated = np.sqrt(widened_by_straying(modes(9.0, ratio, [1, 1, 1]), size).covariance[0, 0, 0])
    # a walk of either part has half of the variance; 300 roots tell a standard deviation to 4 %, 8 % at two sigma, and
    # a decay that ends is worth as much less
    assert slopes.std() == pytest.approx(stated / np.sqrt(2), rel=0.2)


def test_what_is_left_of_a_mode_is_no_surer_than_what_a_law_made_of_it() -> None:
    """Whatever scale and phase its shape has."""
    left = modes(10.0, 0.01, [1.0, 0.5, 0.2])
    under = modes(11.0, 0.03, [2.0j, 1.0j, 0.6j])
    found = widened_by_law(left, under, np.zeros(SENSORS, dtype=int)).covariance[0]
    error = LAW_FIT.relative_error
    assert np.sqrt(found[0, 0]) == pytest.approx(error * np.log(1.1))
    assert np.sqrt(found[1, 1]) == pytest.approx(error * 0.02)
    assert 0 < np.sqrt(found[4, 4]) < error * 0.1
    np.testing.assert_allclose(widened_by_law(left, left, np.zeros(SENSORS, dtype=int)).covariance, 0.0, atol=1e-30)


def test_a_mode_that_the_law_made_of_nothing_like_it_stays_as_it_is() -> None:
    left = modes(10.0, 0.01, [1.0, 0.5, 0.2])
    found = widened_by_law(left, modes(10.1, 0.01, [0.2, -0.5, 0.6]), np.zeros(SENSORS, dtype=int))
    np.testing.assert_array_equal(found.covariance, left.covariance)
