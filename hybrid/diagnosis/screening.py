"""The score test: how much of the residual each candidate's first-order response explains.

Everything that initial states and the uncertain factors can do is projected out of both first.
"""

from dataclasses import dataclass

import numpy as np

from fe_models.dofs import FloatArray
from hybrid.diagnosis.candidates import Candidate
from hybrid.diagnosis.fitting import Fit, Frame, Linearisation, linearise_batch
from hybrid.diagnosis.hypothesis import Hypothesis
from hybrid.diagnosis.records import Batch
from hybrid.diagnosis.system import respond

FREQUENCIES_A_LINE = 2  # trial frequencies of a harmonic force within the resolution of a recording
PEAKS = 2  # frequencies kept at each place


@dataclass(frozen=True)
class Screened:
    """A ``candidate``, parameters to ``start`` from, and the fall in the sum of squares that it promises (``gain``)."""

    candidate: Candidate
    start: tuple[float, ...]
    gain: float


@dataclass(frozen=True)
class _Ground:
    """The present fit, linearised: what each candidate is held against."""

    fit: Fit
    frame: Frame
    parts: tuple[Linearisation, ...]
    shown: tuple[FloatArray, ...]  # the channels of the fit, in units of sigma
    inverse: FloatArray  # of the normal matrix of the parameters
    gradient: FloatArray


def screen(fit: Fit, candidates: tuple[Candidate, ...], frame: Frame) -> list[Screened]:
    """Return each candidate with its best start, most promising first; harmonic forces apart (`screen_forces`)."""
    ground = _ground(fit, frame)
    found = []
    for candidate in candidates:
        if not candidate.oscillator:
            trials = [_score(ground, candidate, start) for start in candidate.first_starts]
            found.append(max(trials, key=lambda trial: trial.gain))
    return sorted(found, key=lambda trial: -trial.gain)


def _ground(fit: Fit, frame: Frame) -> _Ground:
    parts, shown = [], []
    for batch, states in zip(fit.batches, fit.states, strict=True):
        part = linearise_batch(fit.hypothesis, fit.theta, batch, frame, states)
        assert part is not None  # it was fitted
        parts.append(part)
        shown.append(_response(fit.hypothesis, fit.theta, batch, frame, states))
    J = np.concatenate([part.slopes.reshape(len(fit.theta), -1) for part in parts], axis=1)
    r = np.concatenate([part.residual.ravel() for part in parts])
    width = fit.hypothesis.width
    gradient = J @ r - (fit.theta - fit.hypothesis.centre) / width**2
    inverse = np.linalg.inv(J @ J.T + np.diag(1 / width**2))
    return _Ground(fit, frame, tuple(parts), tuple(shown), inverse, gradient)


def _response(
    hypothesis: Hypothesis, theta: FloatArray, batch: Batch, frame: Frame, states: FloatArray
) -> FloatArray:
    """Return the channels (recording, value) in units of sigma."""
    system = hypothesis.system(theta[None], frame.sensors, frame.rate, frame.positions)
    y = respond(system, states[None], batch.samples)[0] / frame.sigma
    return np.asarray(y.reshape(len(states), -1))


def _score(ground: _Ground, candidate: Candidate, start: tuple[float, ...]) -> Screened:
    fit, frame = ground.fit, ground.frame
    extended = fit.hypothesis.adding(candidate)
    theta = np.append(fit.theta, start)
    move = start[0] - candidate.neutral[0] if candidate.names and candidate.scalable else 1.0
    along, size = 0.0, 0.0
    cross = np.zeros(len(fit.theta))
    for part, shown, batch, states in zip(ground.parts, ground.shown, fit.batches, fit.states, strict=True):
        column = (_response(extended, theta, batch, frame, states) - shown) / move  # (recording, value)
        if not np.isfinite(column).all():
            return Screened(candidate, start, 0.0)
        column = _project(column, part.basis)
        along += float(np.sum(column * part.residual))
        size += float(np.sum(column**2))
        cross += np.einsum("prv,rv->p", part.slopes, column)
    projected = cross @ ground.inverse
    size_left = size - projected @ cross
    along -= float(projected @ ground.gradient)
    if size_left <= 1e-9 * size or size == 0:
        return Screened(candidate, start, 0.0)
    value = along / size_left
    gain = along * value
    if candidate.names and candidate.scalable:
        found = max(candidate.neutral[0] + value, candidate.lower[0])
        if found == candidate.lower[0] == candidate.neutral[0]:
            gain = 0.0  # it would have to push the other way
        start = (found, *start[1:])
    elif value < 0:
        gain = 0.0
    return Screened(candidate, start, float(gain))


