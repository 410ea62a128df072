"""The demo and the bridge's score table, in a tiny configuration."""

import json
from pathlib import Path

import imageio.v3
import numpy as np
import pytest
from scipy.io import savemat
from typer.testing import CliRunner, Result

from fe_models.assembly import linearise
from fe_models.built_in.bridge import bridge
from fe_models.files.bridge_recordings import bridge_sensors
from fe_models.files.dataset_file import load_dataset, save_dataset
from fe_models.modes import natural_modes
from hybrid.config import Config, TrainingConfig
from hybrid.neural_modal_ode.decoder import sensor_shapes
from scripts.demo import app
from scripts.score_bridge import app as scores
from tests.hybrid_problems import chain_dataset

SAMPLES = 140  # of each stand-in for the authors' recordings: five windows fit into half a second of training


@pytest.fixture(autouse=True)
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Windows of 200 samples, eleven in a release of four seconds, and a film of three frames."""
    monkeypatch.setattr("scripts.demo.FRAMES", 3)
    window = TrainingConfig(window=200)
    monkeypatch.setattr("scripts.demo.Config", lambda training=window: Config(training=training))


def demo(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, [*map(str, arguments)])


@pytest.fixture(scope="module")
def authors_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Four recordings like the authors', of free vibration in the FE model's own modes."""
    folder, rng = tmp_path_factory.mktemp("authors"), np.random.default_rng(0)
    modal = natural_modes(linearise(bridge()), 6)
    shapes, time = sensor_shapes(modal, bridge_sensors()), np.arange(SAMPLES) * 0.01
    for number in range(1, 5):
        size, phase = rng.uniform(0.5, 1, 6), rng.uniform(0, 6, 6)
        q_ddot = size * np.exp(-0.01 * modal.omega * time[:, None]) * np.cos(modal.omega * time[:, None] + phase)
        data = q_ddot @ shapes.T
        data += 0.01 * data.std() * rng.standard_normal(data.shape)
        savemat(folder / f"acc_measured{number}.mat", {"acc_measured": data, "dt": 0.01})
    return folder


def assert_pictures(folder: Path, *names: str) -> None:
    """All are there, and show something: not one colour, nor a speck on it."""
    for name in names:
        image = imageio.v3.imread(folder / name)[..., :3]
        assert np.mean(image.min(axis=2) < 250) > 0.005, name


