"""The score test: how much of the residual each candidate's first-order response explains.

Everything that initial states and the uncertain factors can do is projected out of both first.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from fe_models.dofs import FloatArray
from hybrid.diagnosis.candidates import Candidate
from hybrid.diagnosis.fitting import Fit, Frame, Linearisation, linearise_batch
from hybrid.diagnosis.hypothesis import Hypothesis, force_of
from hybrid.diagnosis.records import Batch
from hybrid.diagnosis.system import march, respond

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
    forced = law_responses(fit, [candidate for candidate in candidates if candidate.is_law], frame)
    found = []
    for candidate in candidates:
        if not candidate.oscillator:
            trials = []
            for number, start in enumerate(candidate.first_starts):
                known = forced[candidate.key][number] if candidate.is_law else None
                trials.append(_score(ground, candidate, start, known))
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


def _response(hypothesis: Hypothesis, theta: FloatArray, batch: Batch, frame: Frame, states: FloatArray) -> FloatArray:
    """Return the channels (recording, value) in units of sigma."""
    system = hypothesis.system(theta[None], frame.sensors, frame.rate, frame.positions)
    y = respond(system, states[None], batch.samples)[0] / frame.sigma
    return np.asarray(y.reshape(len(states), -1))


def law_responses(fit: Fit, laws: list[Candidate], frame: Frame) -> dict[str, list[list[FloatArray]]]:
    """Return what each law at each of its starts adds, to first order: by its key, start and batch (recording, value).

    Its force along the present motion, at samples and between them, drives the linear system (Simpson's rule).
    """
    found: dict[str, list[list[FloatArray]]] = {law.key: [[] for _ in law.first_starts] for law in laws}
    hypothesis = fit.hypothesis
    theta = fit.theta[None]
    system = hypothesis.system(theta, frame.sensors, frame.rate, frame.positions)
    springs = np.exp(theta[:, : len(hypothesis.plant.springs)])
    n, step = hypothesis.plant.size, system.step
    half = expm(system.A[0] * step / 2)
    whole = half @ half
    inverse = np.linalg.inv(hypothesis.plant.mass)
    trials = [(law, number, start) for law in laws for number, start in enumerate(law.first_starts)]
    pulls = np.array([law.pull for law, _, _ in trials]).reshape(-1, n)
    feed = np.zeros((len(trials), hypothesis.states))
    feed[:, n : 2 * n] = pulls @ inverse
    at_rows = [
        list(hypothesis.plant.dofs.free_rows).index(hypothesis.plant.dofs.row(s.node, s.direction))
        for s in frame.sensors
    ]
    direct = np.where([s.quantity == "acceleration" for s in frame.sensors], feed[:, n : 2 * n][:, at_rows], 0.0)
    for batch, states in zip(fit.batches, fit.states, strict=True):
        if system.is_linear:
            seen = np.stack([states @ power.T for power in _powers(whole, batch.samples)])
        else:
            marched = march(system, states[None], batch.samples)
            assert marched is not None  # it was fitted
            seen = marched[0][:, 0]
        between = seen @ half.T
        force, force_between = np.empty((2, len(trials), batch.samples, len(states)))
        for row, (law, _, start) in enumerate(trials):
            f = force_of(law, hypothesis.plant, np.array([start]), springs)
            for motion, target in ((seen, force), (between, force_between)):
                u, v = motion[..., :n] @ pulls[row], motion[..., n : 2 * n] @ pulls[row]
                target[row] = -f(u, v)
        z = np.zeros((len(trials), len(states), hypothesis.states))
        out = np.empty((batch.samples, len(trials), len(states), len(frame.sensors)))
        start_part, middle, end = (
            (step / 6 * w) * feed @ E.T for w, E in ((1, whole), (4, half), (1, np.eye(len(whole))))
        )
        C = (system.C[0] * system.gain[0][:, None]).T
        for k in range(batch.samples):
            out[k] = z @ C + force[:, k, :, None] * (direct * system.gain[0])[:, None]
            if k + 1 < batch.samples:
                z = z @ whole.T + force[:, k, :, None] * start_part[:, None]
                z += force_between[:, k, :, None] * middle[:, None] + force[:, k + 1, :, None] * end[:, None]
        out /= frame.sigma
        for row, (law, number, _) in enumerate(trials):
            found[law.key][number].append(np.ascontiguousarray(out[:, row].transpose(1, 0, 2)).reshape(len(states), -1))
    return found


def _powers(matrix: FloatArray, count: int) -> list[FloatArray]:
    powers = [np.eye(len(matrix))]
    for _ in range(count - 1):
        powers.append(powers[-1] @ matrix)
    return powers


def _score(
    ground: _Ground, candidate: Candidate, start: tuple[float, ...], forced: list[FloatArray] | None = None
) -> Screened:
    """Return the score of one candidate; ``forced``: its response in each batch where that is known already."""
    fit, frame = ground.fit, ground.frame
    extended = fit.hypothesis.adding(candidate)
    theta = np.append(fit.theta, start)
    move = start[0] - candidate.neutral[0] if candidate.names and candidate.scalable else 1.0
    along, size = 0.0, 0.0
    cross = np.zeros(len(fit.theta))
    for number, (part, shown, batch, states) in enumerate(
        zip(ground.parts, ground.shown, fit.batches, fit.states, strict=True)
    ):
        if forced is not None:
            column = forced[number] / move
        else:
            column = (_response(extended, theta, batch, frame, states) - shown) / move  # (recording, value)
        if not np.isfinite(column).all():
            return Screened(candidate, start, 0.0)
        column = _project(column, part.basis)
        along += float(np.sum(column * part.residual))
        size += float(np.sum(column**2))
        cross += np.einsum("prv,rv->p", part.slopes, column)
    projected = cross @ ground.inverse
    size_left = size - float(projected @ cross)
    along -= float(projected @ ground.gradient)
    if size_left <= 1e-9 * size or size == 0:
        return Screened(candidate, start, 0.0)
    value: float = along / size_left
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
    """Return a column (recording, value) less what initial states do; ``basis`` (value, s) or (recording, value, s)."""
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
    at = np.array(
        [
            list(hypothesis.plant.dofs.free_rows).index(hypothesis.plant.dofs.row(s.node, s.direction))
            for s in frame.sensors
        ]
    )
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
            basis = part.basis[0] if part.basis.ndim == 3 else part.basis  # with laws, one recording's stands for all
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
