"""Recordings of matrices: beside the matrix exponential of the whole system, and by the command."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import make_interp_spline
from scipy.linalg import expm
from typer.testing import CliRunner

import fe_models as fe
from fe_models.base_motion import BaseMotion
from fe_models.errors import InputError
from fe_models.files.atomic import write_npz
from fe_models.files.dataset_file import load_dataset
from fe_models.files.matrices_file import load_linear_model
from fe_models.linear import LinearModel
from fe_models.linear_recordings import released_recordings
from fe_models.recordings import Load, Sensor
from fe_models.statics import PointLoad
from fe_models.synthetic import Acquisition
from hybrid.commands.app import app
from tests.space_frames import FOLLOWED, cantilever_arrays, two_storeys

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
    return np.stack([whole[s.quantity][:, model.dofs.row(s.node, str(s.direction))] for s in SENSORS], axis=1)


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


@pytest.mark.parametrize("ratio", [0.5, 1 - 1e-13, 1.0, 1 + 1e-9, 2.0, 50.0])
def test_a_release_is_exact_at_any_damping_ratio(model: LinearModel, ratio: float) -> None:
    """C proportional to K gives higher modes more: the first has ``ratio``, each other one omega / omega_1 times it."""
    factor = 2 * ratio / fe.natural_modes(model).omega[0]
    damped = replace(model, damping=factor * model.stiffness, modal_ratios=())
    pulls = (PointLoad(FOLLOWED, "y", 2000.0), PointLoad(3, "x", -500.0))
    data = released_recordings(damped, [pulls], SENSORS, QUIET, 0.5, np.random.default_rng(0)).recordings[0].data[0]
    M, K = model.mass.toarray(), model.stiffness.toarray()
    zero, one = np.zeros_like(M), np.eye(len(M))
    A = np.block([[zero, one], [-np.linalg.solve(M, K), -np.linalg.solve(M, factor * K)]])
    force = model.dofs.gathered(model.dofs.pull([(p.node, p.direction, p.force) for p in pulls]))
    start = np.concatenate([np.linalg.solve(K, force), np.zeros(len(force))])
    states = np.array([expm(A * t) @ start for t in np.arange(len(data)) / QUIET.sampling_rate])
    expected = shown(model, states, states @ A.T)
    size = np.abs(expected).max(axis=0)
    np.testing.assert_allclose(data / size, expected / size, atol=1e-7)  # expm's own, of stiff A: 1e-8 at ratio 50


def test_what_drives_moves_the_whole_system(model: LinearModel) -> None:
    """Two loads and the base at once, up to half the sampling rate: beside Runge-Kutta of order 8 on the smooth curves
    through their samples. Accelerometers show the absolute motion.
    """
    rng = np.random.default_rng(4)
    corner, top = Load(FOLLOWED, "y", 1e3 * rng.standard_normal(81)), Load(3, "x", 1e3 * rng.standard_normal(81))
    base = BaseMotion((1.0, 1.0), rng.standard_normal(81))
    data = fe.simulate(model, SENSORS, excitation=[[corner, base, top]], sampling_rate=200.0, noise=0.0)
    (recording,) = data.recordings
    assert (recording.loads, recording.base) == ((corner, top), (base,))
    A, size, dofs = state_matrix(model), model.mass.shape[0], model.dofs
    r = np.array([{"x": 1.0, "y": 1.0}.get(d, 0.0) / np.sqrt(2) for d in dofs.direction[dofs.free]])
    unit = [dofs.gathered(dofs.pull([(load.node, load.direction, 1.0)])) for load in (corner, top)]
    pushed = np.linalg.solve(model.mass.toarray(), np.array([*unit, -model.mass @ r]).T)  # (free, force)
    B = np.concatenate([np.zeros((size, 3)), pushed])
    curve = make_interp_spline(np.arange(81), np.stack([corner.values, top.values, base.values], axis=1), 7)
    time = np.arange(81) / 200.0
    found = solve_ivp(
        lambda t, z: A @ z + B @ curve(200.0 * t),
        (0.0, time[-1]),
        np.zeros(2 * size),
        "DOP853",
        time,
        rtol=1e-9,
        atol=1e-12,
        max_step=2e-3,
    )
    states = found.y.T
    expected = shown(model, states, states @ A.T + curve(200.0 * time) @ B.T)
    ground = [integral(np.arange(81)) for integral in base.integrals()]
    expected[:, 0] += ground[1] / 200.0**2 / np.sqrt(2)
    expected[:, 1] += base.values / np.sqrt(2)
    expected[:, 2] += ground[0] / 200.0 / np.sqrt(2)
    size_of = np.abs(expected).max(axis=0)
    np.testing.assert_allclose(recording.data[0] / size_of, expected / size_of, atol=1e-6)  # the solver's


def test_a_base_that_rises_moves_what_bends_upwards(tmp_path: Path) -> None:
    arrays, _, _ = cantilever_arrays(4)
    write_npz(tmp_path / "beam.npz", arrays)
    beam = load_linear_model(tmp_path / "beam.npz")
    course = np.sin(0.2 * np.arange(101))
    up = fe.simulate(beam, ["a5z", "v3z", "x5ry"], excitation=[BaseMotion("z", course)], noise=0.0)
    aslant = fe.simulate(beam, ["a5z", "v3z", "x5ry"], excitation=[BaseMotion((0.0, 3.0, 4.0), course)], noise=0.0)
    still = fe.simulate(beam, ["a5y"], excitation=[BaseMotion("z", course)], noise=0.0)
    assert np.abs(still.recordings[0].data).max() < 1e-12
    np.testing.assert_allclose(aslant.recordings[0].data, 0.8 * up.recordings[0].data, rtol=1e-9, atol=1e-15)
    with pytest.raises(InputError, match="no node of this model moves in direction 'x'"):
        fe.simulate(beam, ["a5z"], excitation=[BaseMotion("x", course)], noise=0.0)


def test_matrices_are_pulled_and_let_go_from_python(model: LinearModel) -> None:
    data = fe.simulate(model, ["a3x", "x4y"], pulls=[PointLoad(3, "x", 100.0)] * 2, duration=1.0, sampling_rate=50.0)
    assert [recording.data.shape for recording in data.recordings] == [(1, 51, 2)] * 2
    assert data.lowpass == 15.0
    with pytest.raises(InputError, match="matrices are pulled and let go: give pulls"):
        fe.simulate(model, ["a3x"])
    with pytest.raises(InputError, match=r"a node and a direction \(x, y, rz\), such as \"a3x\""):
        fe.simulate(model, ["a3z"])


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
