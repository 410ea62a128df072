"""Problems for the hybrid model that carry their exact solution: the four-mass chain and its free decay.

The chain's matrices are the textbook's, its decay is the closed form of a damped oscillator, mode by mode, and its
nonlinear motion is scipy's eighth-order Runge-Kutta: none of them knows torch, Exudyn or the product's own solvers.
"""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace

import numpy as np
import torch
from scipy.integrate import solve_ivp
from scipy.linalg import eigh

from fe_models.arrays import FloatArray
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import ForceLaw
from fe_models.dofs import structure_dofs
from fe_models.linear import ModalModel
from fe_models.recordings import Assumptions, Dataset, Recording, Sensor
from hybrid.config import Config, ModelConfig, TrainingConfig
from hybrid.neural_modal_ode.dynamics import ModalDynamics
from hybrid.neural_modal_ode.model import NeuralModalODE
from hybrid.neural_modal_ode.residuals.free_residual import FreeResidual
from hybrid.neural_modal_ode.scaling import StateScale
from hybrid.training.gradient_training import Trainer
from hybrid.training.preparation import prepare

MASS = np.diag([1.0, 2.0, 3.0, 4.0])  # kg
STIFFNESS = np.array([[3.0, -2, 0, 0], [-2, 5, -3, 0], [0, -3, 7, -4], [0, 0, -4, 4]])  # N/m
STEP = 0.5  # s: six samples in a period of the fastest mode, 50 in one of the slowest
OFF_FREQUENCY = np.array([1.18, 0.85, 1.10, 0.93])  # of the nominal frequencies: what no engineer would call a fit
OFF_RATIO = 0.07  # where the nominal model says 0.01
SENSORS = (
    Sensor("x4", 4, "x", "displacement", "m"),
    Sensor("a1", 1, "x", "acceleration", "m/s^2"),
    Sensor("v2", 2, "x", "velocity", "m/s", "held_out"),
    Sensor("a3", 3, "x", "acceleration", "m/s^2"),
    Sensor("a4", 4, "x", "acceleration", "m/s^2"),
)
MEASURED = [0, 1, 3, 4]
HELD_OUT = 2
TINY = Config(
    ModelConfig(net_hidden=8),
    TrainingConfig(window=80, epochs=4, batch=8, first_horizon=20, threads=1, noise_std=0.2),
)


@dataclass(frozen=True)
class Motion:
    """Modal coordinates and their two rates, each (realisation, time, mode)."""

    q: FloatArray
    q_dot: FloatArray
    q_ddot: FloatArray


@contextmanager
def double_precision() -> Iterator[None]:
    """Make float64 the type of new tensors, on one thread."""
    before, threads = torch.get_default_dtype(), torch.get_num_threads()
    torch.set_default_dtype(torch.float64)
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_default_dtype(before)
        torch.set_num_threads(threads)


def chain_modes(ratio: float | FloatArray = 0.01) -> ModalModel:
    """The four modes of the chain, mass-normalised, with one damping ratio or four."""
    squares, shapes = eigh(STIFFNESS, MASS)
    return ModalModel(np.sqrt(squares), np.full(4, ratio), shapes, structure_dofs(four_dof()))


def off_chain() -> ModalModel:
    """The truth that a calibration has to find: other frequencies, other damping, the same shapes."""
    nominal = chain_modes()
    return replace(nominal, omega=nominal.omega * OFF_FREQUENCY, damping_ratio=np.full(4, OFF_RATIO))


def decay(modal: ModalModel, q: FloatArray, q_dot: FloatArray, step: float, samples: int) -> Motion:
    """Free motion from q, q' (realisation, mode): q = e^{-st} (q0 cos wd t + (q0' + s q0) / wd sin wd t), s = xi w."""
    time = step * np.arange(samples)[:, None]  # (time, 1)
    s = modal.damping_ratio * modal.omega
    damped = modal.omega * np.sqrt(1 - modal.damping_ratio**2)
    c, d = np.exp(-s * time) * np.cos(damped * time), np.exp(-s * time) * np.sin(damped * time)  # (time, mode)
    q, q_dot = q[:, None], q_dot[:, None]
    moved = q * c + (q_dot + s * q) / damped * d
    rate = q_dot * c - (modal.omega**2 * q + s * q_dot) / damped * d
    return Motion(moved, rate, -(modal.omega**2) * moved - 2 * s * rate)


def channels(modal: ModalModel, motion: Motion, sensors: Sequence[Sensor]) -> FloatArray:
    """What the sensors see of a motion, sensor by sensor, (realisation, time, sensor)."""
    parts = {"displacement": motion.q, "velocity": motion.q_dot, "acceleration": motion.q_ddot}
    seen = [parts[s.quantity] @ modal.shapes[modal.dofs.row(s.node, str(s.direction))] for s in sensors]
    return np.stack(seen, axis=-1)


def recorded(
    modal: ModalModel,
    realisations: int,
    samples: int,
    seed: int,
    noise: float = 0.0,
    sensors: tuple[Sensor, ...] = SENSORS,
) -> FloatArray:
    """Free decays from random states, q ~ N(0, 1 / w^2), q' ~ N(0, 1), with noise relative to each channel."""
    rng = np.random.default_rng(seed)
    q, q_dot = rng.standard_normal((2, realisations, len(modal.omega)))
    data = channels(modal, decay(modal, q / modal.omega, q_dot, STEP, samples), sensors)
    return np.asarray(data + noise * data.std(axis=(0, 1)) * rng.standard_normal(data.shape))


