"""Frequency response functions: measured, and the model's, against the dynamic stiffness, and told by the command."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import butter, sosfiltfilt
from typer.testing import CliRunner

import fe_models as fe
import hybrid
from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.base_motion import BaseMotion
from fe_models.causes import CubicSpring
from fe_models.damping import full_damping
from fe_models.errors import InputError
from fe_models.files.dataset_file import save_dataset
from fe_models.files.matrices_file import load_linear_model
from fe_models.files.structure_file import save_structure
from fe_models.recordings import Assumptions, Dataset, Load, Sensor
from fe_models.structure import Spring, Structure
from hybrid.commands.app import app
from hybrid.identification.computed_response import computed_response
from hybrid.identification.dataset_comparison import compare_dataset
from hybrid.identification.frequency_response import FrequencyResponse, frequency_response
from hybrid.identification.frequency_response_report import describe_responses
from tests.blank_sheets import blank_sheets
from tests.space_frames import two_storeys
from tests.test_diagnosis_base_motion import STOREYS, every_sensor

RATE, SAMPLES = 100.0, 4096
SENSORS = ["a1", "a3", "x2"]


def band(seed: int, samples: int = SAMPLES) -> FloatArray:
    """Return a random course (time,) between 0.5 and 20 Hz."""
    white = np.random.default_rng(seed).standard_normal(samples)
    return np.asarray(sosfiltfilt(butter(4, [0.5, 20.0], btype="band", fs=RATE, output="sos"), white))


def knock(samples: int) -> FloatArray:
    """Return half a sine of six samples (time,), N."""
    pulse = np.zeros(samples)
    pulse[100:106] = 500 * np.sin(np.pi * np.arange(6) / 5)
    return pulse


def shaken(*excitation: Load | BaseMotion, noise: float = 0.0) -> Dataset:
    return fe.simulate(STOREYS, SENSORS, excitation=[excitation], sampling_rate=RATE, noise=noise)


@cache
def by_a_shaker() -> Dataset:
    return shaken(Load(3, "x", 100 * band(1)))


@cache
def by_two_shakers() -> Dataset:
    return shaken(Load(1, "x", 100 * band(1)), Load(3, "x", 100 * band(2)))


def nominal_assurance(found: FrequencyResponse) -> FloatArray:
    return found.assurance(found.models["nominal"])


def softened(structure: Structure) -> Structure:
    """Return the storeys with a lowest one of half the stiffness, what a drawing may say of them."""
    return replace(structure, elements=(Spring((1,), "x", 2e4), *structure.elements[1:]))


def test_the_models_functions_are_those_of_its_dynamic_stiffness() -> None:
    linear = linearise(STOREYS)
    M, C, K = linear.mass.toarray(), full_damping(linear), linear.stiffness.toarray()
    sensors = (*every_sensor(1), *every_sensor(3))
    frequencies = np.array([0.7, 2.35, 5.0, 11.0])
    found = computed_response(STOREYS, sensors, ((2, "x"), (1.0, 0.0)), frequencies)
    for line, s in enumerate(2j * np.pi * frequencies):
        moved = np.linalg.solve(s**2 * M + s * C + K, np.column_stack([[0, 1, 0], -M @ np.ones(3)]))
        for number, sensor in enumerate(sensors):
            order = ("displacement", "velocity", "acceleration").index(sensor.quantity)
            expected = moved[sensor.node - 1] * s**order
            expected[1] += (sensor.reference == "absolute") * s ** (order - 2)
            np.testing.assert_allclose(found[line, :, number], expected, rtol=1e-9)


def test_two_loads_that_act_together_are_told_apart_by_their_functions() -> None:
    found = frequency_response(by_two_shakers())
    assert found.inputs == ("load at node 1 in x", "load at node 3 in x")
    # Segments of a quarter resolve 0.1 Hz, and the lowest resonance is as wide: its peak is flattened.
    assert nominal_assurance(found)[:, :2].min() > 0.93
    assert nominal_assurance(found).min() > 0.8  # of a displacement, in which the lowest is all
    assert np.median(found.coherence) > 0.99
    exchanged = found.assurance(found.models["nominal"][:, ::-1])
    assert exchanged[:, :2].max() < 0.3  # as they would be if one were taken for the other


def test_coherence_falls_where_something_unknown_pushes() -> None:
    known, both = Load(3, "x", 100 * band(2)), by_two_shakers()
    hidden = replace(both, recordings=tuple(replace(r, loads=(known,)) for r in both.recordings))
    assert np.median(frequency_response(hidden).coherence) < 0.8 < np.median(frequency_response(both).coherence)


def test_the_base_of_absolute_sensors_has_functions_of_its_own() -> None:
    found = frequency_response(shaken(BaseMotion("x", band(3)), noise=0.01))
    assert found.inputs == ("base along (1, 0)",)
    assert nominal_assurance(found)[:, :2].min() > 0.9  # as above; displacements have the drift of the base in them


@pytest.mark.slow
def test_knocks_are_taken_whole() -> None:
    knocks = [(Load(3, "x", size * np.roll(knock(2048), shift)),) for size, shift in ((1.0, 0), (1.3, 7), (0.8, 20))]
    found = frequency_response(fe.simulate(STOREYS, SENSORS, excitation=knocks, sampling_rate=RATE, noise=0.0))
    assert found.averages == 3
    assert nominal_assurance(found).min() > 0.999  # the answer has died away at the end: nothing leaks


@pytest.mark.slow
def test_an_extended_model_stands_beside_the_nominal_one() -> None:
    knocks = shaken(Load(3, "x", knock(2048)), Load(1, "x", np.roll(knock(2048), 3)))
    two = replace(knocks, recordings=(*knocks.recordings, *shaken(Load(3, "x", knock(2048))).recordings) * 2)
    found = frequency_response(replace(two, model=softened(STOREYS)), STOREYS)
    assert list(found.models) == ["nominal", "extended"]
    deviation = {name: found.deviation(own).max() for name, own in found.models.items()}
    assert deviation["extended"] < 0.05 < 0.5 < deviation["nominal"]  # the knock is a curve between its samples
    assert found.factor(found.models["extended"]) == pytest.approx(1.0, abs=0.02)
    text = describe_responses(found)
    assert "| sensor | coherence | load at node 1 in x, nominal | load at node 1 in x, extended |" in text
    assert text.splitlines()[-1].endswith(f"extended {found.deviation(found.models['extended']).mean():.1%}")
    print(text)


@pytest.mark.slow
def test_functions_have_the_damping_that_the_dataset_assumes_and_no_force_laws() -> None:
    data = by_a_shaker()
    assumed = replace(data, assumptions=Assumptions(damping_ratio=0.2))
    spring = STOREYS.with_effects(CubicSpring((1,), "x", 1e9))
    found = frequency_response(assumed, spring)
    assert found.left_out == ("cubic_spring",)
    assert "cubic_spring of the models is not in them" in describe_responses(found)
    own = frequency_response(data).models["nominal"]
    np.testing.assert_allclose(found.models["extended"], own, rtol=1e-12)  # small motion feels no cubic spring
    assert np.abs(found.models["nominal"]).max() < 0.5 * np.abs(own).max()  # the drawn damping is 5 times less


def test_functions_of_matrices_in_space_with_a_rigid_link_and_a_base_that_rises(tmp_path: Path) -> None:
    arrays = two_storeys()
    np.savez(tmp_path / "m.npz", **arrays)  # type: ignore[arg-type]  # numpy's stubs take them for allow_pickle
    model = load_linear_model(tmp_path / "m.npz")
    sensor = Sensor("a", 4, "x", "acceleration", "m/s^2")
    s = 2j * np.pi * 3.7
    found = computed_response(model, [sensor], [(4, "y"), (1.0, 0.0), (0.6, 0.0, 0.8)], np.array([3.7]))[0, :, 0]
    stiff = s**2 * arrays["M"] + s * full_damping(model) + arrays["K"]
    follows = np.array([[1, 0, -1.0], [0, 1, 2.0]])  # node 4 at (2, 1) beside node 2: x - y rz, y + x rz
    pull = np.zeros((6, 3))
    pull[:3, 0] = follows[1]
    pull[:, 1] = -arrays["M"] @ [1, 0, 0, 1, 0, 0]
    pull[:, 2] = 0.6 * pull[:, 1]  # nothing of this model moves in z
    moved = np.concatenate([follows[0], np.zeros(3)]) @ np.linalg.solve(stiff, pull) * s**2
    np.testing.assert_allclose(found, moved + np.array([0, 1, 0.6]), rtol=1e-9)


def test_recordings_at_several_rates_are_no_recordings_of_one_function() -> None:
    data = by_a_shaker()
    slower = replace(data.recordings[0], name="slower", sampling_rate=50.0)
    with pytest.raises(InputError, match="at 50 and 100 Hz: frequency response functions need one rate"):
        frequency_response(replace(data, recordings=(*data.recordings, slower)))


@blank_sheets()
def test_a_notebook_has_the_functions_that_the_command_has(tmp_path: Path) -> None:
    data = by_a_shaker()
    found = hybrid.compare_recordings(data, extended=softened(STOREYS))
    assert found.modes is None
    assert found.responses is not None
    assert list(found.responses.models) == ["nominal", "extended"]
    assert repr(found) == describe_responses(frequency_response(data, softened(STOREYS)))
    assert "Frequency response functions" in found.to_html(tmp_path / "page.html").read_text()
    assert (found.save(tmp_path / "saved") / "comparison.txt").read_text() == repr(found) + "\n"


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
    (clean,) = by_a_shaker().recordings
    noise = 0.02 * clean.data.std(axis=1) * np.random.default_rng(0).standard_normal(clean.data.shape)
    data = replace(by_a_shaker(), recordings=(replace(clean, data=clean.data + noise),), model=softened(STOREYS))
    file = str(save_dataset(data, tmp_path / "data"))
    save_structure(STOREYS, tmp_path / "extended_model.toml")
    options = ["--out", str(tmp_path / "o"), "--extended", str(tmp_path / "extended_model.toml")]
    result = CliRunner().invoke(app, ["compare", file, *options])
    assert result.exit_code == 0, result.output
    assert "Frequency response functions" in result.output
    assert "| a1 | 0." in result.output
    assert {file.name for file in (tmp_path / "o").iterdir()} >= {"frequency_response.png", "frequency_response.csv"}
    rows = (tmp_path / "o" / "frequency_response.csv").read_text().splitlines()
    courses = [f"{name}_{part}" for name in ("measured", "nominal", "extended") for part in ("real", "imag")]
    assert rows[0].split(",") == ["frequency_hz", "input", "sensor", *courses, "coherence"]
    assert len(rows) > 100


def test_the_command_refuses_an_extended_model_that_does_not_fit(tmp_path: Path) -> None:
    file = str(save_dataset(by_a_shaker(), tmp_path / "data"))
    options = ["--out", str(tmp_path / "o"), "--extended"]
    smaller = replace(
        STOREYS, nodes=STOREYS.nodes[:2], elements=STOREYS.elements[:2], point_masses=STOREYS.point_masses[:2]
    )
    save_structure(smaller, tmp_path / "smaller.toml")
    result = CliRunner().invoke(app, ["compare", file, *options, str(tmp_path / "smaller.toml")])
    assert result.exit_code == 2
    assert "sensor 'a3': node 3 does not exist; the model's nodes are 1 to 2" in result.output
    assert "load at node 3 in x: node 3 does not exist" in result.output


def test_the_decay_of_a_knock_that_was_double_has_the_structure_s_modes() -> None:
    twice = Load(3, "x", np.roll(knock(1200), -50) + 2 * np.roll(knock(1200), 150))  # a second blow 2 s after the first
    found = compare_dataset(shaken(twice, noise=0.001))
    assert "no frequency response functions: 1 inputs and 1 segments" in found.notes[0]
    assert found.compared is not None
    (seen,) = found.compared.recordings
    numbers = [number for number in seen.chosen if number >= 0]
    assert len(numbers) == 3
    np.testing.assert_allclose(seen.identified.frequencies[numbers], found.compared.nominal, rtol=2e-4)
    np.testing.assert_allclose(seen.identified.ratios[numbers], fe.natural_modes(STOREYS).damping_ratio, rtol=0.02)


def test_what_keeps_both_from_being_compared_is_told() -> None:
    still = shaken(Load(3, "x", knock(512)), noise=0.0)
    noise = np.random.default_rng(0).standard_normal((1, 512, 3))
    data = replace(still, recordings=(replace(still.recordings[0], data=noise),))
    with pytest.raises(InputError, match="no frequency response functions") as caught:
        compare_dataset(data)
    assert any("none of the model's modes is seen" in fault for fault in caught.value.faults)


@pytest.mark.slow
def test_the_command_takes_the_decay_of_a_single_knock_by_its_modes(tmp_path: Path) -> None:
    save_dataset(shaken(Load(3, "x", np.roll(knock(2048), -97)), noise=0.001), tmp_path / "data")
    result = CliRunner().invoke(app, ["compare", str(tmp_path / "data" / "dataset.toml"), "--out", str(tmp_path / "o")])
    assert result.exit_code == 0, result.output
    assert "Note: no frequency response functions: 1 inputs and 1 segments" in result.output
    assert "MAC" in result.output
