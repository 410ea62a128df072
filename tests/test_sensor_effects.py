"""Sensor faults on signals that are known at every instant."""

import numpy as np
import pytest

from fe_models.built_in.four_dof import four_dof
from fe_models.causes import SensorDelay, SensorDrift, SensorGain
from fe_models.errors import InputError

NAMES = ("a1", "a2")
RATE = 100.0
TIME = np.arange(400) / RATE


def recordings() -> np.ndarray:
    """Two alike of two channels, (realisation, time, sensor)."""
    rng = np.random.default_rng(2)
    return rng.standard_normal((2, 400, 2))


def test_a_sensor_without_a_cable_has_no_scale() -> None:
    dead = SensorGain("a2", -7.6e-6).sentence({"factor": "-7.6e-06 +- 1e-05"}, four_dof())
    assert dead.startswith("Sensor a2 shows next to nothing of the motion")
    assert "cable" in dead
    assert SensorGain("a2", 1e-3).sentence({"factor": "0.001"}, four_dof()).startswith("Sensor a2 shows 0.001 times")


@pytest.mark.parametrize("fault", [SensorGain("a2", 1.2), SensorDelay("a2", 0.003), SensorDrift("a2", 0.5)])
def test_only_the_named_channel_changes_and_the_given_data_stay(fault: SensorGain) -> None:
    data = recordings()
    before = data.copy()
    found = fault.apply(data, NAMES, RATE)
    np.testing.assert_array_equal(data, before)
    np.testing.assert_array_equal(found[..., 0], before[..., 0])
    assert np.abs(found[..., 1] - before[..., 1]).max() > 0.1
    np.testing.assert_array_equal(fault.distort(before[1, :, 1], RATE), found[1, :, 1])  # realisations apart
    with pytest.raises(InputError, match="there is no sensor 'a2'; the sensors are a1"):
        fault.apply(data[..., :1], ("a1",), RATE)
    assert fault.faults(NAMES) == []
    assert len(fault.faults(("b",))) == 1


def test_gain_and_drift_are_what_they_say() -> None:
    y = np.sin(5 * TIME)
    np.testing.assert_allclose(SensorGain("a1", -0.5).distort(y, RATE), -0.5 * y)
    np.testing.assert_allclose(SensorDrift("a1", 0.25).distort(y, RATE), y + 0.25 * TIME, atol=1e-14)


@pytest.mark.parametrize(("per_period", "error"), [(8, 1.2e-3), (14, 1.2e-4), (30, 6e-6)])
@pytest.mark.parametrize("delay", [0.0037, -0.0052, 0.02])
def test_a_delay_shifts_a_sine_by_its_time(delay: float, per_period: int, error: float) -> None:
    """Positive is late: y(t - delay). A cubic spline is off by (2 pi / samples a period)^4 / 384 and a bit."""
    W = 2 * np.pi * RATE / per_period
    found = SensorDelay("a1", delay).distort(np.sin(W * TIME + 0.3), RATE)
    inside = slice(20, -20)  # the end conditions die out by a factor 0.27 a sample
    np.testing.assert_allclose(found[inside], np.sin(W * (TIME - delay) + 0.3)[inside], atol=error)


def test_a_delay_by_whole_samples_moves_them_exactly() -> None:
    y = recordings()[0, :, 0]
    found = SensorDelay("a1", 3 / RATE).distort(y, RATE)
    np.testing.assert_allclose(found[3:], y[:-3], atol=1e-12)
