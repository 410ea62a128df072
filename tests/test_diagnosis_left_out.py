"""Harmonic forces on frames: what they bend in modes that are not followed, and how large they are."""

from functools import cache

import numpy as np
import pytest

from benchmarks.blind_cases.bridge import SENSORS
from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.built_in.bridge import bridge
from fe_models.causes import HarmonicForce
from fe_models.causes.candidate import Candidate
from fe_models.causes.places import Motion
from fe_models.recordings import Assumptions, Dataset, Recording
from hybrid.diagnosis.fitting.linearisation import linearise_batch
from hybrid.diagnosis.nominal.candidates import all_candidates
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.diagnosis.recorded.batches import Batch
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.recorded.sensor_outputs import SensorOutputs
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.marching import respond
from hybrid.diagnosis.response.state_space import system_of

RATE, SAMPLES, MOVING = 100.0, 100, 10
FITTED = tuple(sensor for sensor in SENSORS if sensor.role == "measured")
EVERY = tuple(range(len(FITTED)))
OUTPUTS = SensorOutputs(FITTED, RATE, EVERY)


@cache
def model_with(modes: int | None) -> NominalModel:
    recording = Recording("r", np.ones((1, SAMPLES, len(FITTED))))
    return nominal_model_of(Dataset(bridge(), RATE, FITTED, (recording,), 30.0, Assumptions(modes=modes)))


@cache
def candidates(modes: int | None = None) -> tuple[Candidate, ...]:
    nominal = model_with(modes)
    data = np.random.default_rng(1).standard_normal((1, SAMPLES, len(FITTED)))
    dataset = Dataset(bridge(), RATE, FITTED, (Recording("r", data),), 30.0)
    q = np.random.default_rng(2).standard_normal((2, 10, MOVING)) / [[nominal.modes[0][:MOVING]], [np.ones(MOVING)]]
    shapes = nominal.modes[1][:, :MOVING]
    return all_candidates(nominal, dataset, Motion(q[0] @ shapes.T, q[1] @ shapes.T), EVERY)


def chosen(kind: str, modes: int | None = None, **location: object) -> Candidate:
    (found,) = (c for c in candidates(modes) if c.kind == kind and c.location == location)
    return found


@pytest.mark.parametrize(("frequency", "left"), [(6.0, 0.05), (11.0, 0.25)])  # (f / 30 Hz)^2, and a margin
def test_steady_motion_under_a_harmonic_force_is_that_of_the_whole_bridge(frequency: float, left: float) -> None:
    nominal, omega = model_with(None), 2 * np.pi * frequency
    whole = linearise(bridge())
    dynamic = whole.stiffness - omega**2 * whole.mass + 1j * omega * whole.damping
    load = np.zeros(len(nominal.dofs))
    load[nominal.dofs.row(8, "y")] = 1.0
    moved = np.zeros(len(nominal.dofs), dtype=complex)
    moved[nominal.dofs.free] = np.linalg.solve(dynamic.toarray(), load[nominal.dofs.free])
    expected = -(omega**2) * nominal.rows(FITTED) @ moved

    def shown(hypothesis: Hypothesis) -> FloatArray:
        """Accelerations (sensor,), complex, of the steady motion: the system's mode at the force's own frequency."""
        theta = np.append(np.zeros(hypothesis.nuisances), frequency)[None]
        system = system_of(hypothesis, theta, OUTPUTS)
        A, n = system.A[0], 2 * hypothesis.size
        force = np.array([1.0, 1j])
        motion = np.linalg.solve(1j * omega * np.eye(n) - A[:n, :n], A[:n, n:] @ force)
        return np.asarray(system.C[0] @ np.concatenate([motion, force]))

    force = chosen(HarmonicForce.kind, node=8, direction="y")
    felt, cut = Hypothesis(nominal, (force,)), Hypothesis(nominal, (force,))
    vars(cut)["left_out"] = [np.zeros(len(nominal.dofs))]  # what is bent besides is forgotten
    error, without = (np.abs(shown(h) - expected).max() for h in (felt, cut))
    assert error < left * without
    assert error < 0.01 * np.abs(expected).max()


def test_slow_force_is_as_large_as_it_was_beside_the_displacements_of_high_modes() -> None:
    nominal, samples = model_with(None), 5 * SAMPLES
    hypothesis = Hypothesis(nominal, (chosen(HarmonicForce.kind, node=47, direction="x"),))
    theta = np.append(np.zeros(hypothesis.nuisances), 1.1)  # Hz, below all modes
    states = np.zeros((1, hypothesis.states))
    states[0, hypothesis.size : -2] = 0.01  # m kg^0.5 / s
    states[0, -2:] = 0.8, -0.6  # N: 1 N moves what is felt a million times less than 1 m kg^0.5 of the highest mode
    data = respond(system_of(hypothesis, theta[None], OUTPUTS), states[None], samples)[0]
    batch = Batch(data, ("r",))
    part = linearise_batch(hypothesis, theta, batch, NoiseModel(FITTED, RATE, np.ones(len(FITTED))), None)
    assert part is not None
    assert part.states[0, -2:] == pytest.approx(states[0, -2:], rel=1e-3)  # the ridge takes less of all that is felt
