"""A training as seen at a terminal: what is said at its start, when it goes on, and when it stops."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tqdm import tqdm

from fe_models.recordings import Dataset, Recording
from hybrid.training import session
from hybrid.training.gradient_training import EpochResult, TrainingDivergedError
from hybrid.training.run import PARTIAL_CHECKPOINT, Run
from hybrid.training.session import divergence_exits, open_run, train
from tests.hybrid_problems import TINY, chain_dataset, chain_modes, recorded


@pytest.fixture(scope="module")
def dataset() -> Dataset:
    return chain_dataset()


def test_a_training_is_begun_then_gone_on_with_then_thrown_away(
    dataset: Dataset, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = open_run(dataset, TINY, tmp_path, "cpu")
    next(run.epochs())
    assert "Going on" not in capsys.readouterr().out
    again = open_run(dataset, TINY, tmp_path, "cpu")
    assert "Going on with the training interrupted after epoch 1 (--fresh starts anew)." in capsys.readouterr().out
    assert len(again.history) == 1
    fresh = open_run(dataset, TINY, tmp_path, "cpu", fresh=True)
    assert "Going on" not in capsys.readouterr().out
    assert fresh.history == ()


def test_a_recording_of_another_structure_is_named(
    dataset: Dataset, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """All frequencies 30 % off: no linear model explains both."""
    other = replace(chain_modes(), omega=1.3 * chain_modes().omega)
    more = (*dataset.recordings, Recording("changed", recorded(other, 6, 100, seed=9)))
    run = open_run(replace(dataset, recordings=more), TINY, tmp_path, "cpu")
    assert run.origin.left_out == ("changed",)
    lines = [line for line in capsys.readouterr().out.splitlines() if "changed" in line]
    assert lines == ["Recording changed contradicts the other training recordings: it is left out."]


def test_the_bar_of_the_calibration_ends_full(
    dataset: Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With two recordings, which are not compared, and with three, which are."""
    bars = []

    def counting(what: str, total: int, unit: str) -> Any:
        bars.append(tqdm(desc=what, total=total, unit=unit))
        return bars[-1]

    monkeypatch.setattr(session, "progress_bar", counting)
    third = Recording("third", recorded(chain_modes(), 3, 100, seed=8))
    for recordings in (dataset.recordings, (*dataset.recordings, third)):
        open_run(replace(dataset, recordings=recordings), TINY, tmp_path, "cpu")
    assert [bar.total for bar in bars] == [4, 16]
    assert [bar.n for bar in bars] == [4, 16]


def test_training_goes_to_the_end(dataset: Dataset, tmp_path: Path) -> None:
    run = open_run(dataset, TINY, tmp_path, "cpu")
    train(run)
    assert [result.epoch for result in run.history] == [1, 2, 3, 4]
    assert (tmp_path / PARTIAL_CHECKPOINT).exists()  # until the results are written


@pytest.mark.parametrize(
    ("error", "status", "words"),
    [
        (KeyboardInterrupt(), 130, "Interrupted after epoch 1; the same command goes on from there."),
        (TrainingDivergedError("too fast"), 1, "error: too fast"),
    ],
)
def test_what_stops_a_training_ends_the_program_with_one_line(
    error: BaseException,
    status: int,
    words: str,
    dataset: Dataset,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def stopping(run: Run) -> Iterator[EpochResult]:
        run.history += (EpochResult(1, 1.0, 20),)
        yield run.history[0]
        raise error

    monkeypatch.setattr(Run, "epochs", stopping)
    run = open_run(dataset, TINY, tmp_path, "cpu")
    capsys.readouterr()
    with pytest.raises(SystemExit) as caught:
        train(run)
    assert caught.value.code == status
    err = capsys.readouterr().err
    assert words in err.splitlines()
    assert "Traceback" not in err


def test_no_other_error_is_swallowed() -> None:
    with pytest.raises(ZeroDivisionError), divergence_exits():
        np.float64(1 // 0)