def chain_dataset(
    truth: ModalModel | None = None, noise: float = 0.02, realisations: int = 12, samples: int = 100
) -> Dataset:
    """A dataset of the `truth` (the chain that is off by default), to be explained by the nominal chain."""
    truth = truth or off_chain()
    return Dataset(
        four_dof(),
        1 / STEP,
        SENSORS,
        (
            Recording("one", recorded(truth, realisations, samples, 1, noise)),
            Recording("other", recorded(truth, 2, samples, 2, noise)),
            Recording("unseen", recorded(truth, 3, samples, 3, noise), "test"),
        ),
        assumptions=Assumptions(modal_model=chain_modes()),
    )


def cubic_dataset(stiffness: float = 1.0, size: float = 0.3, realisations: int = 45, samples: int = 80) -> Dataset:
    """A dataset of the chain with a cubic spring (N/m^3) from mass 1 to the ground, which the nominal one lacks."""
    modal, rng = chain_modes(), np.random.default_rng(4)
    inverse = np.linalg.inv(MASS)

    def rate(_: float, state: FloatArray) -> FloatArray:
        x, v = state[:4], state[4:]
        force = STIFFNESS @ x + 0.02 * STIFFNESS @ v + np.array([stiffness * x[0] ** 3, 0, 0, 0])
        return np.concatenate([v, -inverse @ force])

    times = STEP * np.arange(samples)
    data = []
    for start in size * rng.standard_normal((realisations, 8)):
        states = solve_ivp(rate, (0, times[-1]), start, "DOP853", times, rtol=1e-8, atol=1e-8).y.T
        x, v = states[:, :4], states[:, 4:]
        a = np.array([rate(0, state)[4:] for state in states])
        data.append(np.column_stack([x[:, 3], a[:, 0], v[:, 1], a[:, 2], a[:, 3]]))  # in the order of SENSORS
    train = Recording("train", np.array(data[:-5]))
    test = Recording("test", np.array(data[-5:]), "test")
    return Dataset(four_dof(), 1 / STEP, SENSORS, (train, test), assumptions=Assumptions(modal_model=modal))


def with_column(dataset: Dataset, role: str, column: int, value: float) -> Dataset:
    """The dataset with one channel of its recordings of one role replaced by a ramp up to ``value``."""

    def changed(recording: Recording) -> Recording:
        if recording.role != role:
            return recording
        data = recording.data.copy()
        data[:, :, column] = np.linspace(0.0, value, data.shape[1])
        return replace(recording, data=data)

    return replace(dataset, recordings=tuple(changed(recording) for recording in dataset.recordings))


def dynamics_of(
    modal: ModalModel,
    effects: tuple[ForceLaw, ...] = (),
    net: float = 0.0,
    scale: StateScale | None = None,
    hidden: int = 6,
) -> ModalDynamics:
    """The latent ODE with a random network of size ``net``; unit scales where none are given."""
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(3)
        residual = FreeResidual(len(modal.omega), hidden, zero_at_rest=True)
        dynamics = ModalDynamics(modal, effects, scale or StateScale.unit(len(modal.omega)), residual)
        with torch.no_grad():
            for parameter in last_layer(dynamics).parameters():
                parameter.normal_(std=net) if net else parameter.zero_()
    return dynamics


def solved(dynamics: ModalDynamics, z0: FloatArray, times: FloatArray) -> FloatArray:
    """States (time, 2 mode) of dz/dt from z0 (2 mode,) by DOP853, to about 1e-11."""

    @torch.no_grad()
    def rate(_: float, z: FloatArray) -> FloatArray:
        return np.asarray(dynamics(torch.zeros(()), torch.tensor(z)[None])[0])

    solution = solve_ivp(rate, (times[0], times[-1]), z0, "DOP853", times, rtol=1e-11, atol=1e-12)
    return np.asarray(solution.y.T)


def observed_order(steps: Sequence[float], errors: Sequence[float]) -> float:
    """Slope of log error over log step."""
    return float(np.polyfit(np.log(steps), np.log(errors), 1)[0])


def last_layer(dynamics: ModalDynamics) -> torch.nn.Linear:
    """The output layer of the network, which starts at zero."""
    assert isinstance(dynamics.residual, FreeResidual)
    layer = dynamics.residual.net[-1]
    assert isinstance(layer, torch.nn.Linear)
    return layer


def starting_model(dataset: Dataset, config: Config = TINY) -> NeuralModalODE:
    """The model of ``config`` as it is before any training."""
    return prepare(dataset, config).model


def trainer_of(dataset: Dataset, config: Config = TINY) -> Trainer:
    """A trainer that has not begun."""
    prepared = prepare(dataset, config)
    return Trainer(prepared.model, prepared.windows, config.training)


def trained(dataset: Dataset, config: Config = TINY) -> Trainer:
    """A trainer that has done all its epochs."""
    trainer = trainer_of(dataset, config)
    for _ in trainer.epochs():
        pass
    return trainer


def learned(model: torch.nn.Module) -> dict[str, torch.Tensor]:
    """A copy of all that is learned."""
    return {name: value.detach().clone() for name, value in model.named_parameters()}


def same(one: dict[str, torch.Tensor], other: dict[str, torch.Tensor]) -> bool:
    """Whether two sets of weights are equal bit for bit."""
    return one.keys() == other.keys() and all(torch.equal(one[name], other[name]) for name in one)
