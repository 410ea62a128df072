"""Two masts side by side, and recordings of them."""

import numpy as np

from fe_models.assembly import linearise
from fe_models.causes import Effect
from fe_models.modes import natural_modes
from fe_models.recordings import Assumptions, Dataset, Recording, Sensor
from fe_models.sections import square_tube
from fe_models.simulation import FreeConfig, simulate_free
from fe_models.structure import Beam, Damping, PointMass, Structure, Support

TUBE = square_tube("tube", youngs_modulus=2.1e11, density=7850.0, side=0.1, wall=0.005)
APART = 0.05  # m
COUNT = 4
SENSORS = tuple(Sensor(f"a{node}", node, "x", "acceleration", "m/s^2") for node in (2, 3, 5, 6))
RATE, DURATION = 100.0, 5.0
NOISE = 0.02  # of each channel's rms
MOVING = 4  # modes below a quarter of the sampling rate


def masts(apart: float = APART, middle: float = 2.0) -> Structure:
    """Nodes 1-3 and 4-6 from the ground up, the middle ones at that height (m), the second with heavier storeys."""
    nodes = tuple((x, y) for x in (0.0, apart) for y in (0.0, middle, 4.0))
    elements = tuple(Beam((i, i + 1), TUBE) for i in (1, 2, 4, 5))
    masses = tuple(PointMass(node, mass) for node, mass in ((2, 200.0), (3, 150.0), (5, 320.0), (6, 300.0)))
    supports = tuple(Support(node, ("x", "y", "rz")) for node in (1, 4))
    damping = Damping(modal_ratios=(0.01,))
    return Structure("masts", nodes, elements, masses, supports=supports, damping=damping)


def recorded(structure: Structure, *effects: Effect, step: float = 2e-4) -> Dataset:
    """The ``structure``'s recordings with ``effects``, in its modes that move, with noise.

    The ``step`` (s) is one that the highest mode of all still bears.
    """
    rng = np.random.default_rng(11)
    modal = natural_modes(linearise(structure), MOVING)
    begun = rng.standard_normal((2, COUNT, MOVING))  # modal velocities of 1 m kg^0.5 / s: centimetres at the tops
    shapes = modal.shapes[modal.dofs.free].T
    start = (begun[0] / modal.omega) @ shapes, begun[1] @ shapes
    config = FreeConfig(DURATION, RATE, step)
    motion = simulate_free(structure.with_effects(*effects), start[0], start[1], config, progress=False)
    clean = np.stack([motion.shown(s) for s in SENSORS], axis=-1)
    data = clean + NOISE * clean.std(axis=(0, 1)) * rng.standard_normal(clean.shape)
    parts = tuple(Recording(f"r{i}", data[i : i + 1], "train" if i < COUNT - 1 else "test") for i in range(COUNT))
    return Dataset(structure, RATE, SENSORS, parts, assumptions=Assumptions())
