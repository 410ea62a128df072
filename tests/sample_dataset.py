"""A small, sound dataset with its files, which tests then break in one place or many."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fe_models.arrays import FloatArray
from fe_models.errors import InputError
from fe_models.files.atomic import write_npz
from fe_models.files.dataset_file import load_dataset
from fe_models.files.structure_file import save_structure
from fe_models.recordings import Sensor
from fe_models.sections import Section
from fe_models.structure import Beam, Structure, Support

RATE = 100.0  # Hz
LOWPASS = 30.0  # Hz
SAMPLES = 400
STEEL = Section("steel", 2.1e11, 7850.0, 1e-4, 1e-9)
MAST = Structure(
    name="mast",
    nodes=((0.0, 0.0), (0.0, 1.0), (0.0, 2.0)),
    elements=(Beam((1, 2), STEEL), Beam((2, 3), STEEL)),
    supports=(Support(1, ("x", "y", "rz")),),
)
SENSORS = (
    Sensor("a2", 2, "x", "acceleration", "m/s^2"),
    Sensor("a3", 3, "x", "acceleration", "m/s^2", "held_out"),
    Sensor("d3", 3, "y", "displacement", "1"),
)
NAMES = [sensor.name for sensor in SENSORS]
TOML = """
schema = 1
model = "mast.toml"
sampling_rate = 100.0
lowpass = 30.0

[[sensors]]
name = "a2"
node = 2
direction = "x"
quantity = "acceleration"
unit = "m/s^2"

[[sensors]]
name = "a3"
node = 3
direction = "x"
quantity = "acceleration"
unit = "m/s^2"
role = "held_out"

[[sensors]]
name = "d3"
node = 3
direction = "y"
quantity = "displacement"
unit = "1"

[[recordings]]
name = "r1"
file = "r1.npz"
key = "data"

[[recordings]]
name = "r2"
file = "r2.npz"
key = "data"
role = "test"
loads = [{ node = 3, direction = "x", file = "r2.npz", key = "force" }]

[simulation]
damping_ratio = [0.01, 0.02]
modes = 2
modal_model = "modal.npz"
uncertainty = { stiffness = 0.05 }
"""
MODAL = {"omega": np.array([3.0, 20.0]), "xi": np.array([0.01]), "phi": np.arange(12.0).reshape(6, 2)}


def free_decay(seed: int = 0, channels: int = 3) -> FloatArray:
    """Damped modes at 2 and 12 Hz in every channel, (time, channel)."""
    rng = np.random.default_rng(seed)
    time = np.arange(SAMPLES)[:, None] / RATE
    shapes = rng.standard_normal((2, channels))
    frequencies = np.array([2.0, 12.0])
    modes = np.exp(-0.1 * frequencies * time) * np.cos(2 * np.pi * frequencies * time)  # (time, mode)
    return np.asarray(modes @ shapes, dtype=float)


def write_sample(folder: Path) -> Path:
    """Write the dataset and all it needs into ``folder``, and return that."""
    save_structure(MAST, folder / "mast.toml")
    np.savez(folder / "r1.npz", data=free_decay(1))
    np.savez(folder / "r2.npz", data=free_decay(2), force=np.ones(SAMPLES))
    write_npz(folder / "modal.npz", MODAL)
    (folder / "dataset.toml").write_text(TOML)
    return folder


def broken(row: Any, column: Any, value: float) -> FloatArray:
    """Return a recording with ``value`` at some samples."""
    data = free_decay(1)
    data[row, column] = value
    return data


def faults_of(folder: Path, *changes: tuple[str, str]) -> tuple[str, ...]:
    text = TOML
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    (folder / "dataset.toml").write_text(text)
    with pytest.raises(InputError) as caught:
        load_dataset(folder / "dataset.toml")
    return caught.value.faults


def assert_fault(faults: tuple[str, ...], words: str) -> None:
    assert any(words in fault for fault in faults), faults
