"""The 4-DOF chain of the paper: four masses in a row, each tied to the one before, the first to the ground.

    M = diag(1, 2, 3, 4) kg, springs 1, 2, 3, 4 N/m from the ground outwards, a dashpot of 0.1 N s/m from every mass to
    the ground, and, where asked for, a cubic spring k_n u^3 from mass 1 to the ground.

Natural modes: omega = 0.2466, 1.0948, 1.7321, 2.1387 rad/s, damping ratios 7.0, 2.5, 1.6, 1.5 %.

Source: Lai et al., Data-Centric Engineering 3, e34, 2022. It prints the cubic force in the fourth equation; the
authors' program, and every result of theirs, has it in the first, as here.
"""

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.effects import CubicSpring
from fe_models.linear import ModalModel
from fe_models.recordings import Assumptions, Dataset, Quantity, Sensor
from fe_models.simulate import FreeConfig, simulate_free
from fe_models.structure import Dashpot, PointMass, Spring, Structure
from fe_models.synthetic import train_and_test

MASSES = (1.0, 2.0, 3.0, 4.0)  # kg
STIFFNESSES = (1.0, 2.0, 3.0, 4.0)  # N/m
DAMPING_COEFFICIENT = 0.1  # N s/m
PAPER_OMEGA = (0.2466, 1.0948, 1.7321, 2.1387)  # rad/s


def four_dof(cubic_stiffness: float = 0.0) -> Structure:
    """Return the chain; ``cubic_stiffness`` k_n (N/m^3) of the spring at node 1, which 0 leaves out."""
    nodes = range(1, 5)
    first, *others = STIFFNESSES
    springs = [Spring((1,), "x", first)]
    springs += [Spring((node - 1, node), "x", stiffness) for node, stiffness in zip(nodes[1:], others, strict=True)]
    chain = Structure(
        name="four_dof",
        nodes=tuple((float(node), 0.0) for node in nodes),
        elements=tuple(springs),
        point_masses=tuple(PointMass(node, mass) for node, mass in zip(nodes, MASSES, strict=True)),
        dashpots=tuple(Dashpot((node,), "x", DAMPING_COEFFICIENT) for node in nodes),
        directions=("x",),
    )
    return chain.with_effects(CubicSpring((1,), "x", cubic_stiffness)) if cubic_stiffness else chain


PAPER_MEASURED = ("x4", "a1", "a3", "a4")
PAPER_NOISE = 0.03
PAPER_UNITS: dict[str, tuple[Quantity, str]] = {
    "x": ("displacement", "m"),
    "v": ("velocity", "m/s"),
    "a": ("acceleration", "m/s^2"),
}


def paper_dataset(
    cubic_stiffness: float = 0.0,
    modal_model: ModalModel | None = None,
    rng: np.random.RandomState | None = None,
    realisations: int = 1000,
    progress: bool = True,
) -> Dataset:
    """Return the paper's data: free motions from z0 ~ N(0, I_8), 50 s at 10 Hz, 80 % train and 20 % test.

    ``cubic_stiffness`` is the k_n (N/m^3) of the simulated truth; the dataset's own model is the linear chain, or the
    ``modal_model`` where one is given. Channels: x, v and a of the four masses, of which x4, a1, a3, a4 are measured
    and the others held out. Without ``rng``, the authors' legacy generator with seed 0, which for 1000 realisations
    gives their numbers; any other draws another set.
    """
    rng = rng or np.random.RandomState(0)  # the legacy generator: only it gives the authors' numbers
    start = rng.randn(8, realisations)  # a column a realisation: four displacements, four velocities
    truth = four_dof(cubic_stiffness)
    motion = simulate_free(truth, start[:4].T, start[4:].T, FreeConfig(duration=50.0, sampling_rate=10.0), (), progress)
    channels = [
        _noisy(x, v, a, rng) for x, v, a in zip(motion.displacement, motion.velocity, motion.acceleration, strict=True)
    ]
    data = np.stack(channels)  # (realisation, time, sensor)
    return Dataset(
        model=four_dof(),
        sampling_rate=10.0,
        sensors=paper_sensors(),
        recordings=train_and_test(data),
        assumptions=Assumptions(modal_model=modal_model),
    )


def paper_sensors() -> tuple[Sensor, ...]:
    """Return the twelve channels x1..x4, v1..v4, a1..a4."""
    return tuple(
        Sensor(name, node, "x", quantity, unit, "measured" if name in PAPER_MEASURED else "held_out")
        for letter, (quantity, unit) in PAPER_UNITS.items()
        for node in range(1, 5)
        for name in [f"{letter}{node}"]
    )


def _noisy(x: FloatArray, v: FloatArray, a: FloatArray, rng: np.random.RandomState) -> FloatArray:
    """Return one motion's channels (time, 12) with noise, drawn as the authors do.

    Its standard deviation is 3 % of that of all eight states together, for accelerations of all eight rates; the noise
    of the other four rates is drawn and thrown away.
    """
    states, rates = np.hstack([x, v]), np.hstack([v, a])
    state_noise = PAPER_NOISE * states.std() * rng.randn(*states.shape)
    rate_noise = PAPER_NOISE * rates.std() * rng.randn(*rates.shape)
    return np.hstack([states + state_noise, a + rate_noise[:, 4:]])