def amounts_by_recording(fit: Fit, candidate: Candidate, frame: Frame) -> tuple[FloatArray, FloatArray]:
    """Return how much of a candidate each recording asks for, (recording,), and the fall in its sum of squares.

    The uncertain factors are kept as they are: what they do is common to all recordings.
    """
    extended = fit.hypothesis.adding(candidate)
    start = candidate.first_starts[0]
    theta = np.append(fit.theta, start)
    move = start[0] - candidate.neutral[0]
    amounts, gains = [], []
    for batch, states in zip(fit.batches, fit.states, strict=True):
        part = linearise_batch(fit.hypothesis, fit.theta, batch, frame, states)
        assert part is not None  # it was fitted
        shown = _response(fit.hypothesis, fit.theta, batch, frame, states)
        column = _project((_response(extended, theta, batch, frame, states) - shown) / move, part.basis)
        along = np.sum((column * part.residual).reshape(len(batch.names), -1), axis=1)
        size = np.sum((column**2).reshape(len(batch.names), -1), axis=1) + 1e-300
        amounts.append(along / size)
        gains.append(along**2 / size)
    return np.concatenate(amounts), np.concatenate(gains)


def _project(column: FloatArray, basis: FloatArray) -> FloatArray:
    """Return a column (recording, value) without what initial states can do; basis (value, s) or (recording, value, s)."""
    if basis.ndim == 2:
        return np.asarray(column - (column @ basis) @ basis.T)
    inside = np.einsum("rv,rvs->rs", column, basis)
    return np.asarray(column - np.einsum("rs,rvs->rv", inside, basis))


def screen_forces(fit: Fit, candidates: tuple[Candidate, ...], frame: Frame) -> list[Screened]:
    """Return harmonic forces with their best frequencies, from the steady state that each frequency would bring.

    The transient is one of the initial states' motions, which are projected out. Amplitude and phase are each
    recording's own. The fit should be of whole recordings: segments do not tell frequencies well.
    """
    forces = [candidate for candidate in candidates if candidate.oscillator]
    if not forces:
        return []
    hypothesis = fit.hypothesis
    system = hypothesis.system(fit.theta[None], frame.sensors, frame.rate, frame.positions)
    n, states = hypothesis.plant.size, hypothesis.states
    A, C = system.A[0], system.C[0] * system.gain[0][:, None]
    inverse = np.linalg.inv(hypothesis.plant.mass)
    accelerations = np.array([sensor.quantity == "acceleration" for sensor in frame.sensors])
    at = np.array([list(hypothesis.plant.dofs.free_rows).index(hypothesis.plant.dofs.row(s.node, s.direction))
                   for s in frame.sensors])
    longest = max(batch.samples for batch in fit.batches)
    trials = np.arange(1, longest * FREQUENCIES_A_LINE // 2) * frame.rate / (longest * FREQUENCIES_A_LINE)
    pulls = np.array([candidate.pull for candidate in forces])  # (place, dof)
    B = np.zeros((states, len(forces)))
    B[n : 2 * n] = inverse @ pulls.T
    D = np.where(accelerations[:, None], (inverse @ pulls.T)[at], 0.0) * system.gain[0][:, None]
    gains = np.zeros((len(trials), len(forces)))
    ground = _ground(fit, frame)
    for number, frequency in enumerate(trials):
        omega = 2j * np.pi * frequency
        transfer = C @ np.linalg.solve(omega * np.eye(states) - A, B) + D  # (sensor, place)
        for part, batch in zip(ground.parts, fit.batches, strict=True):
            turn = np.exp(omega * np.arange(batch.samples) / frame.rate)
            wave = turn[:, None, None] * (transfer / frame.sigma[:, None])  # (time, sensor, place)
            columns = np.stack([wave.real, wave.imag]).reshape(2, -1, len(forces)).transpose(2, 0, 1)
            if part.basis.ndim == 3:  # force laws: one recording's basis stands for all
                basis = part.basis[0]
            else:
                basis = part.basis
            columns = columns - (columns @ basis) @ basis.T  # (place, 2, value)
            normal = columns @ columns.transpose(0, 2, 1)
            normal = normal + 1e-9 * np.trace(normal, axis1=1, axis2=2)[:, None, None] * np.eye(2)
            along = columns @ part.residual.T  # (place, 2, recording)
            gains[number] += np.sum(along * np.linalg.solve(normal, along), axis=(1, 2))
    found = []
    for place, candidate in enumerate(forces):
        curve = gains[:, place].copy()
        for _ in range(PEAKS):
            peak = int(np.argmax(curve))
            found.append(Screened(candidate, (float(trials[peak]),), float(curve[peak])))
            curve[max(0, peak - 2 * FREQUENCIES_A_LINE) : peak + 2 * FREQUENCIES_A_LINE + 1] = 0.0
    return sorted(found, key=lambda trial: -trial.gain)
