"""Harmonic forces on a column with one sensor, which cannot tell its nodes apart."""

import numpy as np

from fe_models.assembly import linearise
from fe_models.causes.candidate import HarmonicCandidate
from fe_models.modes import natural_modes
from fe_models.recordings import Dataset, Recording, Sensor
from fe_models.structure import Beam, Damping, PointMass, Structure, Support
from hybrid.diagnosis.contest.config import HARMONIC_SEARCH
from hybrid.diagnosis.contest.growing import reference_fits_of
from hybrid.diagnosis.contest.search import contest
from hybrid.diagnosis.contest.setting import setting_of
from tests.masts import TUBE

STOREYS = 14
RATIO = 0.01
RATE, SAMPLES, COUNT, MODES = 100.0, 1000, 2, 3
AMPLITUDE, TURN = 30.0, 2 * np.pi * 1.9  # N, rad/s
PUSHED = 9


def column() -> Structure:
    """Nodes from the top, 4 m high, down to the ground; the first is heavy."""
    nodes = tuple((0.0, y) for y in np.linspace(4.0, 0.0, STOREYS + 1).tolist())
    beams = tuple(Beam((i, i + 1), TUBE) for i in range(1, STOREYS + 1))
    supports = (Support(STOREYS + 1, ("x", "y", "rz")),)
    damping = Damping(modal_ratios=(RATIO,))
    return Structure("column", nodes, beams, (PointMass(1, 400.0),), supports=supports, damping=damping)


def pushed() -> Dataset:
    """Accelerations of the top in closed form: free motion, the steady state of a force at one node, noise."""
    rng = np.random.default_rng(3)
    modal = natural_modes(linearise(column()), MODES)
    top, place = (modal.shapes[modal.dofs.row(node, "x")] for node in (1, PUSHED))
    t = np.arange(SAMPLES) / RATE
    roots = modal.omega * (-RATIO + 1j * np.sqrt(1 - RATIO**2))
    begun = rng.standard_normal((COUNT, MODES, 2)) @ [1, 1j] / modal.omega**2
    free = (begun * roots**2 * top) @ np.exp(np.outer(roots, t))
    steady = AMPLITUDE * place * top / (modal.omega**2 - TURN**2 + 2j * RATIO * modal.omega * TURN)
    turns = np.exp(1j * (TURN * t + rng.uniform(0, 2 * np.pi, (COUNT, 1))))
    clean = (free - TURN**2 * steady.sum() * turns).real
    data = (clean + 0.03 * clean.std() * rng.standard_normal(clean.shape))[..., None]
    recordings = tuple(Recording(f"r{i}", data[i : i + 1]) for i in range(COUNT))
    return Dataset(column(), RATE, (Sensor("top", 1, "x", "acceleration", "m/s^2"),), recordings)


def test_harmonic_forces_at_all_nodes_that_promise_alike_are_fitted() -> None:
    setting = setting_of(pushed())
    ground = reference_fits_of(
        setting.nominal_hypothesis,
        setting.nominal_hypothesis.centre,
        setting.lengths,
        setting.noise_model,
        setting.short,
    )
    assert ground is not None
    forces = tuple(c for c in setting.candidates() if isinstance(c, HarmonicCandidate))
    assert len(forces) > HARMONIC_SEARCH.neighbours
    found = contest(ground, forces, setting.lengths, setting.noise_model)
    assert {item.hypothesis.candidates[0].key for item in found} == {candidate.key for candidate in forces}
