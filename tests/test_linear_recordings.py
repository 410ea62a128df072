"""Recordings of matrices: beside the matrix exponential of the whole system, and by the command."""

from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm
from typer.testing import CliRunner

import fe_models as fe
from fe_models.base_motion import BaseMotion
from fe_models.errors import InputError
from fe_models.files.atomic import write_npz
from fe_models.files.dataset_file import load_dataset
from fe_models.files.matrices_file import load_linear_model
from fe_models.linear import LinearModel
from fe_models.linear_recordings import released_recordings, shaken_recordings
from fe_models.recordings import Sensor
from fe_models.statics import PointLoad
from fe_models.synthetic import Acquisition
from hybrid.commands.app import app
from tests.space_frames import FOLLOWED, two_storeys

QUIET = Acquisition(200.0, None, 0.0, 0.0)
SENSORS = (
    Sensor("top", 3, "x", "displacement", "m"),
    Sensor("corner", FOLLOWED, "y", "acceleration", "m/s^2"),
    Sensor("speed", 2, "y", "velocity", "m/s"),
)


@pytest.fixture
def model(tmp_path: Path) -> LinearModel:
    write_npz(tmp_path / "floors.npz", two_storeys())
    return load_linear_model(tmp_path / "floors.npz")


def state_matrix(model: LinearModel) -> np.ndarray:
    """Return A of the first-order system, with the damping matrix that the modal ratios stand for."""
    M, K = model.mass.toarray(), model.stiffness.toarray()
    C = fe.natural_modes(model)
    weighted = M @ C.shapes[model.dofs.free]
    damping = (weighted * (2 * C.damping_ratio * C.omega)) @ weighted.T
    zero, one = np.zeros_like(M), np.eye(len(M))
    return np.block([[zero, one], [-np.linalg.solve(M, K), -np.linalg.solve(M, damping)]])


def shown(model: LinearModel, states: np.ndarray, rates: np.ndarray) -> np.ndarray:
    """Return what the sensors show of states and their rates (time, state)."""
    size = model.mass.shape[0]
    parts = {"displacement": states[:, :size], "velocity": states[:, size:], "acceleration": rates[:, size:]}
    whole = {name: model.dofs.expand(part.T).T for name, part in parts.items()}
    return np.stack([whole[s.quantity][:, model.dofs.row(s.node, s.direction)] for s in SENSORS], axis=1)


def test_a_release_is_that_of_the_whole_system(model: LinearModel) -> None:
    pulls = (PointLoad(FOLLOWED, "y", 2000.0), PointLoad(3, "x", -500.0))
    data = released_recordings(model, [pulls], SENSORS, QUIET, 2.0, np.random.default_rng(0)).recordings[0].data[0]
    force = model.dofs.gathered(model.dofs.pull([(p.node, p.direction, p.force) for p in pulls]))
    A = state_matrix(model)
    start = np.concatenate([np.linalg.solve(model.stiffness.toarray(), force), np.zeros(len(force))])
    step, states = expm(A / QUIET.sampling_rate), [start]
    for _ in range(len(data) - 1):
        states.append(step @ states[-1])
    every = np.array(states)
    np.testing.assert_allclose(data, shown(model, every, every @ A.T), atol=1e-9 * np.abs(data).max())


def test_a_shaken_base_moves_the_whole_system(model: LinearModel) -> None:
    """Accelerometers show the absolute motion; a zero-order hold of 0.1 ms is off by a thousandth."""
    time = np.arange(201) / QUIET.sampling_rate
    motion = BaseMotion((1.0, 1.0), np.sin(2 * np.pi * 1.5 * time) * np.sin(np.pi * time))
    data = shaken_recordings(model, [motion], SENSORS, QUIET, np.random.default_rng(0)).recordings[0].data[0]
    A, size, fine = state_matrix(model), model.mass.shape[0], 50
    r = np.array([{"x": 1.0, "y": 1.0}.get(d, 0.0) / np.sqrt(2) for d in model.dofs.direction[model.dofs.free]])
    step = 1 / (QUIET.sampling_rate * fine)
    B = np.concatenate([np.zeros(size), -r])
    forward = expm(A * step)
    held = np.linalg.solve(A, (forward - np.eye(2 * size)) @ B)
    t = np.arange(200 * fine) * step + step / 2
    pushed, state, states = np.sin(2 * np.pi * 1.5 * t) * np.sin(np.pi * t), np.zeros(2 * size), [np.zeros(2 * size)]
    for number, a in enumerate(pushed, start=1):
        state = forward @ state + held * a
        if number % fine == 0:
            states.append(state)
    every = np.array(states)
    rates = every @ A.T + np.outer(motion.values, B)
    expected = shown(model, every, rates)
    ground = [integral(np.arange(201)) for integral in motion.integrals()]
    expected[:, 0] += ground[1] / QUIET.sampling_rate**2 / np.sqrt(2)
    expected[:, 1] += motion.values / np.sqrt(2)
    expected[:, 2] += ground[0] / QUIET.sampling_rate / np.sqrt(2)
    size = np.abs(expected).max(axis=0)
    np.testing.assert_allclose(data / size, expected / size, atol=2e-3)


def test_the_command_simulates_matrices_in_space(tmp_path: Path) -> None:
    write_npz(tmp_path / "floors.npz", two_storeys())
    words = ["simulate", str(tmp_path / "floors.npz"), "--out", str(tmp_path / "out"), "--pull", "3:x:1000+4:y:-200"]
    words += ["--pull", "2:y:500", "--sensor", "3:x", "--sensor", "4:y", "--sensor", "2:rz", "--duration", "5"]
    answer = CliRunner().invoke(app, [*words, "--no-pictures"])
    assert answer.exit_code == 0, answer.output
    dataset = load_dataset(tmp_path / "out" / "dataset.toml")
    assert isinstance(dataset.model, LinearModel)
    assert [group.name for group in dataset.model.groups] == ["storey 1", "storey 2"]
    assert [sensor.unit for sensor in dataset.sensors] == ["m/s^2", "m/s^2", "rad/s^2"]
    assert [recording.role for recording in dataset.recordings] == ["train", "test"]


def test_all_faults_of_a_simulation_at_once(model: LinearModel, tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        released_recordings(
            model,
            [(PointLoad(1, "x", 1.0),)],
            (Sensor("a", 9, "x", "acceleration", "m/s^2"), Sensor("b", 2, "z", "acceleration", "m/s^2")),
            QUIET,
            1.0,
            np.random.default_rng(0),
        )
    for fault, words in zip(
        caught.value.faults, ("node 9 does not exist", "in direction 'z'", "pull: node 1"), strict=True
    ):
        assert words in fault