def test_the_demo_from_end_to_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Four seconds a release and one epoch: the calibrated model alone beats the FE model on the unseen release.

    Edges of the pictures are not smoothed, which takes longer than painting them.
    """
    monkeypatch.setattr("pyvista.Plotter.enable_anti_aliasing", lambda plotter, kind: None)
    result = demo("--out", tmp_path, "--epochs", "1", "--duration", "4")
    assert result.exit_code == 0, result.output
    run = tmp_path / "hybrid"
    metrics = json.loads((run / "metrics.json").read_text())
    assert metrics["test"]["recordings"] == ["release_4"]
    assert metrics["training"]["epochs"] == 1
    for role in ("measured", "held_out"):
        assert metrics["scores"]["hybrid"][role]["nrmse"] < 0.5 * metrics["scores"]["fe"][role]["nrmse"]
    assert metrics["field"]["hybrid"] < metrics["field"]["fe"]
    assert [recording.data.shape for recording in load_dataset(tmp_path / "data" / "dataset.toml").recordings] == [
        (1, 401, 8)
    ] * 4
    assert_pictures(tmp_path / "pictures", "modes.png", "mode_10.png", "snapshots.png", "initial_deformation.png")
    assert_pictures(run, "channels.png", "latent.png", "displacement.png", "training.png")
    assert list((tmp_path / "pictures").glob("animation.*"))
    assert "NRMSE is the root mean square error" in result.output
    assert str(tmp_path / "pictures" / "snapshots.png") in result.output


@pytest.mark.slow
def test_the_demo_on_recordings_of_ones_own(tmp_path: Path) -> None:
    save_dataset(chain_dataset(), tmp_path / "mine", "four_dof")
    result = demo("--out", tmp_path / "out", "--epochs", "1", "--data", tmp_path / "mine")
    assert result.exit_code == 0, result.output
    assert_pictures(tmp_path / "out" / "pictures", "modes.png", "snapshots.png", "initial_deformation.png")
    metrics = json.loads((tmp_path / "out" / "hybrid" / "metrics.json").read_text())
    assert metrics["test"]["recordings"] == ["unseen"]
    assert "field" not in metrics  # nobody knows the truth
    assert not (tmp_path / "out" / "data").exists()


def test_the_demo_names_what_a_folder_lacks(tmp_path: Path) -> None:
    result = demo("--out", tmp_path / "out", "--data", tmp_path / "nowhere")
    assert result.exit_code == 2
    (line,) = result.stderr.splitlines()
    assert line.startswith("error: ")
    assert "nowhere: no such folder" in line
    (tmp_path / "nowhere").mkdir()
    (tmp_path / "nowhere" / "acc_measured3.mat").touch()
    result = demo("--out", tmp_path / "out", "--data", tmp_path / "nowhere")
    assert result.exit_code == 2
    for number, line in zip((1, 2, 4), result.stderr.splitlines(), strict=True):
        assert line.startswith("error: ")
        assert f"acc_measured{number}.mat: no such file" in line
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("options", [("--duration", "inf"), ("--duration", "0"), ("--epochs", "0"), ("--test", "5")])
def test_the_demo_refuses_what_cannot_be_done(options: tuple[str, str], tmp_path: Path) -> None:
    result = demo("--out", tmp_path / "out", *options)
    assert result.exit_code == 2
    assert options[0] in result.output
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_the_score_table_has_a_row_for_each_test_recording_and_model(authors_folder: Path, tmp_path: Path) -> None:
    result = CliRunner().invoke(scores, [str(authors_folder), "--out", str(tmp_path), "--epochs", "1"])
    assert result.exit_code == 0, result.output
    table = [line.split(" | ") for line in result.output.splitlines() if line.startswith("| r")]
    assert [row[0] for row in table] == [f"| r{number}" for number in range(1, 5) for _ in range(5)]
    found = json.loads((tmp_path / "scores.json").read_text())
    assert f"{found['r3']['scores']['fe']['held_out']['nrmse']:.3f}" == table[10][6]
    assert f"{found['r3']['peers']['realisation']['measured']['nrmse']:.3f}" == table[11][4]
    assert [row[2] for row in table[:5]] == [
        "FE model",
        "eigensystem realisation",
        "modal expansion, 4 modes",
        "modal expansion, 10 modes",
        "hybrid",
    ]
    assert "| in the 90 % band | A2 in the 90 % band | seconds |" in result.output
    assert table[14][7:] == [
        f"{100 * found['r3']['bands']['hybrid']['measured']:.1f} %",
        f"{100 * found['r3']['bands']['hybrid']['held_out']:.1f} %",
        f"{found['r3']['training']['seconds']:.0f} |",
    ]
    for number in range(1, 5):
        metrics = json.loads((tmp_path / f"test_{number}" / "metrics.json").read_text())
        peers = found[f"r{number}"].pop("peers")
        assert metrics == found[f"r{number}"]
        assert peers["realisation"]["held_out"]["r2"] <= 1.0
        assert peers["expansion_4"]["measured"] is None
        assert set(metrics["test"]["expert_weights"]) == set(metrics["training"]["recordings"])
        assert metrics["test"]["recordings"] == [f"r{number}"]
        assert metrics["training"]["recordings"] == [f"r{other}" for other in range(1, 5) if other != number]
        assert metrics["scores"]["fe"]["channels"]["A2"]["role"] == "held_out"


def test_the_score_table_names_what_a_folder_lacks(tmp_path: Path) -> None:
    result = CliRunner().invoke(scores, [str(tmp_path / "nowhere"), "--out", str(tmp_path / "out")])
    assert result.exit_code == 2
    assert len(result.stderr.splitlines()) == 4
    assert all(line.startswith("error: ") and "no such file" in line for line in result.stderr.splitlines())
    assert not (tmp_path / "out").exists()
