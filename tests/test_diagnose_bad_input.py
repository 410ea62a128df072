"""Recordings as they come: unequal, dead or saturated channels, few of them; what is unusable is refused at once."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from benchmarks.blind_cases import BlindConfig, blind_case
from fe_models.assembly import linearise
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import CubicSpring
from fe_models.causes.candidate import LawCandidate
from fe_models.errors import InputError
from fe_models.files.dataset_file import save_dataset
from fe_models.lowpass import LowPass
from fe_models.recordings import Dataset
from fe_models.structure import Spring
from hybrid.diagnosis.contest.setting import setting_of
from hybrid.diagnosis.contest.wrong_units import shown_otherwise, with_other_units
from hybrid.diagnosis.diagnosis import diagnose
from hybrid.diagnosis.modes_and_motion.modal_diagnosis import diagnose_modes
from hybrid.diagnosis.nominal.basis import basis_of
from hybrid.diagnosis.recorded.faulty_channels import usable
from hybrid.diagnosis.recorded.offsets import offsets
from hybrid.diagnosis.recorded.unit_check import other_sizes
from hybrid.diagnosis.response.marching import is_too_fast
from scripts.diagnose import app
from tests.chain_case import CASE, NAMES, clipped, with_data


def diagnosed(dataset: Dataset, folder: Path) -> dict[str, Any]:
    """Return the report that the script writes of a dataset."""
    path = save_dataset(dataset, folder, "four_dof")
    done = CliRunner().invoke(app, [str(path), "--out", str(folder / "out")])
    assert done.exit_code == 0, done.output
    report = json.loads((folder / "out" / "report.json").read_text())
    for note in report["notes"]:
        assert note in done.output
    return report


def assert_added_mass(report: dict[str, Any]) -> None:
    assert report["findings"][0]["kind"] == "added_mass"


@pytest.mark.slow
def test_recordings_of_unequal_length(tmp_path: Path) -> None:
    lengths = {r.name: r.data[:, : 200 - 30 * i] for i, r in enumerate(CASE.recordings)}
    report = diagnosed(with_data(CASE, lengths), tmp_path)
    assert_added_mass(report)
    assert report["findings"][0]["recordings"][:3] == ["r01", "r02", "r03"]


@pytest.mark.slow
def test_dead_channel_is_left_out_and_said(tmp_path: Path) -> None:
    column = np.arange(5) == NAMES.index("a3")
    dead = with_data(CASE, {r.name: np.where(column, 0.0, r.data) for r in CASE.recordings})
    report = diagnosed(dead, tmp_path)
    assert_added_mass(report)
    assert any("sensor a3 never changes" in note and note.endswith("left out") for note in report["notes"])


@pytest.mark.slow
@pytest.mark.parametrize("sensor", ["a1", "a4", "x4"])
@pytest.mark.parametrize("factor", [1000.0, 1 / 9.81, 0.001])
def test_channel_in_another_unit_is_detected_by_the_others(sensor: str, factor: float) -> None:
    sound = blind_case(5, BlindConfig(tier="off")).dataset
    setting = setting_of(in_other_unit(sound, sensor, factor))
    column, found = shown_otherwise(setting.short, setting.searched)
    assert setting.noise_model.sensors[column].name == sensor
    assert abs(found / factor - 1) < 0.1  # the structure as drawn is off, too


@pytest.mark.slow
def test_channels_whose_units_are_right_are_believed() -> None:
    for seed in (3, 5):
        setting = setting_of(blind_case(seed, BlindConfig(tier="off", kinds=("sensor_gain",))).dataset)
        assert with_other_units(setting.candidates(), setting.short, setting.searched) == setting.candidates()


@pytest.mark.slow
@pytest.mark.parametrize("factor", [1000.0, 0.001])  # mm/s^2, and m/s^2 that says mm/s^2
def test_channel_in_another_unit_is_named(factor: float, tmp_path: Path) -> None:
    """A prior of calibrations, which are off by tenths, would never believe a factor of a thousand."""
    report = diagnosed(in_other_unit(blind_case(3, BlindConfig(tier="off")).dataset, "a4", factor), tmp_path)
    (finding,) = report["findings"]
    assert finding["kind"] == "sensor_gain"
    assert finding["location"] == {"sensor": "a4"}
    assert finding["probability"] > 0.9
    found = finding["parameters"]["factor"]
    assert abs(found["value"] - factor) < 3 * found["std"] < 0.03 * factor
    assert "check its unit" in finding["sentence"]


def in_other_unit(sound: Dataset, sensor: str, factor: float) -> Dataset:
    scale = np.where(np.arange(5) == NAMES.index(sensor), factor, 1.0)
    return with_data(sound, {r.name: scale * r.data for r in sound.recordings})


@pytest.mark.slow
def test_sampling_rate_that_is_off_by_two_is_asked_for(tmp_path: Path) -> None:
    sound = blind_case(3, BlindConfig(train=3, test=1)).dataset
    report = diagnosed(replace(sound, sampling_rate=sound.sampling_rate / 2), tmp_path)
    (note,) = (note for note in report["notes"] if "check sampling_rate" in note)
    assert "observed at 0.5 times" in note
    report = diagnosed(sound, tmp_path)
    assert not any("check sampling_rate" in note for note in report["notes"])


def test_channel_that_does_not_swing_about_zero_is_reported() -> None:
    """Gravity left in an accelerometer is an offset, also one that decays slowly; a drift of the same mean is none, nor
    is what has died down before the end.
    """
    column, time = NAMES.index("a1"), np.linspace(0, 1, CASE.recordings[0].data.shape[1])
    assert offsets(CASE, range(5)) == []
    shapes = {"steady": np.ones_like(time), "slowly": np.exp(-time / 5), "drift": 2 * time, "dies": np.exp(-2 * time)}
    for name, shape in shapes.items():
        added = 9.81 * np.where(np.arange(5) == column, shape[:, None], 0.0)
        notes = offsets(with_data(CASE, {r.name: r.data + added for r in CASE.recordings}), range(5))
        sizes = {"steady": "9.81", "slowly": "8.89"}
        expected = [f"sensor a1 shows {sizes[name]} m/s^2"] if name in sizes else []
        assert [note.split(" in ")[0] for note in notes] == expected


def test_recording_in_another_unit_is_reported() -> None:
    one = CASE.recordings[1].name
    (note,) = other_sizes(with_data(CASE, {one: 1000 * CASE.recordings[1].data}))
    assert note.startswith(f"motions of {one} are ")
    two = {r.name: 1000 * r.data for r in CASE.recordings[1:3]}
    (note,) = other_sizes(with_data(CASE, two))
    assert note.startswith(f"motions of {', '.join(two)} are ")
    assert other_sizes(with_data(CASE, {one: 10 * CASE.recordings[1].data})) == []


@pytest.mark.slow
def test_saturated_channel_is_cut_out_and_said(tmp_path: Path) -> None:
    report = diagnosed(with_data(CASE, {"r01": clipped(CASE.recordings[0].data, "a1", 0.7)}), tmp_path)
    assert_added_mass(report)
    assert report["findings"][0]["probability"] > 0.9
    assert any("sensor a1 is saturated" in note and "samples of r01" in note for note in report["notes"])


@pytest.mark.slow
def test_without_test_recordings_it_says_what_is_scored(tmp_path: Path) -> None:
    alone = tuple(replace(r, role="train") for r in CASE.recordings)
    report = diagnosed(replace(CASE, recordings=alone), tmp_path)
    assert_added_mass(report)
    assert report["scores"]["extended"]["measured"] < 1.3 * report["noise_floor"]
    assert any("no recording is for testing" in note for note in report["notes"])


@pytest.mark.slow
def test_one_recording(tmp_path: Path) -> None:
    report = diagnosed(replace(CASE, recordings=CASE.recordings[:1]), tmp_path)
    assert report["verdict"] != "nothing_wrong"
    assert any("one recording" in note for note in report["notes"])


@pytest.mark.slow
def test_one_sensor(tmp_path: Path) -> None:
    one = replace(
        CASE,
        sensors=CASE.sensors[3:4],
        recordings=tuple(replace(r, data=r.data[..., 3:4]) for r in CASE.recordings),
    )
    report = diagnosed(one, tmp_path)
    assert report["verdict"] != "nothing_wrong"
    assert report["scores"]["baseline"]["held_out"] is None


def test_all_that_is_unusable_is_refused_at_once(tmp_path: Path) -> None:
    first, second = CASE.recordings[0].data.copy(), CASE.recordings[1].data.copy()
    first[0, 7, 1] = np.inf
    path = save_dataset(with_data(CASE, {"r01": first, "r02": second[:, :10]}), tmp_path, "four_dof")
    done = CliRunner().invoke(app, [str(path), "--out", str(tmp_path / "out")])
    assert done.exit_code == 2
    assert "channel 'a1': 1 samples are infinite" in done.stderr
    assert "only 10 samples" in done.stderr
    assert "Traceback" not in done.output
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("below", [(), ("more", "results")], ids=["itself", "a folder in it"])
def test_results_into_a_file_are_refused_before_the_diagnosis(tmp_path: Path, below: tuple[str, ...]) -> None:
    file, dataset = tmp_path / "report.json", tmp_path / "dataset.toml"
    file.write_text("mine")
    dataset.write_text("schema = 2\n")
    done = CliRunner().invoke(app, [str(dataset), "--out", str(file.joinpath(*below))])
    assert done.exit_code == 2
    assert f"{file} is a file; give a folder" in done.stderr
    assert "schema" in done.stderr  # and what is wrong with the dataset
    assert file.read_text() == "mine"


def test_no_channel_alive_is_refused() -> None:
    measured = np.array([sensor.role == "measured" for sensor in CASE.sensors])
    dead = with_data(CASE, {r.name: np.where(measured, 0.0, r.data) for r in CASE.recordings})
    with pytest.raises(InputError, match="no measured sensor is left"):
        usable(dead)


def test_recordings_too_slow_for_force_laws_are_reported_as_such_and_not_as_a_motion_that_grows() -> None:
    slow = replace(CASE, sampling_rate=0.05)  # one sample in forty radians of the highest mode, and more
    setting = setting_of(slow)
    assert any("too few to follow force laws" in note for note in setting.notes)
    assert not any(isinstance(candidate, LawCandidate) for candidate in setting.candidates())
    assert setting_of(CASE).notes == ()
    assert is_too_fast(setting.nominal)
    passing = replace(setting.nominal, lowpass=LowPass(0.02))  # then it is stepped twice as often ...
    assert not is_too_fast(passing)
    assert is_too_fast(replace(passing, loaded=((1, "x"),)))  # ... but not under known loads, which have passed it
    with pytest.raises(InputError, match="sample more often"):
        setting_of(replace(slow, model=four_dof().with_effects(CubicSpring((1,), "x", 1.0))))


def test_copies_of_a_recording_count_once_where_recordings_are_left_out_in_turn() -> None:
    one, other = (replace(recording, role="train") for recording in CASE.recordings[:2])
    five = (one, *(replace(other, name=f"copy{number}") for number in range(4)))
    setting = setting_of(replace(CASE, recordings=five))
    assert [r.name for r in setting.dataset.recordings] == ["r01", "copy0"]
    assert setting.notes[0] == "3 of the recordings are copies of others and left out"


@pytest.mark.parametrize("search", [diagnose, diagnose_modes])
def test_a_rate_at_which_no_mode_shows_is_named(search: Callable[[Dataset], object]) -> None:
    """Such as a time step in the place of a rate; no cause would explain what is then seen."""
    with pytest.raises(InputError, match=r"no natural frequency lies below 0.01 Hz .*check sampling_rate"):
        search(replace(CASE, sampling_rate=0.02))


@pytest.mark.parametrize("stiffness", [1e10, 1e6])
def test_a_spring_that_is_rigid_to_the_recordings_is_named(stiffness: float) -> None:
    """1e10 N/m beside 1: the exponentials of its mode overflow, and a sound sensor's clock was called wrong."""
    chain = four_dof()
    link = chain.elements[1]
    assert isinstance(link, Spring)
    model = replace(chain, elements=(chain.elements[0], replace(link, stiffness=stiffness), *chain.elements[2:]))
    if stiffness < 1e8:  # 200 Hz at 10 Hz: no matter
        assert basis_of(replace(CASE, model=model), linearise(model), 1.0)[0].shape == (4, 4)
        return
    with pytest.raises(InputError, match=r"element 2 \(1e\+10 N/m\) .* it is rigid: give the nodes .* as one"):
        diagnose(replace(CASE, model=model))
