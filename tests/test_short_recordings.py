"""Training on recordings shorter than the paper's windows: two carts, seen for a few periods of their slower mode."""

from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import eigh
from typer.testing import CliRunner

from fe_models.arrays import FloatArray
from fe_models.files.dataset_file import save_dataset
from fe_models.recordings import Dataset, Recording, Sensor
from fe_models.structure import Damping, PointMass, Spring, Structure
from scripts.train_hybrid import app

RATE = 30.0  # Hz
RATIOS = (0.003, 0.0015)
CARTS = Structure(
    name="two carts",
    nodes=((0.0, 0.0), (1.0, 0.0)),
    directions=("x",),
    elements=(Spring((1,), "x", 3.12), Spring((1, 2), "x", 31.0), Spring((2,), "x", 3.12)),
    point_masses=(PointMass(1, 0.4), PointMass(2, 1.0)),
    damping=Damping(modal_ratios=RATIOS),
)
SENSORS = tuple(Sensor(f"x{node}", node, "x", "displacement", "m") for node in (1, 2))


def motion(samples: int, seed: int) -> FloatArray:
    """Free decay (time, sensor) in the closed form of each mode, with noise of 0.5 %."""
    rng = np.random.default_rng(seed)
    squares, shapes = eigh([[34.12, -31.0], [-31.0, 34.12]], np.diag([0.4, 1.0]))
    time, omega = np.arange(samples)[:, None] / RATE, np.sqrt(squares)
    modes = np.exp(-np.array(RATIOS) * omega * time) * np.cos(omega * time + rng.uniform(0, 2 * np.pi, 2))
    clean = modes * (0.065, 0.007) @ shapes.T
    return np.asarray(clean + 0.005 * clean.std() * rng.standard_normal(clean.shape))


@pytest.mark.slow
@pytest.mark.parametrize("samples", [250, 450])
def test_a_short_recording_is_learned_from(samples: int, tmp_path: Path) -> None:
    """The model is exact: what is learned is the initial state, which one window cannot teach."""
    recordings = (Recording("a", motion(samples, 0)[None]), Recording("t", motion(samples, 1)[None], "test"))
    file = save_dataset(Dataset(CARTS, RATE, SENSORS, recordings), tmp_path)
    answer = CliRunner().invoke(app, [str(file), "--out", str(tmp_path / "out"), "--epochs", "2"])
    assert answer.exit_code == 0, answer.output
    assert "Note: the recordings are short: windows of" in answer.output
    (line,) = [line for line in answer.output.splitlines() if line.startswith("measured channels")]
    # ten noisy samples of 0.3 s tell the state of a mode of 3 s to a few per cent; the rest is the learned residual
    assert float(line.split()[-1]) > 0.9
