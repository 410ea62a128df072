"""The state space of a hypothesis: how each parameter vector moves, and what its sensors show of that."""

from dataclasses import replace
from typing import Any

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes import TimeIntegration
from fe_models.causes.candidate import HarmonicCandidate, LawCandidate, LoadCandidate, SensorCandidate, StepCandidate
from fe_models.recordings import Sensor, of_each_quantity
from hybrid.diagnosis.recorded.sensor_outputs import SensorOutputs
from hybrid.diagnosis.response.dashpots import with_trailing
from hybrid.diagnosis.response.forces import force_of
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.load_input import feedthrough, load_input_of
from hybrid.diagnosis.response.reduced_model import ReducedModel
from hybrid.diagnosis.response.system import Force, LoadInput, ResidualFlexibility, System

FAULTS = "gain", "delay", "drift"
LEAST_GAIN = 1e-3  # of a load: a thousand times as much acts as was recorded


def system_of(hypothesis: Hypothesis, theta: FloatArray, outputs: SensorOutputs, first_order: bool = False) -> System:
    """Return the systems of ``theta`` (variant, parameter), as ``outputs`` shows them.

    ``first_order``: whether variants are a Jacobian's, so that they follow from the first one to first order.
    """
    nominal, n, variants = hypothesis.nominal, hypothesis.size, len(theta)
    reduced = hypothesis.reduced(theta, first_order)
    laws, harmonics = _laws(hypothesis, theta), _harmonic_forces(hypothesis, theta)
    inverse = np.linalg.inv(reduced.mass)
    A = np.zeros((variants, hypothesis.states, hypothesis.states))
    A[:, :n, n : 2 * n] = np.eye(n)
    A[:, n : 2 * n, : 2 * n] = -inverse @ np.concatenate([reduced.stiffness, reduced.damping], axis=2)
    steps = None if any(isinstance(c, StepCandidate) for c in hypothesis.candidates) else nominal.integration
    for number, (pull, _, frequency) in enumerate(harmonics):
        first, omega = 2 * n + 2 * number, 2 * np.pi * frequency
        omega = omega if steps is None else steps.shown_as(omega)  # a force keeps its frequency
        A[:, n : 2 * n, first] = reduced.fed(pull, inverse)
        A[:, first, first + 1], A[:, first + 1, first] = omega, -omega
    trailing = reduced.trailing
    if trailing is not None:
        A, trails = with_trailing(A, trailing)
    exact = A
    if steps is not None:
        A = _stepped(A, steps)
    B, G = np.zeros((variants, hypothesis.states, len(laws))), np.zeros((variants, 2 * len(laws), hypothesis.states))
    B[:, n : 2 * n] = feed = reduced.feed([pull for pull, _ in laws], inverse)
    for number, (pull, _) in enumerate(laws):
        G[:, number, :n] = G[:, len(laws) + number, n : 2 * n] = pull @ reduced.shapes
    rows = nominal.rows(outputs.sensors)
    picked = rows @ reduced.shapes  # (variant, sensor, mode)
    seen = np.zeros((variants, len(outputs.sensors), hypothesis.states))
    kinds = of_each_quantity(outputs.sensors)
    displaced, moved, pushed = kinds
    seen[:, displaced, :n] = picked[:, displaced]
    seen[:, moved, n : 2 * n] = picked[:, moved]
    seen[:, pushed] = picked[:, pushed] @ exact[:, n : 2 * n]
    if trailing is not None:
        seen += trailing.shown(trails, exact, rows, kinds)
    for number, (_, bent, frequency) in enumerate(harmonics):
        first, omega = 2 * n + 2 * number, 2 * np.pi * frequency[:, None]
        shown = rows @ bent  # (sensor,)
        seen[:, displaced, first] += shown[displaced]
        seen[:, moved, first + 1] += omega * shown[moved]
        seen[:, pushed, first] -= omega**2 * shown[pushed]
    direct = feedthrough(picked, feed, outputs.sensors)
    forces = tuple(force for _, force in laws)
    gain, delay, slope = _faults(hypothesis, theta, outputs.positions)
    loads = _loads(hypothesis, theta, reduced, inverse, outputs.sensors, [pull for pull, _ in laws])
    lowpass = nominal.lowpass if loads is None else None  # known loads have passed it before they act
    residual, step, flexibility = hypothesis.residual, 1 / outputs.rate, None
    if residual is not None:
        flexibility = ResidualFlexibility(residual, kinds[..., None] * (rows @ residual.shapes))
    return System(A, B, seen, direct, G, forces, gain, delay, slope, step, flexibility, loads, lowpass)


