"""The training script in a tiny configuration: results, interruptions, presets and what it says about bad input."""

import json
import signal
import subprocess
import sys
import time
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from typer.testing import CliRunner, Result

from fe_models.files.atomic import MACHINE
from fe_models.files.dataset_file import save_dataset
from fe_models.files.result_list import LIST_FILE
from fe_models.files.run_folder import load_run
from hybrid.estimation.experts import fe_counterpart
from hybrid.estimation.forecast import forecast_windows
from hybrid.training.checkpoint import load_checkpoint
from hybrid.training.run import CHECKPOINT, PARTIAL_CHECKPOINT
from scripts.train_hybrid import app
from tests.blank_sheets import blank_sheets
from tests.hybrid_problems import chain_dataset, chain_modes

ROOT = Path(__file__).parent.parent
TINY = ("--window", "80", "--batch", "8", "--first-horizon", "20", "--threads", "1")
PATIENCE = 300.0  # s, for a process to start and to train one epoch on a busy machine


@pytest.fixture(scope="module")
def dataset(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return save_dataset(chain_dataset(), tmp_path_factory.mktemp("data"), "four_dof")


@pytest.fixture(scope="module")
@blank_sheets(".svg")
def whole(dataset: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of an uninterrupted training of many short epochs."""
    out = tmp_path_factory.mktemp("whole")
    assert train(dataset, "--out", out, *LONG).exit_code == 0
    return out


EPOCHS = 12
LONG = (*TINY, "--epochs", str(EPOCHS))


def train(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, [*map(str, arguments)])


def metrics_of(folder: Path) -> dict[str, Any]:
    metrics: dict[str, Any] = json.loads((folder / "metrics.json").read_text())
    return metrics


def interrupted(dataset: Path, out: Path, how: signal.Signals, *arguments: str) -> tuple[int, str]:
    """Start the script by itself, send it a signal once an epoch is on disk; return its exit status and output."""
    command = [sys.executable, "-W", "error", "scripts/train_hybrid.py", str(dataset), "--out", str(out), *arguments]
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # or a child of a background job ignores it
    try:
        process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    finally:
        signal.signal(signal.SIGINT, before)
    until = time.monotonic() + PATIENCE
    known = mtime(out / PARTIAL_CHECKPOINT)
    while mtime(out / PARTIAL_CHECKPOINT) == known and process.poll() is None and time.monotonic() < until:
        time.sleep(0.005)
    process.send_signal(how)
    output, _ = process.communicate(timeout=PATIENCE)
    return process.returncode, output


def mtime(path: Path) -> int:
    try:
        return path.stat().st_mtime_ns
    except FileNotFoundError:
        return 0


def test_after_kill_9_the_same_command_ends_with_the_same_scores(dataset: Path, whole: Path, tmp_path: Path) -> None:
    status, _ = interrupted(dataset, tmp_path, signal.SIGKILL, *LONG)
    assert status == -signal.SIGKILL
    assert not (tmp_path / "metrics.json").exists()
    done = len(load_checkpoint(tmp_path / PARTIAL_CHECKPOINT).history)
    assert 1 <= done < EPOCHS
    with blank_sheets():
        result = train(dataset, "--out", tmp_path, *LONG)
    assert result.exit_code == 0, result.output
    assert f"Going on with the training interrupted after epoch {done}" in result.output
    assert metrics_of(tmp_path)["scores"] == metrics_of(whole)["scores"]
    assert metrics_of(tmp_path)["training"]["epochs"] == EPOCHS
    assert not (tmp_path / PARTIAL_CHECKPOINT).exists()


@pytest.mark.slow
def test_killed_again_and_again_it_ends_with_the_same_weights(dataset: Path, whole: Path, tmp_path: Path) -> None:
    """Bit for bit, each time after at least one more epoch; what was half written goes with the run that follows."""
    done = [0]
    for how in (signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGKILL):
        interrupted(dataset, tmp_path, how, *LONG)
        done.append(len(load_checkpoint(tmp_path / PARTIAL_CHECKPOINT).history))
    assert all(before < after < EPOCHS for before, after in pairwise(done))
    (tmp_path / f".training-999999999-{MACHINE}abcd.pt").write_bytes(b"half")
    assert train(dataset, "--out", tmp_path, *LONG).exit_code == 0
    assert metrics_of(tmp_path)["scores"] == metrics_of(whole)["scores"]
    found, expected = (load_checkpoint(folder / CHECKPOINT).model.state_dict() for folder in (tmp_path, whole))
    assert found.keys() == expected.keys()
    assert all(torch.equal(found[name], expected[name]) for name in expected)
    assert [path.name for path in tmp_path.iterdir() if path.name.startswith(".")] == [LIST_FILE]


@pytest.mark.slow
def test_ctrl_c_ends_with_130_and_says_how_to_go_on(dataset: Path, whole: Path, tmp_path: Path) -> None:
    status, output = interrupted(dataset, tmp_path, signal.SIGINT, *LONG)
    assert status == 130, output
    assert "the same command goes on from there" in output
    assert "Traceback" not in output
    assert train(dataset, "--out", tmp_path, *LONG).exit_code == 0
    assert metrics_of(tmp_path)["scores"] == metrics_of(whole)["scores"]


@pytest.mark.slow
def test_killed_over_older_results_it_leaves_them_whole(dataset: Path, tmp_path: Path) -> None:
    """And --fresh throws away what was killed."""
    assert train(dataset, "--out", tmp_path, *TINY, "--epochs", "1").exit_code == 0
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    interrupted(dataset, tmp_path, signal.SIGKILL, *LONG, "--seed", "3")
    assert (tmp_path / PARTIAL_CHECKPOINT).exists()
    assert {name: (tmp_path / name).read_bytes() for name in before} == before
    refused = train(dataset, "--out", tmp_path, *TINY, "--epochs", "1")
    assert refused.exit_code == 2
    assert f"other settings: epochs was {EPOCHS}, now 1; seed was 3, now 0" in refused.output
    assert (tmp_path / CHECKPOINT).read_bytes() == before[CHECKPOINT]
    fresh = train(dataset, "--out", tmp_path, *TINY, "--epochs", "1", "--fresh")
    assert fresh.exit_code == 0, fresh.output
    assert "Going on" not in fresh.output
    assert not (tmp_path / PARTIAL_CHECKPOINT).exists()
    assert metrics_of(tmp_path)["scores"] == json.loads(before["metrics.json"])["scores"]


def test_results_fit_each_other(whole: Path) -> None:
    """Prediction and curves are of the checkpoint's model; what the chain's x4 reads is the field at node 4.

    1e-5 of a motion near three: float32, in which the sums of a batch of one and of six differ.
    """
    model = load_checkpoint(whole / CHECKPOINT).model
    window = chain_dataset().select("test")[0].data[:1, :80]
    prediction = load_run(whole).prediction
    assert prediction is not None
    for field, dynamics in ((prediction.hybrid, model), (prediction.fe, fe_counterpart(model))):
        forecast = forecast_windows(model, window, dynamics)
        np.testing.assert_allclose(field, forecast.q[0] @ chain_modes().shapes.T, rtol=0, atol=1e-5)
        np.testing.assert_allclose(field[:, 3], forecast.channels[0, :, 0], rtol=0, atol=1e-5)
    for name in ("channels", "latent", "displacement", "force_displacement", "training"):
        assert (whole / f"{name}.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.slow
def test_scores_are_reported_in_plain_words(dataset: Path, tmp_path: Path) -> None:
    result = train(dataset, "--out", tmp_path, *TINY, "--epochs", "1")
    assert result.exit_code == 0, result.output
    scores = metrics_of(tmp_path)["scores"]
    for words, role in (("measured channels", "measured"), ("channels never fitted", "held_out")):
        (line,) = [line for line in result.output.splitlines() if line.startswith(words)]
        numbers = [scores[model][role][score] for model in ("fe", "hybrid") for score in ("nrmse", "r2")]
        formats = ("9.4f", "9.3f", "9.4f", "9.3f")
        assert line.split()[-4:] == [
            format(number, form).strip() for number, form in zip(numbers, formats, strict=True)
        ]
    assert "0 is perfect" in result.output
    assert scores["hybrid"]["measured"]["nrmse"] < 0.3 * scores["fe"]["measured"]["nrmse"]


@pytest.mark.slow
@pytest.mark.parametrize("options", [("--preset", "paper"), ("--integrator", "dopri5"), ("--integrator", "rk4")])
def test_every_integrator_and_the_papers_preset_run(options: tuple[str, ...], dataset: Path, tmp_path: Path) -> None:
    small = ("--window", "40", "--epochs", "1", "--threads", "1", "--first-horizon", "12")
    result = train(dataset, "--out", tmp_path, *small, *options)
    assert result.exit_code == 0, result.output
    config = load_checkpoint(tmp_path / CHECKPOINT).config
    assert config.model.integrator == {"paper": "rk4"}.get(options[1], options[1])
    assert config.model.encoder == ("paper" if options[1] == "paper" else "window")
    assert config.training.window == 40
    assert metrics_of(tmp_path)["training"]["epochs"] == 1


def test_help_teaches() -> None:
    text = " ".join(train("--help").output.split())
    for words in (
        "--preset",
        "--device",
        "--fresh",
        "Examples:",
        "metrics.json",
        "goes on where it stood",
        "first samples",
    ):
        assert words in text, words


def test_bad_input_is_one_line_a_fault(dataset: Path) -> None:
    changes = {
        'name = "a1", node = 1': 'name = "a1", node = 17',
        'unit = "m/s",': 'unit = "cm/s",',
        "sampling_rate = 2.0": "sampling_rate = -2.0",
        "recording_2.npz": "missing.npz",
    }
    text = dataset.read_text()
    for right, wrong in changes.items():
        assert right in text
        text = text.replace(right, wrong)
    bad = dataset.with_name("bad.toml")
    bad.write_text(text)
    result = train(bad, "--out", bad, "--device", "gpu")
    lines = result.output.splitlines()
    assert result.exit_code == 2
    assert len(lines) == len(changes) + 2, lines
    assert sum(line.startswith("error: --out: ") and line.endswith("a folder for the results") for line in lines) == 1
    assert all(line.startswith("error: ") for line in lines)
    for words in ("node 17 does not exist", "unit 'cm/s'", "sampling_rate = -2", "missing.npz"):
        assert sum(words in line for line in lines) == 1, words


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--device", "cuda:97"), "--device cuda:97 cannot be used here"),
        (("--device", "abacus"), "--device abacus cannot be used here"),
        (("--encoder-samples", "50", "--window", "80"), "a window of 80 samples is too short: at least 200"),
        (("--encoder-samples", "30"), "recording 'one' has 100 samples: a window needs at least 120"),
        (("--epochs", "0"), "Invalid value for '--epochs'"),
    ],
)
def test_options_that_cannot_work_are_refused(
    options: tuple[str, str], words: str, dataset: Path, tmp_path: Path
) -> None:
    result = train(dataset, "--out", tmp_path / "out", *options)
    assert result.exit_code == 2
    assert words in " ".join(result.output.split())
    assert not (tmp_path / "out").exists()


def test_a_missing_dataset_is_named(tmp_path: Path) -> None:
    result = train(tmp_path / "none.toml", "--out", tmp_path / "out")
    assert result.exit_code == 2
    assert len(result.output.splitlines()) == 1
    assert "none.toml" in result.output


@pytest.mark.parametrize("epochs", ["1", "5"])
def test_a_divergence_is_one_line_with_the_remedy(epochs: str, dataset: Path, tmp_path: Path) -> None:
    """Also where only the very last step makes the model useless; no such model is written."""
    result = train(dataset, "--out", tmp_path, *TINY, "--batch", "1000", "--learning-rate", "1e6", "--epochs", epochs)
    assert result.exit_code == 1, result.output
    assert "diverged" in result.output
    assert "--learning-rate" in result.output
    assert not (tmp_path / CHECKPOINT).exists()
    assert not (tmp_path / "metrics.json").exists()
