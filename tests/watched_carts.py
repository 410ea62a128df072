"""Free decays of two carts between springs, as a logger leaves them: one file a recording."""

import os
import time
from pathlib import Path

import numpy as np
from scipy.linalg import eigh

from fe_models.arrays import FloatArray

RATE, LASTS = 20.0, 60.0  # Hz, s
MASSES = np.array([1.0, 1.2])  # kg
STIFFNESS = (400.0, 300.0)  # N/m: wall to the first, first to second
RATIO = 0.01
STRUCTURE = """schema = 1
name = "carts"
nodes = [[0.0, 0.0], [1.0, 0.0]]
directions = ["x"]
damping = { modal_ratios = 0.01 }
elements = [
    { kind = "spring", nodes = [1], direction = "x", stiffness = 400.0 },
    { kind = "spring", nodes = [1, 2], direction = "x", stiffness = 300.0 },
]
point_masses = [{ node = 1, mass = 1.0 }, { node = 2, mass = 1.2 }]
"""
DATASET = """schema = 1
model = "carts.toml"
sampling_rate = 20.0
sensors = [
    { name = "x1", node = 1, direction = "x", quantity = "displacement", unit = "m" },
    { name = "x2", node = 2, direction = "x", quantity = "displacement", unit = "m" },
]
recordings = [{ name = "day0", file = "day0.csv", excitation = "free" }]
"""


def natural_modes(stiffness: tuple[float, float]) -> tuple[FloatArray, FloatArray]:
    """Return angular frequencies (mode,), rad/s, and shapes (cart, mode)."""
    first, second = stiffness
    squares, shapes = eigh(np.array([[first + second, -second], [-second, second]]), np.diag(MASSES))
    return np.sqrt(squares), np.asarray(shapes)


def free_decay(stiffness: tuple[float, float], rng: np.random.Generator) -> FloatArray:
    """Return displacements (time, cart) from a random state, with 1 % of noise: modal superposition."""
    omega, shapes = natural_modes(stiffness)
    time_ = np.arange(int(RATE * LASTS))[:, None] / RATE
    phase, size = rng.uniform(0, 2 * np.pi, 2), 0.01 * rng.uniform(0.7, 1.3, 2)
    modal = size * np.exp(-RATIO * omega * time_) * np.cos(omega * np.sqrt(1 - RATIO**2) * time_ + phase)
    clean = modal @ shapes.T
    return np.asarray(clean + 0.01 * clean.std() * rng.standard_normal(clean.shape))


def record(folder: Path, name: str, seed: int, softened: float = 1.0, age: float = 100.0) -> None:
    """Write a recording that was whole ``age`` s ago; ``softened``: factor of the first spring.

    Springs scatter by 0.1 % from one to the next, as temperature and handling have it.
    """
    rng = np.random.default_rng(seed)
    moved = 1 + 1e-3 * rng.standard_normal(2)
    data = free_decay((STIFFNESS[0] * softened * moved[0], STIFFNESS[1] * moved[1]), rng)
    path = folder / f"{name}.csv"
    np.savetxt(path, data, delimiter=",", header="x1,x2", comments="")
    os.utime(path, (time.time() - age,) * 2)


def station(folder: Path) -> None:
    """Write a structure, its dataset and a recording."""
    folder.mkdir()
    (folder / "carts.toml").write_text(STRUCTURE)
    (folder / "dataset.toml").write_text(DATASET)
    record(folder, "day0", 0, age=200.0)
