"""Predicted motions: from a record as the model forecasts it, from a state as the closed form says, and bad input."""

import csv
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

import hybrid
from fe_models.arrays import FloatArray
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import CubicSpring
from fe_models.errors import InputError
from fe_models.files.dataset_file import save_dataset
from fe_models.files.run_folder import Prediction, load_run, save_run_model
from hybrid.config import Config
from hybrid.estimation.experts import fe_counterpart
from hybrid.estimation.forecast import forecast_windows
from hybrid.estimation.uncertainty import banded_forecast
from hybrid.estimation.windows import driving_of
from hybrid.known_loads.modal_input import modal_input
from hybrid.notebook.trained import load_trained
from hybrid.training.checkpoint import load_checkpoint
from hybrid.training.results import write_results
from hybrid.training.run import CHECKPOINT, begin
from hybrid.training.scoring import nrmse
from scripts import render_shapes
from scripts.predict_motion import app
from tests.blank_sheets import blank_sheets
from tests.driven_problems import loaded_dataset
from tests.hybrid_problems import SENSORS, STEP, TINY, chain_dataset, chain_modes, channels, decay

NAMES = [sensor.name for sensor in SENSORS]
HEADER = "node,direction,displacement,velocity\n"
STATE = HEADER + "1,x,0.3,-1\n2,x,-0.2,0.5\n3,x,0.1,0\n4,x,0.4,0.25\n"
DISPLACEMENT, VELOCITY = np.array([0.3, -0.2, 0.1, 0.4]), np.array([-1, 0.5, 0, 0.25])
FLOAT32 = 2e-5  # of a motion near one: the model's numbers, over some 80 steps


@pytest.fixture(scope="module")
@blank_sheets()
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of one epoch on the chain, beside its dataset."""
    folder = tmp_path_factory.mktemp("trained")
    save_dataset(chain_dataset(), folder, "four_dof")
    training = begin(chain_dataset(), Config(TINY.model, replace(TINY.training, epochs=1)), folder / "run")
    list(training.epochs())
    write_results(training, chain_dataset())
    return folder / "run"


def predict(run: Path, out: Path, *arguments: str | Path) -> Result:
    return CliRunner().invoke(app, [str(run), "--out", str(out), *map(str, arguments)])


def predicted(run: Path, out: Path, *arguments: str | Path) -> Prediction:
    result = predict(run, out, *arguments)
    assert result.exit_code == 0, result.output
    assert str(out / "prediction.npz") in result.output
    prediction = load_run(out).prediction
    assert prediction is not None
    return prediction


def state_file(folder: Path, text: str = STATE) -> Path:
    path = folder / "state.csv"
    path.write_text(text)
    return path


def table_of(out: Path) -> tuple[list[str], FloatArray]:
    with (out / "channels.csv").open(newline="") as file:
        header, *rows = csv.reader(file)
    return header, np.array(rows, dtype=float)


@pytest.mark.slow
def test_from_a_record_it_is_what_the_model_forecasts_of_that_window(run: Path, tmp_path: Path) -> None:
    """Of the second recording, from sample 7 on; hybrid and FE start where the encoder says."""
    options = ("--dataset", run.parent / "dataset.toml", "--recording", "other", "--start", "3.5", "--duration", "39.5")
    prediction = predicted(run, tmp_path, *options)
    model = load_checkpoint(run / CHECKPOINT).model
    window = chain_dataset().recordings[1].data[:1, 7:87]
    header, table = table_of(tmp_path)
    assert header == ["time", *(f"{name} {what}" for what in ("hybrid", "FE", "std") for name in NAMES)]
    np.testing.assert_allclose(table[:, 0], STEP * np.arange(80), rtol=1e-12)
    np.testing.assert_array_equal(prediction.time, STEP * np.arange(80))
    for field, seen, dynamics in (
        (prediction.hybrid, table[:, 1:6], model),
        (prediction.fe, table[:, 6:11], fe_counterpart(model)),
    ):
        forecast = forecast_windows(model, window, dynamics)
        np.testing.assert_allclose(field, forecast.q[0] @ chain_modes().shapes.T, rtol=0, atol=FLOAT32)
        np.testing.assert_allclose(seen, forecast.channels[0], rtol=1e-8, atol=FLOAT32)  # nine digits are written
    np.testing.assert_allclose(table[:, 11:], banded_forecast(model, window).std[0], rtol=1e-8, atol=FLOAT32)
    assert np.abs(prediction.hybrid - prediction.fe).max() > 0.1  # the calibrated model is another than the nominal one


def test_whole_records_need_a_model_that_solves_for_its_states(run: Path, tmp_path: Path) -> None:
    result = CliRunner().invoke(
        app, [str(run), "--out", str(tmp_path), "--dataset", str(run.parent / "dataset.toml"), "--whole"]
    )
    assert result.exit_code == 2
    assert "--preset places" in result.output


@pytest.mark.slow
def test_under_known_loads_it_is_what_the_model_forecasts_and_only_as_long_as_they_are_known(tmp_path: Path) -> None:
    """From sample 20 on, in the command and in Python alike; the loads come from the dataset's files."""
    dataset = loaded_dataset(chain_modes(), 2)
    path = save_dataset(dataset, tmp_path, "four_dof")
    training = begin(dataset, Config(TINY.model, replace(TINY.training, epochs=1)), tmp_path / "run")
    list(training.epochs())
    write_results(training, dataset)
    options = ("--dataset", path, "--recording", "test", "--start", "10")
    prediction = predicted(tmp_path / "run", tmp_path / "out", *options, "--duration", "30")
    trained = load_trained(tmp_path / "run")
    (recording,) = dataset.select("test")
    field = hybrid.predict(trained, recording, start=10.0, duration=30.0)
    np.testing.assert_allclose(prediction.hybrid, field.displacement, rtol=0, atol=FLOAT32)
    driving = driving_of(modal_input(dataset, chain_modes(), [recording]), recording)
    assert driving is not None
    window = recording.data[:, 20:81]
    forecast = forecast_windows(trained.model, window, driving=driving.part(20, 81))
    np.testing.assert_allclose(field.channels, forecast.channels[0], rtol=0, atol=FLOAT32)
    assert nrmse(forecast.channels, window).mean() < 0.1
    refused = predict(tmp_path / "run", tmp_path / "out", *options, "--duration", "80")
    assert refused.exit_code == 2
    assert "known for 69.5 s more" in refused.output
    with pytest.raises(InputError, match=r"expected up to 69.5 s, over which the forces are known"):
        hybrid.predict(trained, recording, start=10.0, duration=80.0)