def _loads(
    hypothesis: Hypothesis,
    theta: FloatArray,
    reduced: ReducedModel,
    inverse: Any,
    sensors: tuple[Sensor, ...],
    laws: list[FloatArray],
) -> LoadInput | None:
    """Return how known loads enter, beside ``laws`` with their pulls (dof,); None where there are none."""
    nominal = hypothesis.nominal
    if not nominal.loaded:
        return None
    pulls, bent = nominal.load_pulls, nominal.load_shapes
    beside = np.array(laws).reshape(len(laws), pulls.shape[1])
    entry = load_input_of(nominal.loaded, pulls, bent, beside, reduced, inverse, nominal, sensors)
    faults = {"gain": entry.gain.copy(), "delay": entry.delay.copy()}
    for candidate, part in hypothesis.each(LoadCandidate):
        own = faults[candidate.quantity][:, list(candidate.loads)]
        own = own * theta[:, part] if candidate.quantity == "gain" else own + theta[:, part]
        faults[candidate.quantity][:, list(candidate.loads)] = own
    return replace(entry, gain=_away_from_zero(faults["gain"]), delay=faults["delay"])


def _away_from_zero(gain: FloatArray) -> FloatArray:
    """Return gains that can be divided by: a search may pass zero on its way to another sign."""
    return np.where(np.abs(gain) < LEAST_GAIN, np.copysign(LEAST_GAIN, gain), gain)


def _laws(hypothesis: Hypothesis, theta: FloatArray) -> list[tuple[FloatArray, Force]]:
    """Return pull (dof,) and force of each law: the nominal model's, then the candidates'."""
    nominal, stiffnesses = hypothesis.nominal, np.exp(theta[:, : len(hypothesis.nominal.parts)])
    found: list[tuple[FloatArray, Force]] = [(nominal.pull(law), law.force) for law in nominal.laws]
    for candidate, part in hypothesis.each(LawCandidate):
        found.append((candidate.pull, force_of(candidate, nominal, theta[:, part], stiffnesses)))
    return found


def _harmonic_forces(hypothesis: Hypothesis, theta: FloatArray) -> list[tuple[FloatArray, FloatArray, FloatArray]]:
    """Return pull (dof,), what it bends besides (dof,) and frequency (variant,), Hz, of each harmonic force."""
    return [
        (candidate.pull, shape, theta[:, part.start])
        for candidate, part, shape in zip(hypothesis.candidates, hypothesis.slices, hypothesis.left_out, strict=True)
        if isinstance(candidate, HarmonicCandidate)
    ]


def _faults(hypothesis: Hypothesis, theta: FloatArray, positions: tuple[int, ...]) -> FloatArray:
    """Return gain, delay (s) and slope (1/s) of sensors, (3, variant, sensor); ``positions``: of `SensorOutputs`."""
    faults = np.zeros((3, len(theta), len(positions)))
    faults[0] = 1.0
    for candidate, part in hypothesis.each(SensorCandidate):
        own = [i for i, position in enumerate(positions) if position == candidate.sensor]
        faults[FAULTS.index(candidate.quantity)][:, own] = theta[:, part]
    return faults


def _stepped(A: FloatArray, integration: TimeIntegration) -> FloatArray:
    """Return A (variant, state, state) of the system that the user's own time steps show instead."""
    roots, vectors = np.linalg.eig(A)
    shown = integration.shown_root(roots)
    return np.asarray(np.real((vectors * shown[:, None]) @ np.linalg.inv(vectors)))
