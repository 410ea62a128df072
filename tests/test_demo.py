"""The demo and the bridge's score table, in a tiny configuration."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat
from typer.testing import CliRunner, Result

from fe_models.assembly import linearise
from fe_models.bridge import bridge
from fe_models.files.bridge_recordings import bridge_sensors
from fe_models.files.dataset_file import save_dataset
from fe_models.modes import natural_modes
from hybrid.decoder import sensor_shapes
from scripts.demo import app
from scripts.score_bridge import app as scores
from tests.hybrid_problems import chain_dataset


def demo(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, [*map(str, arguments)])


@pytest.fixture(scope="module")
def authors_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Four recordings like the authors', of free vibration in the FE model's own modes."""
    folder, rng = tmp_path_factory.mktemp("authors"), np.random.default_rng(0)
    modal = natural_modes(linearise(bridge()), 6)
    shapes, time = sensor_shapes(modal, bridge_sensors()), np.arange(560) * 0.01
    for number in range(1, 5):
        size, phase = rng.uniform(0.5, 1, 6), rng.uniform(0, 6, 6)
        q_ddot = size * np.exp(-0.01 * modal.omega * time[:, None]) * np.cos(modal.omega * time[:, None] + phase)
        data = q_ddot @ shapes.T
        data += 0.01 * data.std() * rng.standard_normal(data.shape)
        savemat(folder / f"acc_measured{number}.mat", {"acc_measured": data, "dt": 0.01})
    return folder


def test_the_demo_from_end_to_end(tmp_path: Path) -> None:
    """Six seconds a release and one epoch: the calibrated model alone beats the FE model on the unseen release."""
    result = demo("--out", tmp_path, "--epochs", "1", "--duration", "6")
    assert result.exit_code == 0, result.output
    metrics = json.loads((tmp_path / "hybrid" / "metrics.json").read_text())
    for role in ("measured", "held_out"):
        assert metrics["scores"]["hybrid"][role]["nrmse"] < 0.5 * metrics["scores"]["fe"][role]["nrmse"]
    assert metrics["field"]["hybrid"] < metrics["field"]["fe"]
    pictures = {path.name for path in (tmp_path / "pictures").iterdir()}
    assert {"modes.png", "snapshots.png", "initial_deformation.png"} < pictures
    assert "NRMSE is the root mean square error" in result.output


def test_the_demo_on_recordings_of_ones_own(tmp_path: Path) -> None:
    save_dataset(chain_dataset(), tmp_path / "mine", "four_dof")
    result = demo("--out", tmp_path / "out", "--epochs", "1", "--data", tmp_path / "mine")
    assert result.exit_code == 0, result.output
    assert (tmp_path / "out" / "pictures" / "snapshots.png").exists()


def test_the_demo_names_what_a_folder_lacks(tmp_path: Path) -> None:
    result = demo("--out", tmp_path / "out", "--data", tmp_path / "nowhere")
    assert result.exit_code == 2
    assert [f"acc_measured{n}.mat" in line for n, line in zip(range(1, 5), result.stderr.splitlines(), strict=True)]


def test_the_score_table_has_a_row_for_each_test_recording(authors_folder: Path, tmp_path: Path) -> None:
    result = CliRunner().invoke(scores, [str(authors_folder), "--out", str(tmp_path), "--epochs", "1"])
    assert result.exit_code == 0, result.output
    rows = [line for line in result.output.splitlines() if line.startswith("| r")]
    assert [row.split("|")[1].strip() for row in rows] == ["r1", "r2", "r3", "r4"]
    found = json.loads((tmp_path / "scores.json").read_text())
    assert f"{found['r3']['scores']['fe']['held_out']['nrmse']:.3f}" in rows[2]
    assert found["r2"]["training"]["recordings"] == ["r1", "r3", "r4"]
