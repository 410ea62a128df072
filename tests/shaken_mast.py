"""A mast under a shaker, recorded behind a low-pass: its motion by another solver than the diagnosis has."""

import numpy as np
from scipy.signal import cont2discrete, lfilter

from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.causes import Effect
from fe_models.measurement import lowpassed
from fe_models.modes import natural_modes
from fe_models.recordings import Dataset, Load, Recording, Sensor
from fe_models.sections import square_tube
from fe_models.structure import Beam, Damping, PointMass, Structure, Support

TUBE = square_tube("tube", youngs_modulus=2.1e11, density=7850.0, side=0.2, wall=0.008)
MAST = Structure(  # with modes at 1.0, 7.8, 23.5 and 47.9 Hz
    "mast",
    tuple((0.0, 3.0 * i) for i in range(5)),
    tuple(Beam((i, i + 1), TUBE) for i in range(1, 5)),
    (PointMass(5, 200.0),),
    supports=(Support(1, ("x", "y", "rz")),),
    damping=Damping(modal_ratios=(0.01,)),
    divisions=3,
)
SENSORS = tuple(Sensor(f"a{node}", node, "x", "acceleration", "m/s^2") for node in (2, 3, 4, 5))
PUSHED, RATE, CUTOFF, SAMPLES, OFTEN = 4, 100.0, 30.0, 1501, 40


def accelerations(structure: Structure, force: FloatArray, step: float) -> FloatArray:
    """Return those of the sensors (time, sensor) from rest under a ``force`` (time,), N, each mode by itself.

    Exact for straight lines between the force's values.
    """
    linear = linearise(structure)
    modal = natural_modes(linear, len(linear.dofs.free_rows))
    rows = [modal.dofs.row(sensor.node, str(sensor.direction)) for sensor in SENSORS]
    pushed, moved = modal.shapes[modal.dofs.row(PUSHED, "x")], np.zeros((len(force), len(rows)))
    for mode, omega in enumerate(modal.omega):
        ratio = 2 * structure.damping.modal_ratios[0] * omega
        above, below, _ = cont2discrete(([1.0, 0.0, 0.0], [1.0, ratio, omega**2]), step, "foh")
        moved += lfilter(above.ravel(), below, pushed[mode] * force)[:, None] * modal.shapes[rows, mode]
    return moved


def recorded(*effects: Effect) -> Dataset:
    """Return four recordings of a shaker's noise, force and accelerations behind one low-pass, with 3 % noise."""
    rng, fine, begin = np.random.default_rng(1), RATE * OFTEN, 2 * round(RATE)
    recordings = []
    for number in range(4):
        force = lowpassed(200 * rng.standard_normal((begin + SAMPLES) * OFTEN), fine, 2 * CUTOFF)
        motion = accelerations(MAST.with_effects(*effects), force, 1 / fine)
        load, clean = (lowpassed(part, fine, CUTOFF)[::OFTEN][begin:] for part in (force, motion))
        white = lowpassed(rng.standard_normal(clean.shape), RATE, CUTOFF)
        data = clean + 0.03 * clean.std(axis=0) / white.std(axis=0) * white
        loads = (Load(PUSHED, "x", load),)
        recordings.append(Recording(f"r{number}", data[None], "test" if number == 3 else "train", loads))
    return Dataset(MAST, RATE, SENSORS, tuple(recordings), CUTOFF)
