"""The paper's data of the 4-DOF chain, drawn as its authors draw them (`built_in.four_dof`; Lai et al. 2022)."""

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.built_in.four_dof import four_dof
from fe_models.errors import raise_faults
from fe_models.linear import ModalModel
from fe_models.recordings import Assumptions, Dataset, Quantity, Sensor
from fe_models.simulation import FreeConfig, simulate_free
from fe_models.simulation_size import length_faults
from fe_models.synthetic import train_and_test

PAPER_MEASURED = ("x4", "a1", "a3", "a4")
PAPER_NOISE = 0.03
DURATION, SAMPLING_RATE = 50.0, 10.0  # s, Hz
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
    raise_faults(length_faults(DURATION, SAMPLING_RATE, columns=12 * realisations))
    rng = rng or np.random.RandomState(0)  # the legacy generator: only it gives the authors' numbers
    start = rng.randn(8, realisations)  # a column a realisation: four displacements, four velocities
    truth = four_dof(cubic_stiffness)
    motion = simulate_free(truth, start[:4].T, start[4:].T, FreeConfig(DURATION, SAMPLING_RATE), (), progress)
    channels = [
        _noisy(x, v, a, rng) for x, v, a in zip(motion.displacement, motion.velocity, motion.acceleration, strict=True)
    ]
    data = np.stack(channels)  # (realisation, time, sensor)
    return Dataset(
        model=four_dof(),
        sampling_rate=SAMPLING_RATE,
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
