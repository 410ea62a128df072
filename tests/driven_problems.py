"""The four-mass chain under known forces, by scipy's Runge-Kutta: motion that knows none of the project's solvers."""

from collections.abc import Sequence

import numpy as np
from scipy.integrate import solve_ivp

from fe_models.arrays import FloatArray
from fe_models.base_motion import BaseMotion
from fe_models.built_in.four_dof import four_dof
from fe_models.interpolant import interpolant
from fe_models.linear import ModalModel
from fe_models.recordings import Assumptions, Dataset, Load, Recording, Sensor
from tests.hybrid_problems import MASS, SENSORS, STEP, chain_modes

QUANTITIES = ("displacement", "velocity", "acceleration")


def smooth_force(samples: int, seed: int, size: float = 1.0) -> FloatArray:
    """A random force (time,) with little above a fifth of the sampling rate."""
    nodes = np.random.default_rng(seed).standard_normal(samples // 3 + 9)
    return np.asarray(size * interpolant(nodes)(np.arange(samples) / 3 + 3))


def driven_motion(
    modal: ModalModel,
    pulls: Sequence[FloatArray],
    values: Sequence[FloatArray],
    start: FloatArray | None = None,
    cubic: float = 0.0,
) -> FloatArray:
    """u, u' and u'' of the four masses (quantity, time, mass) under forces ``values`` (time,) along ``pulls`` (mass,).

    A cubic spring (N/m^3) joins mass 1 to the ground. To about 1e-9.
    """
    linear, inverse = slopes(modal), np.linalg.inv(MASS)
    pushed = interpolant(np.column_stack(values) @ np.stack(pulls) @ inverse)

    def rate(time: float, state: FloatArray) -> FloatArray:
        found = linear @ state
        found[4:] += pushed(time / STEP) - cubic * state[0] ** 3 * inverse[0]
        return found

    times = STEP * np.arange(len(values[0]))
    begin = np.zeros(8) if start is None else start
    states = solve_ivp(rate, (0.0, times[-1]), begin, "DOP853", times, rtol=1e-9, atol=1e-10, max_step=STEP).y.T
    rates = [rate(time, state)[4:] for time, state in zip(times, states, strict=True)]
    return np.stack([states[:, :4], states[:, 4:], np.array(rates)])


def slopes(modal: ModalModel) -> FloatArray:
    """d[u; u']/dt = A [u; u'] of the four masses under no force, A (8, 8): K and C are those of the modes."""
    shapes = modal.shapes[modal.dofs.free_rows]
    decay = 2 * modal.damping_ratio * modal.omega
    K, C = (shapes @ np.diag(each) @ shapes.T @ MASS for each in (modal.omega**2, decay))  # over the mass
    return np.block([[np.zeros((4, 4)), np.eye(4)], [-K, -C]])


def shown(motion: FloatArray, sensors: Sequence[Sensor]) -> FloatArray:
    """What sensors show of a motion (quantity, time, mass), (time, sensor)."""
    return np.column_stack([motion[QUANTITIES.index(each.quantity), :, each.node - 1] for each in sensors])


def loaded_recording(
    name: str, modal: ModalModel, seed: int, samples: int = 160, noise: float = 0.0, cubic: float = 0.0
) -> Recording:
    """The chain from rest under forces on masses 1 and 3; a test where the name says so."""
    forces = [smooth_force(samples, 10 * seed + i, 0.5) for i in (0, 1)]
    data = shown(driven_motion(modal, [np.eye(4)[0], np.eye(4)[2]], forces, cubic=cubic), SENSORS)
    noisy = data + noise * data.std(axis=0) * np.random.default_rng(seed).standard_normal(data.shape)
    loads = (Load(1, "x", forces[0]), Load(3, "x", forces[1]))
    return Recording(name, noisy[None], "test" if "test" in name else "train", loads)


def loaded_dataset(modal: ModalModel, count: int = 4, noise: float = 0.0, cubic: float = 0.0) -> Dataset:
    """``count`` training recordings and a test of the chain that has the modes of ``modal``, beside the nominal one."""
    names = [*(f"train {number}" for number in range(count)), "test"]
    recordings = [loaded_recording(name, modal, seed, noise=noise, cubic=cubic) for seed, name in enumerate(names)]
    assumed = Assumptions(modal_model=chain_modes())
    return Dataset(four_dof(), 1 / STEP, SENSORS, tuple(recordings), assumptions=assumed)


def shaken_recording(modal: ModalModel, sensors: Sequence[Sensor], samples: int = 160) -> Recording:
    """The chain on a base that moves along x, as sensors show it that are absolute, or on the base."""
    ground = smooth_force(samples, 7)
    course = interpolant(ground)
    velocity = course.antiderivative()
    time = np.arange(samples)
    moved = np.stack([STEP**2 * velocity.antiderivative()(time), STEP * velocity(time), ground])
    relative = driven_motion(modal, [-MASS @ np.ones(4)], [ground])
    absolute = relative + moved[:, :, None]
    both = {"absolute": shown(absolute, sensors), "base": shown(relative, sensors)}
    columns = [both[sensor.reference][:, column] for column, sensor in enumerate(sensors)]
    return Recording("shaken", np.column_stack(columns)[None], base=(BaseMotion("x", ground),))


def ambient_motion(modal: ModalModel, samples: int, seed: int, cubic: float = 0.0) -> FloatArray:
    """u, u' and u'' of the four masses (quantity, time, mass) under white forces, constant from sample to sample.

    By Runge and Kutta's fourth order in 20 parts of a step, after a hundred samples from rest.
    """
    linear, inverse, h = slopes(modal), np.linalg.inv(MASS), STEP / 20
    forces = np.random.default_rng(seed).standard_normal((samples + 100, 4))

    def rate(state: FloatArray, pushed: FloatArray) -> FloatArray:
        found = linear @ state
        found[4:] += pushed
        if cubic:
            found[4:] -= cubic * state[0] ** 3 * inverse[0]
        return found

    state, found = np.zeros(8), []
    for pushed in forces @ inverse:
        found.append([state[:4], state[4:], rate(state, pushed)[4:]])
        for _ in range(20):
            k1 = rate(state, pushed)
            k2 = rate(state + 0.5 * h * k1, pushed)
            k3 = rate(state + 0.5 * h * k2, pushed)
            state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + rate(state + h * k3, pushed))
    return np.asarray(np.transpose(found[100:], (1, 0, 2)))
