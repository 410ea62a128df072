"""Frequency response functions: measured, and the model's, against the dynamic stiffness, and told by the command."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt
from typer.testing import CliRunner

import fe_models as fe
from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.base_motion import BaseMotion
from fe_models.damping import full_damping
from fe_models.errors import InputError
from fe_models.files.dataset_file import save_dataset
from fe_models.recordings import Dataset, Load
from fe_models.structure import Spring
from hybrid.commands.app import app
from hybrid.identification.computed_response import computed_response
from hybrid.identification.frequency_response import frequency_response
from tests.test_diagnosis_base_motion import STOREYS, every_sensor

RATE, SAMPLES = 100.0, 4096
SENSORS = ["a1", "a3", "x2"]


def band(seed: int, samples: int = SAMPLES) -> FloatArray:
    """Return a random course (time,) between 0.5 and 20 Hz."""
    white = np.random.default_rng(seed).standard_normal(samples)
    return np.asarray(sosfiltfilt(butter(4, [0.5, 20.0], btype="band", fs=RATE, output="sos"), white))


def shaken(*excitation: Load | BaseMotion, noise: float = 0.0) -> Dataset:
    return fe.simulate(STOREYS, SENSORS, excitation=[excitation], sampling_rate=RATE, noise=noise)


def test_the_models_functions_are_those_of_its_dynamic_stiffness() -> None:
    linear = linearise(STOREYS)
    M, C, K = linear.mass.toarray(), full_damping(linear), linear.stiffness.toarray()
    sensors = (*every_sensor(1), *every_sensor(3))
    frequencies = np.array([0.7, 2.35, 5.0, 11.0])
    found = computed_response(STOREYS, Dataset(STOREYS, RATE, sensors, ()), ((2, "x"), (1.0, 0.0)), frequencies)
    for line, s in enumerate(2j * np.pi * frequencies):
        moved = np.linalg.solve(s**2 * M + s * C + K, np.column_stack([[0, 1, 0], -M @ np.ones(3)]))
        for number, sensor in enumerate(sensors):
            order = ("displacement", "velocity", "acceleration").index(sensor.quantity)
            expected = moved[sensor.node - 1] * s**order
            expected[1] += (sensor.reference == "absolute") * s ** (order - 2)
            np.testing.assert_allclose(found[line, :, number], expected, rtol=1e-9)


def test_two_loads_that_act_together_are_told_apart_by_their_functions() -> None:
    found = frequency_response(shaken(Load(1, "x", 100 * band(1)), Load(3, "x", 100 * band(2))))
    assert found.inputs == ("load at node 1 in x", "load at node 3 in x")
    # Segments of a quarter resolve 0.1 Hz, and the lowest resonance is as wide: its peak is flattened.
    assert found.assurance()[:, :2].min() > 0.93
    assert found.assurance().min() > 0.8  # of a displacement, in which the lowest is all
    assert np.median(found.coherence) > 0.99
    exchanged = found.assurance(found.nominal[:, ::-1])
    assert exchanged[:, :2].max() < 0.3  # as they would be if one were taken for the other


def test_coherence_falls_where_something_unknown_pushes() -> None:
    known, unknown = Load(3, "x", 100 * band(1)), Load(1, "x", 100 * band(2))
    both = shaken(known, unknown)
    hidden = replace(both, recordings=tuple(replace(r, loads=(known,)) for r in both.recordings))
    assert np.median(frequency_response(hidden).coherence) < 0.8 < np.median(frequency_response(both).coherence)


def test_the_base_of_absolute_sensors_has_functions_of_its_own() -> None:
    found = frequency_response(shaken(BaseMotion("x", band(3)), noise=0.01))
    assert found.inputs == ("base along (1, 0)",)
    assert found.assurance()[:, :2].min() > 0.9  # as above; displacements have the drift of the base in them


def test_knocks_are_taken_whole() -> None:
    pulse = np.zeros(2048)
    pulse[100:106] = 500 * np.sin(np.pi * np.arange(6) / 5)
    knocks = [(Load(3, "x", size * np.roll(pulse, shift)),) for size, shift in ((1.0, 0), (1.3, 7), (0.8, 20))]
    found = frequency_response(fe.simulate(STOREYS, SENSORS, excitation=knocks, sampling_rate=RATE, noise=0.0))
    assert found.averages == 3
    assert found.assurance().min() > 0.999  # the answer has died away at the end: nothing leaks


@pytest.mark.slow
def test_what_cannot_be_told_is_refused() -> None:
    course = band(1)
    for excitation, words in (
        ((Load(1, "x", course), Load(3, "x", 2 * course)), "cannot be told apart"),
        ((Load(1, "x", course[:200]), Load(3, "x", band(2)[:200])), "give longer recordings, or more of them"),
    ):
        with pytest.raises(InputError, match=words):
            frequency_response(shaken(*excitation))
    free = shaken(Load(1, "x", course))
    with pytest.raises(InputError, match="names loads or base motion"):
        frequency_response(replace(free, recordings=tuple(replace(r, loads=()) for r in free.recordings)))


def test_the_command_shows_functions_of_driven_recordings(tmp_path: Path) -> None:
    softer = replace(STOREYS, elements=(Spring((1,), "x", 2e4), *STOREYS.elements[1:]))
    save_dataset(replace(shaken(Load(3, "x", 100 * band(1)), noise=0.02), model=softer), tmp_path / "data")
    result = CliRunner().invoke(app, ["compare", str(tmp_path / "data" / "dataset.toml"), "--out", str(tmp_path / "o")])
    assert result.exit_code == 0, result.output
    assert "Frequency response functions" in result.output
    assert "| a1 | 0." in result.output
    assert {file.name for file in (tmp_path / "o").iterdir()} >= {"frequency_response.png", "frequency_response.csv"}
    rows = (tmp_path / "o" / "frequency_response.csv").read_text().splitlines()
    assert rows[0].startswith("frequency_hz,input,sensor,measured_real")
    assert len(rows) > 100


def test_the_command_takes_the_decay_of_a_single_knock_by_its_modes(tmp_path: Path) -> None:
    pulse = np.zeros(2048)
    pulse[3:9] = 500 * np.sin(np.pi * np.arange(6) / 5)
    save_dataset(shaken(Load(3, "x", pulse), noise=0.001), tmp_path / "data")
    result = CliRunner().invoke(app, ["compare", str(tmp_path / "data" / "dataset.toml"), "--out", str(tmp_path / "o")])
    assert result.exit_code == 0, result.output
    assert "Note: no frequency response functions: 1 inputs and 1 segments" in result.output
    assert "MAC" in result.output