def test_a_record_is_read_only_as_far_as_the_encoder_sees(run: Path, tmp_path: Path) -> None:
    """A prediction may go beyond the record's end: 100 samples are recorded, and it starts ten before the last."""
    dataset = run.parent / "dataset.toml"
    prediction = predicted(run, tmp_path, "--dataset", dataset, "--start", "45", "--duration", "60")
    assert prediction.hybrid.shape == (121, 4)
    assert np.isfinite(prediction.hybrid).all()


def test_without_a_name_the_first_record_is_taken(run: Path, tmp_path: Path) -> None:
    options = ("--dataset", run.parent / "dataset.toml", "--duration", "10")
    unnamed = predicted(run, tmp_path / "a", *options)
    named = predicted(run, tmp_path / "b", *options, "--record", "one")
    np.testing.assert_array_equal(unnamed.hybrid, named.hybrid)


def test_from_a_state_the_fe_model_moves_as_the_closed_form_says(run: Path, tmp_path: Path) -> None:
    """By hand, q = Phi^T M u with M = diag(1, 2, 3, 4) kg, then the chain's decay from there."""
    prediction = predicted(run, tmp_path, "--initial", state_file(tmp_path), "--duration", "39.5")
    modal = chain_modes()
    projection = modal.shapes.T @ np.diag([1.0, 2, 3, 4])
    motion = decay(modal, (projection @ DISPLACEMENT)[None], (projection @ VELOCITY)[None], STEP, 80)
    np.testing.assert_allclose(prediction.fe, motion.q[0] @ modal.shapes.T, rtol=0, atol=FLOAT32)
    np.testing.assert_allclose(prediction.fe_initial, DISPLACEMENT, rtol=0, atol=1e-12)
    np.testing.assert_allclose(prediction.hybrid[0], DISPLACEMENT, rtol=0, atol=1e-6)  # the same start, in float32
    _, table = table_of(tmp_path)
    seen = channels(modal, motion, SENSORS)[0]
    np.testing.assert_allclose(table[:, 6:], seen, rtol=0, atol=FLOAT32 * np.abs(seen).max())
    np.testing.assert_allclose(table[:, 1], prediction.hybrid[:, 3], rtol=1e-6, atol=1e-7)  # x4


def test_the_duration_is_kept(run: Path, tmp_path: Path) -> None:
    prediction = predicted(run, tmp_path, "--initial", state_file(tmp_path), "--duration", "12.5")
    np.testing.assert_array_equal(prediction.time, STEP * np.arange(26))


@pytest.mark.slow
def test_render_shapes_takes_the_folder(run: Path, tmp_path: Path) -> None:
    predicted(run, tmp_path / "motion", "--initial", state_file(tmp_path), "--duration", "5")
    arguments = [str(tmp_path / "motion"), "--out", str(tmp_path / "pictures"), "--frames", "2", "--format", "gif"]
    result = CliRunner().invoke(render_shapes.app, [*arguments, "--snapshots", "2"])
    assert result.exit_code == 0, result.output
    drawn = {path.name for path in (tmp_path / "pictures").iterdir()}
    assert {"snapshots.png", "initial_deformation.png", "animation.gif", "modes.png"} <= drawn


