"""Synthetic data sets: the motion of the nonlinear structure as its sensors record it."""

from dataclasses import replace

import numpy as np
import pytest

from fe_models.built_in.bridge import bridge
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import CubicSpring
from fe_models.errors import InputError
from fe_models.files.bridge_recordings import bridge_sensors
from fe_models.files.recording_checks import check_data
from fe_models.four_dof_data import paper_sensors
from fe_models.measurement import measure
from fe_models.simulation import FreeConfig, ReleaseConfig, simulate_free, simulate_release
from fe_models.statics import PointLoad
from fe_models.synthetic import Acquisition, free_dataset, release_dataset

SENSORS = tuple(replace(sensor, unit="m/s^2") for sensor in bridge_sensors())
SHORT = ReleaseConfig(duration=1.0, sampling_rate=500.0, step=2e-3)
PULLS = ((PointLoad(19, "y", -9.81),), (PointLoad(13, "y", -5.0), PointLoad(9, "y", -5.0)))


def rng() -> np.random.Generator:
    return np.random.default_rng(3)


def test_each_release_is_a_recording_and_the_last_a_test() -> None:
    synthetic = release_dataset(bridge(), PULLS, SENSORS, Acquisition(), rng(), SHORT)
    dataset = synthetic.dataset
    assert [(recording.role, recording.data.shape) for recording in dataset.recordings] == [
        ("train", (1, 101, 8)),
        ("test", (1, 101, 8)),
    ]
    assert dataset.model == bridge()
    for recording in dataset.recordings:
        assert check_data(recording.data, [s.name for s in SENSORS], 100.0, 30.0) == []


def test_recording_and_field_start_together_after_the_jump() -> None:
    synthetic = release_dataset(bridge(), PULLS[:1], SENSORS, Acquisition(start=0.1), rng(), SHORT)
    response = simulate_release(bridge(), PULLS[0], replace(SHORT, duration=1.1))
    np.testing.assert_array_equal(synthetic.fields[0], response.displacement[50::5])
    expected = measure(response, SENSORS, 100.0, rng(), 30.0, noise=0.02, start=0.1)
    np.testing.assert_array_equal(synthetic.dataset.recordings[0].data[0], expected)


def test_chain_starts_from_standard_normal_states() -> None:
    chain = four_dof().with_effects(CubicSpring((4,), "x", 0.2))
    acquisition = Acquisition(10.0, None, 0.0)
    dataset = free_dataset(chain, 10, paper_sensors(), acquisition, rng(), FreeConfig(5.0, 10.0))
    assert [(recording.role, len(recording.data)) for recording in dataset.recordings] == [("train", 8), ("test", 2)]
    start = rng().standard_normal((2, 10, 4))
    expected = simulate_free(chain, start[0], start[1], FreeConfig(5.0, 10.0))
    np.testing.assert_array_equal(dataset.recordings[0].data[..., 8:], expected.acceleration[:8])


def test_refuses_what_does_not_fit_before_simulating() -> None:
    wrong = (*SENSORS, replace(SENSORS[0], name="lost", node=99))
    with pytest.raises(InputError) as caught:
        release_dataset(bridge(), ((PointLoad(77, "y", 1.0),),), wrong, Acquisition(lowpass=60.0), rng())
    lowpass, sensor, load = caught.value.faults
    assert "lowpass = 60 Hz" in lowpass
    assert "sensor 'lost': node 99 does not exist" in sensor
    assert "node 77 has no degree of freedom" in load
    with pytest.raises(InputError, match="nothing to release"):
        release_dataset(bridge(), (), SENSORS, Acquisition(), rng())
