"""Modal expansion: exact where the shapes are right and the sensors tell them apart."""

from dataclasses import replace

import numpy as np
import pytest

from fe_models.errors import InputError
from fe_models.recordings import Sensor
from hybrid.estimation.modal_expansion import expand
from tests.hybrid_problems import STEP, chain_modes, channels, decay

SENSORS = tuple(
    Sensor(f"a{node}", node, "x", "acceleration", "m/s^2", "held_out" if node == 2 else "measured")
    for node in (1, 2, 3, 4)
)


def windows(modes: int) -> np.ndarray:
    """Accelerations of the chain vibrating in its first modes only."""
    modal, excited = chain_modes(), np.arange(4) < modes
    q, q_dot = np.random.default_rng(0).standard_normal((2, 5, 4)) * excited
    return channels(modal, decay(modal, q, q_dot, STEP, 30), SENSORS)


@pytest.mark.parametrize("modes", [1, 2, 3])
def test_as_many_modes_as_move_give_the_held_out_sensor_exactly(modes: int) -> None:
    """1e-12 of the largest: rounding of a pseudo-inverse; the channel itself, spoilt on purpose, is not looked at."""
    truth = windows(modes)
    spoilt = truth.copy()
    spoilt[:, :, 1] = np.nan
    found = expand(chain_modes(), SENSORS, spoilt, modes)
    np.testing.assert_allclose(found, truth, rtol=0, atol=1e-12 * np.abs(truth).max())


def test_modes_that_are_left_out_are_missed() -> None:
    truth = windows(3)
    assert np.abs(expand(chain_modes(), SENSORS, truth, 2) - truth)[:, :, 1].max() > 0.01 * np.abs(truth).max()


def test_more_modes_than_sensors_give_the_smallest_that_fit() -> None:
    """By hand, q = Phi^T (Phi Phi^T)^-1 x with the two measured rows of Phi (2, 3); 1e-12 of the largest: rounding."""
    truth, shapes = windows(3), chain_modes().shapes[:, :3]
    sensors = (SENSORS[0], SENSORS[1], replace(SENSORS[2], role="held_out"), SENSORS[3])
    measured = shapes[[0, 3]]
    q = truth[:, :, [0, 3]] @ np.linalg.inv(measured @ measured.T) @ measured
    found = expand(chain_modes(), sensors, truth, 3)
    atol = 1e-12 * np.abs(truth).max()
    np.testing.assert_allclose(found[:, :, [1, 2]], q @ shapes[[1, 2]].T, rtol=0, atol=atol)
    np.testing.assert_array_equal(found[:, :, [0, 3]], truth[:, :, [0, 3]])
    assert np.abs(found - truth)[:, :, [1, 2]].max() > 0.01 * np.abs(truth).max()  # too few sensors to be exact


def test_different_quantities_are_refused() -> None:
    mixed = (replace(SENSORS[0], quantity="displacement"), *SENSORS[1:])
    with pytest.raises(InputError, match="one quantity, found acceleration, displacement"):
        expand(chain_modes(), mixed, windows(1), 1)