def faults_of(run: Path, out: Path, *arguments: str | Path) -> list[str]:
    """The lines of a refusal, after which nothing has been written."""
    result = predict(run, out, *arguments)
    assert result.exit_code == 2, result.output
    assert not out.exists()
    lines = result.output.splitlines()
    assert all(line.startswith("error: ") for line in lines), lines
    return lines


@pytest.mark.parametrize("options", [(), ("--dataset", "dataset.toml", "--initial", "state.csv")])
def test_one_start_must_be_given(options: tuple[str, ...], run: Path, tmp_path: Path) -> None:
    (line,) = faults_of(run, tmp_path / "out", *options)
    assert "give either --dataset" in line


def test_a_folder_without_a_run_is_named(run: Path, tmp_path: Path) -> None:
    (line,) = faults_of(tmp_path / "nowhere", tmp_path / "out", "--initial", state_file(tmp_path))
    assert "nowhere" in line
    assert "no such file" in line


def test_all_that_is_wrong_with_a_record_comes_at_once(run: Path, tmp_path: Path) -> None:
    fewer = replace(chain_dataset(), sampling_rate=3.0)
    other = save_dataset(fewer, tmp_path / "data", "four_dof")
    late = faults_of(run, tmp_path / "out", "--dataset", other, "--start", "46")
    assert len(late) == 2
    assert "sensors or sampling rate are not those" in late[0]
    assert "--start 46: recording one ends after" in late[1]
    unknown = faults_of(run, tmp_path / "out", "--dataset", other, "--recording", "third")
    assert len(unknown) == 2
    assert "has one, other, unseen" in unknown[1]


def test_what_was_skipped_in_the_record_s_file_is_said(run: Path, tmp_path: Path) -> None:
    path = save_dataset(chain_dataset(), tmp_path / "data", "four_dof")
    first = chain_dataset().recordings[0].data[0]
    table = np.column_stack([first, np.full(len(first), 20.0)])
    header = ",".join([*NAMES, "temperature"])
    np.savetxt(tmp_path / "data" / "one.csv", table, delimiter=",", header=header, comments="")
    text = path.read_text().replace('file = "recording_1.npz", key = "data"', 'file = "one.csv"')
    own = path.with_name("own.toml")
    own.write_text(text)
    result = predict(run, tmp_path / "out", "--dataset", own, "--duration", "5")
    assert result.exit_code == 0, result.output
    assert "Note: one.csv: column 'temperature' belongs to no sensor and no load and is skipped.\n" in result.output


def test_a_start_too_late_for_the_encoder_is_refused(run: Path, tmp_path: Path) -> None:
    """100 samples hold ten from sample 90 at the latest, 45 s."""
    dataset = run.parent / "dataset.toml"
    (line,) = faults_of(run, tmp_path / "out", "--dataset", dataset, "--start", "45.5")
    assert "recording one ends after 50 s" in line


def test_a_missing_dataset_is_named(run: Path, tmp_path: Path) -> None:
    (line,) = faults_of(run, tmp_path / "out", "--dataset", tmp_path / "none.toml")
    assert "none.toml" in line


def test_a_state_that_cannot_be_read_has_one_line_a_fault(run: Path, tmp_path: Path) -> None:
    bad = state_file(tmp_path, HEADER + "7,x,0,0\n1,y,0,0\n2,x,zero,0\n3,x,0.1,0\n")
    lines = faults_of(run, tmp_path / "out", "--initial", bad)
    assert len(lines) == 3
    for line, words in zip(lines, ("line 2: node 7", "line 3: node 1", "line 4"), strict=True):
        assert words in line


@pytest.mark.parametrize("option", ["--start", "--duration"])
@pytest.mark.parametrize("value", ["-1", "nan", "inf"])
def test_times_must_be_times(option: str, value: str, run: Path, tmp_path: Path) -> None:
    result = predict(run, tmp_path / "out", "--dataset", run.parent / "dataset.toml", option, value)
    assert result.exit_code == 2, result.output
    assert option in result.output
    assert not (tmp_path / "out").exists()


def test_a_model_that_was_exchanged_for_another_is_noticed(run: Path, tmp_path: Path) -> None:
    shutil.copytree(run, tmp_path / "run")
    save_run_model(four_dof().with_effects(CubicSpring((1,), "x", 0.5)), chain_modes(), tmp_path / "run")
    result = predict(tmp_path / "run", tmp_path / "out", "--initial", state_file(tmp_path))
    assert result.exit_code == 2
    assert "one of them was exchanged" in result.output
    assert not (tmp_path / "out").exists()
