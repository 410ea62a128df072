"""The score test: how much of the residual each candidate's first-order response explains.

Everything that initial states and the uncertain factors can do is projected out of both first.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import expm
from scipy.signal import lfilter

from fe_models.dofs import FloatArray
from hybrid.diagnosis.candidates import Candidate
from hybrid.diagnosis.fitting import Fit, Frame, Linearisation, linearise_batch
from hybrid.diagnosis.hypothesis import Hypothesis, Reduced, force_of
from hybrid.diagnosis.records import Batch
from hybrid.diagnosis.system import ModalForm, System, march, modal_form, respond

FREQUENCIES_A_LINE = 2  # trial frequencies of a harmonic force within the resolution of a recording
SOFT = 1e-8  # of the highest eigenvalue: springs that hold a body that moves freely
PEAKS = 2  # frequencies kept at each place


@dataclass(frozen=True)
class Screened:
    """A ``candidate``, parameters to ``start`` from, and the fall in the sum of squares that it promises (``gain``).

    ``shift`` (parameter,): how far the parameters of the fit that it is held against should move with it.
    """

    candidate: Candidate
    start: tuple[float, ...]
    gain: float
    shift: FloatArray

    def theta(self, fit: Fit) -> FloatArray:
        """Return where the fit with this candidate begins, on top of ``fit``."""
        return np.append(fit.theta + self.shift, self.start)


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
        shown.append(_response(fit.hypothesis, fit.theta[None], batch, frame, states)[0])
    J = np.concatenate([part.slopes.reshape(len(fit.theta), -1) for part in parts], axis=1)
    r = np.concatenate([part.residual.ravel() for part in parts])
    width = fit.hypothesis.width
    gradient = J @ r - (fit.theta - fit.hypothesis.centre) / width**2
    inverse = np.linalg.inv(J @ J.T + np.diag(1 / width**2))
    return _Ground(fit, frame, tuple(parts), tuple(shown), inverse, gradient)


def _effect(
    fit: Fit,
    candidate: Candidate,
    start: tuple[float, ...],
    batch: Batch,
    frame: Frame,
    states: FloatArray,
    shown: FloatArray,
) -> FloatArray:
    """Return what a candidate at ``start`` adds to the channels (recording, value) ``shown``, in units of sigma.

    Both are taken in the shapes that the candidate asks for: these move a calibrated structure a little by themselves.
    """
    extended = fit.hypothesis.adding(candidate)
    if not candidate.is_law:
        n, more = fit.hypothesis.size, extended.size - fit.hypothesis.size  # a released support brings a coordinate
        states = np.insert(states, [n] * more + [2 * n] * more, 0.0, axis=1)
        states = np.pad(states, ((0, 0), (0, extended.states - states.shape[1])))
    theta = np.append(fit.theta, start)
    if candidate.changes is None:
        return _response(extended, theta[None], batch, frame, states)[0] - shown
    with_it, without = _response(
        extended, np.stack([theta, np.append(fit.theta, candidate.without)]), batch, frame, states
    )
    return np.asarray(with_it - without)


def _response(hypothesis: Hypothesis, thetas: FloatArray, batch: Batch, frame: Frame, states: FloatArray) -> FloatArray:
    """Return the channels (variant, recording, value) in units of sigma."""
    system = hypothesis.system(thetas, frame.sensors, frame.rate, frame.positions)
    y = respond(system, np.broadcast_to(states, (len(thetas), *states.shape)), batch.samples) / frame.sigma
    return np.asarray(y.reshape(len(thetas), len(states), -1))


def law_responses(fit: Fit, laws: list[Candidate], frame: Frame) -> dict[str, list[list[FloatArray]]]:
    """Return what each law at each of its starts adds, to first order: by its key, start and batch (recording, value).

    Its force along the present motion, at samples and between them, drives each mode of the linear system (Simpson's
    rule).
    """
    found: dict[str, list[list[FloatArray]]] = {law.key: [[] for _ in law.first_starts] for law in laws}
    trials = [(law, number, start) for law in laws for number, start in enumerate(law.first_starts)]
    if not trials:
        return found
    system = fit.hypothesis.system(fit.theta[None], frame.sensors, frame.rate, frame.positions)
    form = modal_form(replace(system, forces=())) or modal_form(_held(system, fit.hypothesis.size))
    assert form is not None  # a body that moves freely is held now
    reduced = fit.hypothesis.reduced(fit.theta[None])
    for batch, states in zip(fit.batches, fit.states, strict=True):
        motions = _motions(system, states, batch.samples)
        for law, number, start in trials:
            y = _law_response(fit, law, start, motions, system, form, reduced, frame)
            found[law.key][number].append((y / frame.sigma).reshape(len(states), -1))
    return found


def _motions(system: System, states: FloatArray, samples: int) -> tuple[FloatArray, FloatArray]:
    """Return the states (time, recording, state) at samples and half a step after each."""
    half = expm(system.A[0] * system.step / 2)
    if system.is_linear:
        seen = np.empty((samples, *states.shape))
        seen[0], whole = states, half @ half
        for k in range(samples - 1):
            seen[k + 1] = seen[k] @ whole.T
    else:
        marched = march(system, states[None], samples)
        assert marched is not None  # it was fitted
        seen = marched[0][:, 0]
    return seen, seen @ half.T


def _law_response(
    fit: Fit,
    law: Candidate,
    start: tuple[float, ...],
    motions: tuple[FloatArray, FloatArray],
    system: System,
    form: ModalForm,
    reduced: Reduced,
    frame: Frame,
) -> FloatArray:
    """Return the channels (recording, time, sensor) that the force of one law along the ``motions`` adds."""
    hypothesis, theta = fit.hypothesis, fit.theta[None]
    n = hypothesis.size
    assert law.pull is not None  # as of every law
    pull = law.pull @ reduced.shapes[0]
    force_at = force_of(law, hypothesis.plant, np.array([start]), np.exp(theta[:, : len(hypothesis.plant.parts)]))
    force, between = (-force_at(motion[..., :n] @ pull, motion[..., n : 2 * n] @ pull) for motion in motions)
    feed = np.linalg.solve(reduced.mass[0], pull)
    moved = form.left[0][:, n : 2 * n] @ feed  # (mode,)
    count, recordings = force.shape
    x = np.zeros((len(moved), count, recordings), dtype=complex)
    for mode, root in enumerate(form.roots[0]):
        whole, half = np.exp(root * system.step), np.exp(root * system.step / 2)
        kick = whole * force[:-1] + 4 * half * between[:-1] + force[1:]
        x[mode, 1:] = lfilter([system.step / 6 * moved[mode]], [1.0, -whole], kick, axis=0)
    right = form.right[0]
    flat = x.reshape(len(moved), -1)
    y = (np.hstack([right.real, -right.imag]) @ np.vstack([flat.real, flat.imag])).reshape(-1, count, recordings)
    accelerations = np.array([sensor.quantity == "acceleration" for sensor in frame.sensors])
    picked = hypothesis.plant.rows(frame.sensors) @ reduced.shapes[0] @ feed
    direct = np.where(accelerations, picked, 0.0) * system.gain[0]
    return np.asarray(y.transpose(2, 1, 0) + direct * force.T[..., None])


def _held(system: System, n: int) -> System:
    """Return the system with soft springs on every coordinate, which part roots that fall together."""
    A = system.A.copy()
    A[:, range(n, 2 * n), range(n)] -= SOFT * np.abs(np.linalg.eigvals(A)).max() ** 2
    return replace(system, A=A, forces=())


def _score(
    ground: _Ground, candidate: Candidate, start: tuple[float, ...], forced: list[FloatArray] | None = None
) -> Screened:
    """Return the score of one candidate; ``forced``: its response in each batch where that is known already."""
    fit, frame = ground.fit, ground.frame
    move = start[0] - candidate.without[0] if candidate.names and candidate.scalable else 1.0
    along, size, still = 0.0, 0.0, np.zeros(len(fit.theta))
    cross = np.zeros(len(fit.theta))
    for number, (part, shown, batch, states) in enumerate(
        zip(ground.parts, ground.shown, fit.batches, fit.states, strict=True)
    ):
        if forced is not None:
            column = forced[number] / move
        else:
            column = _effect(fit, candidate, start, batch, frame, states, shown) / move  # (recording, value)
        if not np.isfinite(column).all():
            return Screened(candidate, start, 0.0, still)
        column = _project(column, part.basis)
        along += float(np.sum(column * part.residual))
        size += float(np.sum(column**2))
        cross += np.einsum("prv,rv->p", part.slopes, column)
    projected = cross @ ground.inverse
    size_left = size - float(projected @ cross)
    along -= float(projected @ ground.gradient)
    if size_left <= 1e-9 * size or size == 0:
        return Screened(candidate, start, 0.0, still)
    value: float = along / size_left
    gain, shift = along * value, still
    if candidate.names and candidate.scalable:
        found = max(candidate.neutral[0] + value, candidate.lower[0])
        if found == candidate.lower[0] == candidate.neutral[0]:
            gain = 0.0  # it would have to push the other way
        start, shift = (found, *start[1:]), -projected * (found - candidate.neutral[0])
    elif value < 0:
        gain = 0.0
    return Screened(candidate, start, float(gain), shift)


def amounts_by_recording(fit: Fit, candidates: list[Candidate], frame: Frame) -> list[tuple[FloatArray, FloatArray]]:
    """Return, for each candidate, how much of it each recording asks for, (recording,), and the fall in its sum of
    squares.

    The uncertain factors are kept as they are: what they do is common to all recordings.
    """
    ground = _ground(fit, frame)
    found = []
    for candidate in candidates:
        start = candidate.first_starts[0]
        move = start[0] - candidate.without[0]
        amounts, gains = [], []
        for part, shown, batch, states in zip(ground.parts, ground.shown, fit.batches, fit.states, strict=True):
            column = _project(_effect(fit, candidate, start, batch, frame, states, shown) / move, part.basis)
            along = np.sum((column * part.residual).reshape(len(batch.names), -1), axis=1)
            size = np.sum((column**2).reshape(len(batch.names), -1), axis=1) + 1e-300
            amounts.append(along / size)
            gains.append(along**2 / size)
        found.append((np.concatenate(amounts), np.concatenate(gains)))
    return found


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
    n, states = hypothesis.size, hypothesis.states
    reduced = hypothesis.reduced(fit.theta[None])
    inverse = np.linalg.inv(reduced.mass)
    accelerations = np.array([sensor.quantity == "acceleration" for sensor in frame.sensors])
    longest = max(batch.samples for batch in fit.batches)
    trials = np.arange(1, longest * FREQUENCIES_A_LINE // 2) * frame.rate / (longest * FREQUENCIES_A_LINE)
    pulls = [candidate.pull for candidate in forces if candidate.pull is not None]  # of every force
    feed = np.stack([reduced.fed(pull, inverse)[0] for pull in pulls], axis=1)  # (mode, place)
    B = np.zeros((states, len(forces)))
    B[n : 2 * n] = feed
    D = np.where(accelerations[:, None], hypothesis.plant.rows(frame.sensors) @ reduced.shapes[0] @ feed, 0.0)
    omega = 2j * np.pi * trials[:, None, None]
    pushed = np.broadcast_to(B, (len(trials), *B.shape))
    transfer = system.C[0] @ np.linalg.solve(omega * np.eye(states) - system.A[0], pushed) + D
    transfer = transfer * (system.gain[0] / frame.sigma)[:, None]  # (frequency, sensor, place)
    gains = np.zeros((len(trials), len(forces)))
    for part, batch in zip(_ground(fit, frame).parts, fit.batches, strict=True):
        gains += _wave_gains(part, batch.samples, transfer, trials / frame.rate)
    found = []
    for place, candidate in enumerate(forces):
        curve = gains[:, place].copy()
        for _ in range(PEAKS):
            peak = int(np.argmax(curve))
            still = np.zeros(len(fit.theta))
            found.append(Screened(candidate, (float(trials[peak]),), float(curve[peak]), still))
            curve[max(0, peak - 2 * FREQUENCIES_A_LINE) : peak + 2 * FREQUENCIES_A_LINE + 1] = 0.0
    return sorted(found, key=lambda trial: -trial.gain)


def _wave_gains(part: Linearisation, samples: int, transfer: FloatArray, frequencies: FloatArray) -> FloatArray:
    """Return the fall in the sum of squares (frequency, place) by waves of any amplitude and phase in each recording.

    ``transfer`` (frequency, sensor, place) is what the sensors show of a unit force; ``frequencies`` in cycles a
    sample. All products with the waves are Fourier transforms, of the residual and of what was projected out.
    """
    sensors = transfer.shape[1]
    basis = part.basis[0] if part.basis.ndim == 3 else part.basis  # with laws, one recording's stands for all
    turns = np.exp(2j * np.pi * np.outer(frequencies, np.arange(samples)))  # (frequency, time)
    along = turns @ part.residual.reshape(-1, samples, sensors).transpose(1, 0, 2).reshape(samples, -1)
    inside = turns @ basis.reshape(samples, -1)
    along = along.reshape(len(turns), -1, sensors) @ transfer  # (frequency, recording, place)
    inside = inside.reshape(len(turns), sensors, -1).transpose(0, 2, 1) @ transfer  # (frequency, state, place)
    size = samples * np.sum(np.abs(transfer) ** 2, axis=1) - np.sum(np.abs(inside) ** 2, axis=1)
    double = np.sum(turns**2, axis=1)[:, None] * np.sum(transfer**2, axis=1) - np.sum(inside**2, axis=1)
    a, b, c = (size + double.real) / 2, (size - double.real) / 2, double.imag / 2  # of real and imaginary waves
    ridge = 1e-9 * (a + b)
    a, b = a + ridge, b + ridge
    u, v = along.real, along.imag
    fall = u**2 * b[:, None] - 2 * u * v * c[:, None] + v**2 * a[:, None]
    return np.asarray(np.sum(fall, axis=1) / (a * b - c**2))
