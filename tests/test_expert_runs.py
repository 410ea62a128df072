"""Experts from training to prediction: each trains as if alone, resumes bit for bit, is saved, loaded and described."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from typer.testing import CliRunner

from fe_models.files.dataset_file import save_dataset
from fe_models.files.run_folder import load_run
from fe_models.recordings import Dataset
from hybrid.config import Config
from hybrid.estimation.experts import Experts
from hybrid.estimation.forecast import forecast_windows
from hybrid.training.checkpoint import load_checkpoint
from hybrid.training.results import write_results
from hybrid.training.run import CHECKPOINT, PARTIAL_CHECKPOINT, begin, resume
from scripts import predict_motion, train_hybrid
from tests.blank_sheets import blank_sheets
from tests.hybrid_problems import TINY, learned, same, trained
from tests.test_experts import EXPERTS, two_days

EPOCHS = 2
CONFIG = Config(replace(EXPERTS.model, residual="backbone"), replace(EXPERTS.training, epochs=EPOCHS))


@pytest.fixture(scope="module")
def dataset() -> Dataset:
    return two_days()


@pytest.fixture(scope="module")
@blank_sheets()
def folders(dataset: Dataset, tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """What is left after the first epoch of a training, and at its end."""
    whole, first = tmp_path_factory.mktemp("whole"), tmp_path_factory.mktemp("first")
    run = begin(dataset, CONFIG, whole)
    for result in run.epochs():
        if result.epoch == 1:
            shutil.copy(whole / PARTIAL_CHECKPOINT, first / PARTIAL_CHECKPOINT)
    write_results(run, dataset)
    return [first, whole]


def experts_in(folder: Path) -> Experts:
    model = load_checkpoint(folder / CHECKPOINT).model
    assert isinstance(model, Experts)
    return model


@pytest.mark.slow
def test_each_member_trains_as_if_its_recording_were_the_only_one(folders: list[Path], dataset: Dataset) -> None:
    """Bit for bit, so that no window of another recording can have taken part."""
    for name, member in zip(("one", "other"), experts_in(folders[1]).members, strict=True):
        only = tuple(recording for recording in dataset.recordings if recording.name == name)
        alone = trained(
            replace(dataset, recordings=only),
            replace(CONFIG, training=replace(CONFIG.training, window=80)),
        )
        assert same(learned(member), learned(alone.model))


@pytest.mark.slow
def test_resumed_it_ends_as_if_never_interrupted(folders: list[Path], dataset: Dataset, tmp_path: Path) -> None:
    folder = tmp_path / "run"
    shutil.copytree(folders[0], folder)
    run = resume(dataset, CONFIG, folder)
    assert [result.epoch for result in run.epochs()] == [2]
    write_results(run, dataset)
    one, other = load_checkpoint(folder / CHECKPOINT), load_checkpoint(folders[1] / CHECKPOINT)
    assert same(one.model.state_dict(), other.model.state_dict())
    assert one.history == other.history


def test_the_loss_is_the_mean_over_all_windows(dataset: Dataset, tmp_path: Path) -> None:
    """40 windows of one recording count four times the 10 of a shorter one."""
    run = begin(dataset, CONFIG, tmp_path)
    trainer = run.trainer
    windows = [len(part.windows) for part in trainer.trainers]  # type: ignore[union-attr]
    alone = begin(dataset, CONFIG, tmp_path).trainer
    losses = [part.train_epoch(1).loss for part in alone.trainers]  # type: ignore[union-attr]
    assert trainer.train_epoch(1).loss == pytest.approx(np.average(losses, weights=windows), rel=1e-12)


def test_a_loaded_model_forecasts_the_same_bits(folders: list[Path], dataset: Dataset, tmp_path: Path) -> None:
    run = resume(dataset, CONFIG, folders[0])
    shutil.copy(folders[0] / PARTIAL_CHECKPOINT, tmp_path / CHECKPOINT)
    windows = np.concatenate([recording.data for recording in dataset.select("test")])
    before, after = (forecast_windows(model, windows) for model in (run.trainer.model, experts_in(tmp_path)))
    np.testing.assert_array_equal(after.channels, before.channels)


def test_the_metrics_tell_which_recordings_the_test_resembles(folders: list[Path]) -> None:
    metrics = json.loads((folders[1] / "metrics.json").read_text())
    shares = metrics["test"]["expert_weights"]
    assert list(shares) == ["one", "other"]
    assert sum(shares.values()) == pytest.approx(1.0, abs=1e-6)
    assert 0.3 < shares["one"] < 0.7  # half of the test windows are like each
    for role in ("measured", "held_out"):
        assert metrics["scores"]["hybrid"][role]["nrmse"] < 0.3 * metrics["scores"]["fe"][role]["nrmse"]


def test_predict_motion_takes_a_run_of_experts(folders: list[Path], dataset: Dataset, tmp_path: Path) -> None:
    path = save_dataset(dataset, tmp_path / "data", "four_dof")
    arguments = [str(folders[1]), "--out", str(tmp_path / "out"), "--dataset", str(path)]
    result = CliRunner().invoke(predict_motion.app, [*arguments, "--recording", "like other", "--duration", "39.5"])
    assert result.exit_code == 0, result.output
    prediction = load_run(tmp_path / "out").prediction
    assert prediction is not None
    q = forecast_windows(experts_in(folders[1]), dataset.recordings[3].data[:1]).q[0]
    shapes = load_checkpoint(folders[1] / CHECKPOINT).origin.modal.shapes
    np.testing.assert_allclose(prediction.hybrid, q @ shapes.T, rtol=0, atol=2e-5)  # float32 over 80 steps
    (tmp_path / "state.csv").write_text("node,direction,displacement,velocity\n4,x,0.4,0.25\n")
    state = ["--initial", str(tmp_path / "state.csv")]
    result = CliRunner().invoke(predict_motion.app, [str(folders[1]), "--out", str(tmp_path / "state"), *state])
    assert result.exit_code == 0, result.output


@pytest.mark.slow
def test_the_command_line_has_experts(dataset: Dataset, tmp_path: Path) -> None:
    path = save_dataset(dataset, tmp_path / "data", "four_dof")
    arguments = [str(path), "--out", str(tmp_path / "run"), "--preset", "experts", "--epochs", "1", "--window", "80"]
    result = CliRunner().invoke(train_hybrid.app, arguments)
    assert result.exit_code == 0, result.output
    assert "one model each of one (weight " in result.output
    assert len(experts_in(tmp_path / "run").members) == 2


def test_without_the_preset_there_is_one_model(dataset: Dataset, tmp_path: Path) -> None:
    run = begin(dataset, TINY, tmp_path)
    assert not isinstance(run.trainer.model, Experts)
    assert torch.is_tensor(run.trainer.model.channel_scale)
