"""Frames as users bring them, and recordings of their free vibrations."""

from dataclasses import replace

import numpy as np

from fe_models.assembly import linearise
from fe_models.modes import natural_modes
from fe_models.recordings import Dataset, Recording, Sensor
from fe_models.sections import round_wire, square_tube
from fe_models.simulation import FreeConfig, simulate_free
from fe_models.structure import Beam, Cable, Damping, PointMass, Structure, Support
from tests.masts import TUBE, masts


def portal() -> Structure:
    """Two storeys on pins: nodes 1-3 and 4-6 from the ground up, a beam on top."""
    sides = masts(apart=3.0)
    supports = tuple(Support(node, ("x", "y")) for node in (1, 4))
    return replace(sides, name="portal", elements=(*sides.elements, Beam((3, 6), TUBE)), supports=supports)


def beam() -> Structure:
    """Six elements on two supports, each mode with a damping ratio of its own."""
    return Structure(
        "beam",
        tuple((2.0 * i, 0.0) for i in range(7)),
        tuple(Beam((i, i + 1), TUBE) for i in range(1, 7)),
        supports=(Support(1, ("x", "y")), Support(7, ("y",))),
        damping=Damping(modal_ratios=(0.016, 0.009, 0.012)),
    )


def gable() -> Structure:
    """A hall's frame on pins: columns 1-3 and 7-5, rafters over node 4, a tie between the eaves."""
    nodes = ((0.0, 0.0), (0.0, 2.5), (0.0, 5.0), (5.0, 6.5), (10.0, 5.0), (10.0, 2.5), (10.0, 0.0))
    columns, rafters = (
        square_tube(name, 2.1e11, 7850.0, *size) for name, size in (("c", (0.2, 8e-3)), ("r", (0.16, 6e-3)))
    )
    beams = [Beam(pair, columns, "columns") for pair in ((1, 2), (2, 3), (7, 6), (6, 5))]
    beams += [Beam(pair, rafters, "rafters") for pair in ((3, 4), (4, 5))]
    tie = Cable((3, 5), round_wire("tie", youngs_modulus=2.1e11, density=7850.0, diameter=0.02), 8e3)
    masses = tuple(PointMass(node, 500.0) for node in (3, 4, 5))
    supports = tuple(Support(node, ("x", "y")) for node in (1, 7))
    return Structure("gable", nodes, (*beams, tie), masses, supports=supports, damping=Damping(modal_ratios=(0.012,)))


def vibrations(model: Structure, truth: Structure, sensors: tuple[Sensor, ...], count: int) -> Dataset:
    """Four of ``truth`` in its first ``count`` modes, of centimetres, with 3 % noise; the last is for testing."""
    rng, modal = np.random.default_rng(1), natural_modes(linearise(truth), count)
    shapes = modal.shapes[modal.dofs.free].T
    size = 0.01 / np.abs(shapes).max(axis=1) * modal.omega[0] / modal.omega
    begun = rng.standard_normal((2, 4, count)) * size
    start = begun[0] @ shapes, (begun[1] * modal.omega) @ shapes
    motion = simulate_free(truth, *start, FreeConfig(5.0, 100.0, 1e-4), progress=False)
    clean = np.stack([motion.shown(s) for s in sensors], axis=-1)
    data = clean + 0.03 * clean.std(axis=(0, 1)) * rng.standard_normal(clean.shape)
    recordings = tuple(Recording(f"r{i}", part[None], "test" if i == 3 else "train") for i, part in enumerate(data))
    return Dataset(model, 100.0, sensors, recordings)
