"""Runs: resumed after any epoch they end bit for bit as if never interrupted, and older results stay whole."""

import json
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from fe_models.errors import InputError
from fe_models.files.result_list import LIST_FILE
from fe_models.recordings import Assumptions, Dataset, Recording
from hybrid.config import Config
from hybrid.estimation.experts import fe_counterpart
from hybrid.estimation.forecast import forecast_windows
from hybrid.training.checkpoint import Checkpoint, load_checkpoint
from hybrid.training.gradient_training import TrainingDivergedError
from hybrid.training.results import write_results
from hybrid.training.run import CHECKPOINT, PARTIAL_CHECKPOINT, begin, resume
from tests.blank_sheets import blank_sheets
from tests.driven_problems import loaded_dataset
from tests.hybrid_problems import (
    HELD_OUT,
    TINY,
    chain_dataset,
    chain_modes,
    learned,
    off_chain,
    same,
    with_column,
)

EPOCHS = TINY.training.epochs


@pytest.fixture(scope="module")
def dataset() -> Dataset:
    return chain_dataset()


@pytest.fixture(scope="module")
@blank_sheets()
def folders(dataset: Dataset, tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """What is left after each epoch of one uninterrupted training; the last is that of the finished run."""
    whole = tmp_path_factory.mktemp("whole")
    run = begin(dataset, TINY, whole)
    left = []
    for result in run.epochs():
        left.append(tmp_path_factory.mktemp(f"after_{result.epoch}"))
        shutil.copy(whole / PARTIAL_CHECKPOINT, left[-1] / PARTIAL_CHECKPOINT)
    write_results(run, dataset)
    return [*left, whole]


def copy_of(folder: Path, target: Path) -> Path:
    shutil.copytree(folder, target)
    return target


def assert_equal(one: Checkpoint, other: Checkpoint) -> None:
    """Weights, buffers, optimiser and history, bit for bit."""
    assert same(one.model.state_dict(), other.model.state_dict())
    assert one.history == other.history
    assert one.trainer["param_groups"] == other.trainer["param_groups"]
    first, second = one.trainer["state"], other.trainer["state"]
    assert first.keys() == second.keys()
    for number in first:
        assert same(first[number], second[number])


def metrics_of(folder: Path) -> dict[str, Any]:
    """What metrics.json says, but for the seconds."""
    metrics: dict[str, Any] = json.loads((folder / "metrics.json").read_text())
    return {**metrics, "training": {**metrics["training"], "seconds": None}}


@pytest.mark.parametrize("done", range(1, EPOCHS + 1))
@blank_sheets()
def test_resumed_after_any_epoch_it_ends_as_if_never_interrupted(
    done: int, folders: list[Path], dataset: Dataset, tmp_path: Path
) -> None:
    folder = copy_of(folders[done - 1], tmp_path / "run")
    run = resume(dataset, TINY, folder)
    assert [result.epoch for result in run.epochs()] == list(range(done + 1, EPOCHS + 1))
    write_results(run, dataset)
    assert_equal(load_checkpoint(folder / CHECKPOINT), load_checkpoint(folders[-1] / CHECKPOINT))
    assert metrics_of(folder) == metrics_of(folders[-1])


def test_each_epoch_is_on_disk_before_the_next_begins(folders: list[Path]) -> None:
    for epoch, folder in enumerate(folders[:-1], start=1):
        assert [result.epoch for result in load_checkpoint(folder / PARTIAL_CHECKPOINT).history] == list(
            range(1, epoch + 1)
        )


def test_a_finished_run_has_its_checkpoint_and_no_training_under_way(folders: list[Path]) -> None:
    names = {path.name for path in folders[-1].iterdir()}
    assert {CHECKPOINT, "metrics.json", "prediction.npz", "model.npz"} <= names
    assert PARTIAL_CHECKPOINT not in names
    assert [name for name in names if name.startswith(".")] == [LIST_FILE]  # no temporary files


@pytest.mark.slow
@blank_sheets()
def test_older_results_stay_while_a_new_training_is_under_way(
    folders: list[Path], dataset: Dataset, tmp_path: Path
) -> None:
    folder = copy_of(folders[-1], tmp_path / "run")
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    run = begin(dataset, replace(TINY, training=replace(TINY.training, seed=5)), folder)
    for _ in run.epochs():
        assert {name: (folder / name).read_bytes() for name in before} == before
    write_results(run, dataset)
    assert (folder / CHECKPOINT).read_bytes() != before[CHECKPOINT]


def test_files_that_no_training_wrote_are_refused_before_it_begins(
    folders: list[Path], dataset: Dataset, tmp_path: Path
) -> None:
    """Also before one is gone on with, and where a file of the user has the name of a training's state."""
    for folder, start in ((tmp_path / "new", begin), (copy_of(folders[0], tmp_path / "old"), resume)):
        folder.mkdir(exist_ok=True)
        (folder / "metrics.json").write_text("mine")
        with pytest.raises(InputError, match=r"metrics\.json would be replaced"):
            start(dataset, TINY, folder)
        assert (folder / "metrics.json").read_text() == "mine"
    torch.save({"weights": torch.ones(3)}, tmp_path / PARTIAL_CHECKPOINT)
    with pytest.raises(InputError, match="was not written by this program"):
        begin(dataset, TINY, tmp_path)
    begin(dataset, TINY, copy_of(folders[0], tmp_path / "fresh"))  # its state is a training's own


def test_a_divergence_keeps_the_last_sound_epoch(dataset: Dataset, tmp_path: Path) -> None:
    run = begin(dataset, TINY, tmp_path)
    epochs = run.epochs()
    next(epochs)
    weights = learned(run.trainer.model)
    run.trainer.windows[:] = float("inf")
    with pytest.raises(TrainingDivergedError):
        next(epochs)
    kept = load_checkpoint(tmp_path / PARTIAL_CHECKPOINT)
    assert same(learned(kept.model), weights)
    assert all(bool(torch.isfinite(value).all()) for value in weights.values())
    assert not (tmp_path / CHECKPOINT).exists()


def refusal(dataset: Dataset, config: Config, folder: Path) -> str:
    with pytest.raises(InputError) as caught:
        resume(dataset, config, folder)
    assert "--fresh" in caught.value.faults[-1]
    return "\n".join(caught.value.faults[:-1])


def test_other_settings_are_not_mixed_in(folders: list[Path], dataset: Dataset) -> None:
    """Each difference is named with both its values."""
    model, training = replace(TINY.model, net_hidden=9), replace(TINY.training, learning_rate=0.5, batch=3)
    words = refusal(dataset, Config(model, training), folders[0])
    assert "net_hidden was 8, now 9; batch was 8, now 3; learning_rate was 0.001, now 0.5" in words


def test_other_data_are_not_mixed_in(folders: list[Path], dataset: Dataset) -> None:
    assert "other recordings" in refusal(with_column(dataset, "train", 0, 2.0), TINY, folders[0])
    fewer = replace(dataset, recordings=dataset.recordings[1:])
    assert "other recordings" in refusal(fewer, TINY, folders[0])
    more = replace(dataset, recordings=(*dataset.recordings, Recording("late", dataset.recordings[1].data)))
    assert "other recordings" in refusal(more, TINY, folders[0])


def test_other_sensors_or_models_are_not_mixed_in(folders: list[Path], dataset: Dataset) -> None:
    """Above all, a channel that was fitted must not be scored as held out."""
    swapped = tuple(
        replace(sensor, role="measured" if i == HELD_OUT else "held_out" if i == 0 else sensor.role)
        for i, sensor in enumerate(dataset.sensors)
    )
    ratio = Assumptions(modal_model=chain_modes(0.05))
    for changed in (
        replace(dataset, sensors=swapped),
        replace(dataset, sampling_rate=3.0),
        replace(dataset, assumptions=ratio),
    ):
        assert "another model, other sensors" in refusal(changed, TINY, folders[0])


def test_test_recordings_may_change_between_interruption_and_resumption(folders: list[Path], dataset: Dataset) -> None:
    """They are scored only, so that they take no part in the training."""
    others = (*dataset.select("train"), replace(dataset.recordings[-1], data=dataset.recordings[-1].data[:1]))
    assert len(resume(replace(dataset, recordings=others), TINY, folders[0]).history) == 1


def test_nothing_is_begun_without_training_recordings(dataset: Dataset, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no training recording or no measured sensor"):
        begin(replace(dataset, recordings=dataset.select("test")), TINY, tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_training_under_loads_resumes_as_if_never_interrupted_and_not_under_others(tmp_path: Path) -> None:
    dataset = loaded_dataset(off_chain(), 2)
    for folder in ("whole", "parts"):
        run = begin(dataset, TINY, tmp_path / folder)
        for result in run.epochs():
            if folder == "parts" and result.epoch == 2:
                break
    louder = tuple(
        replace(each, loads=(replace(each.loads[0], values=2 * each.loads[0].values), each.loads[1]))
        for each in dataset.recordings
    )
    assert "other recordings" in refusal(replace(dataset, recordings=louder), TINY, tmp_path / "parts")
    again = resume(dataset, TINY, tmp_path / "parts")
    assert [result.epoch for result in again.epochs()] == [3, 4]
    whole = resume(dataset, TINY, tmp_path / "whole")
    assert same(learned(again.trainer.model), learned(whole.trainer.model))


def test_scores_in_the_metrics_are_those_of_the_checkpoint(folders: list[Path], dataset: Dataset) -> None:
    """Recomputed by hand from what the loaded model forecasts."""
    metrics = metrics_of(folders[-1])
    model = load_checkpoint(folders[-1] / CHECKPOINT).model
    data = dataset.recordings[-1].data
    windows = np.concatenate([data[r : r + 1, start : start + 80] for r in range(3) for start in (0, 20)])
    for name, dynamics in (("hybrid", model), ("fe", fe_counterpart(model))):
        forecast = forecast_windows(model, windows, dynamics).channels
        rmse = np.sqrt(((forecast - windows) ** 2).mean(axis=1))
        errors = rmse / (windows.max(axis=1) - windows.min(axis=1))  # (window, sensor)
        assert metrics["scores"][name]["held_out"]["nrmse"] == pytest.approx(errors[:, HELD_OUT].mean(), rel=1e-12)
        others = np.delete(errors, HELD_OUT, axis=1)
        assert metrics["scores"][name]["measured"]["nrmse"] == pytest.approx(others.mean(), rel=1e-12)
    assert metrics["test"] == {
        "recordings": ["unseen"],
        "windows": 6,
        "overlapping": True,
        "window_samples": 80,
        "encoder_samples": 10,
    }
    assert metrics["training"]["recordings"] == ["one", "other"]
