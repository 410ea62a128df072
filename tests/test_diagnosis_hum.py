"""Tones that one sensor picks up: distinguished from machines where other sensors would show that, never sure names."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.blind_cases import BlindConfig, blind_case
from fe_models.recordings import Dataset
from hybrid.diagnosis.outcome.conclusion import Diagnosis
from hybrid.diagnosis.outcome.config import VERDICT
from hybrid.diagnosis.outcome.hum import AS_WELL, LINE, RATHER
from hybrid.diagnosis.outcome.verdict import Verdict
from hybrid.diagnosis.series_diagnosis import diagnose_series as diagnose

SIZE = 0.1  # of a channel's motion


def with_hum(dataset: Dataset, sensor: str, frequency: float) -> Dataset:
    """Return the dataset with a tone on one sensor, its phase another one in each recording."""
    rng, column = np.random.default_rng(0), [s.name for s in dataset.sensors].index(sensor)
    recordings = []
    for recording in dataset.recordings:
        data = recording.data.copy()
        turns = 2 * np.pi * (frequency * np.arange(data.shape[1]) / dataset.sampling_rate + rng.uniform())
        data[..., column] += SIZE * np.sqrt(2) * data[..., column].std() * np.cos(turns)
        recordings.append(replace(recording, data=data))
    return replace(dataset, recordings=tuple(recordings))


def humming(sensor: str, frequency: float) -> Diagnosis:
    """Return the diagnosis of a chain that is off by its uncertainty, and has nothing wrong but hum."""
    clean = blind_case(5, BlindConfig(tier="off", train=4, test=2)).dataset
    return diagnose(with_hum(clean, sensor, frequency))


@pytest.mark.slow
def test_tone_that_a_machine_would_make_as_well_is_no_sure_name() -> None:
    """Five times the highest natural frequency: the next mass would answer with a hundredth of it."""
    found = humming("a1", 1.7)
    (finding,) = found.findings
    assert (finding.cause.kind, finding.cause.location) == ("harmonic_force", {"node": 1, "direction": "x"})
    # What is said where others show nothing at all, moved by chance: they would show a few standard deviations of it.
    assert finding.probability == pytest.approx(VERDICT.listed, abs=0.1)
    assert AS_WELL.format(sensor="a1", frequency=1.7) in found.notes


@pytest.mark.slow
def test_tone_that_no_other_sensor_shows_is_not_named() -> None:
    found = humming("a3", 0.6)
    assert found.verdict is Verdict.UNEXPLAINED
    (note,) = (note for note in found.notes if note.startswith("a tone at "))
    frequency = float(note.split()[3])
    assert note == RATHER.format(sensor="a3", frequency=frequency)
    assert frequency == pytest.approx(0.6, abs=0.001)  # a fiftieth of what a recording resolves
    assert not any("not felt in training" in note for note in found.notes)


@pytest.mark.slow
def test_tone_beyond_all_that_is_fitted_is_reported_as_noise() -> None:
    found = humming("x4", 0.9)
    assert found.findings == ()
    (note,) = (note for note in found.notes if note.startswith("sensor x4 has a line at "))
    assert note == LINE.format(sensor="x4", frequency=45 / 501 * 10)  # the nearest line of 501 samples at 10 Hz
    assert not any("not felt in training" in note for note in found.notes)
    clean = diagnose(blind_case(5, BlindConfig(tier="off", train=4, test=2)).dataset)
    assert not any(" has a line at " in note for note in clean.notes)


@pytest.mark.slow
def test_machine_that_other_sensors_show_is_a_sure_name() -> None:
    found = diagnose(blind_case(61001, BlindConfig(("harmonic_force",), tier="off")).dataset)
    (finding,) = found.findings
    assert finding.cause.kind == "harmonic_force"
    assert finding.probability > 0.99
    assert not any("hum" in note for note in found.notes)
