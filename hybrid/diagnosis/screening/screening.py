"""The score test: how much of the residual each candidate's first-order response explains.

Everything that initial states and the uncertain factors can do is projected out of both first.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from fe_models.arrays import TINY, FloatArray
from fe_models.causes.candidate import Candidate, HarmonicCandidate, LawCandidate
from hybrid.diagnosis.fitting.driven import History, driven_channels, fitted_motion, forces_along
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.fitting.linearisation import Linearisation, linearise_batch, projections
from hybrid.diagnosis.parallel import parallel_map
from hybrid.diagnosis.recorded.batches import Batch
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.response.forces import force_of
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.load_input import feedthrough
from hybrid.diagnosis.response.marching import respond
from hybrid.diagnosis.response.reduced_model import ReducedModel
from hybrid.diagnosis.response.state_space import system_of
from hybrid.diagnosis.response.system import ModalForm, System, drifted, free_form
from hybrid.diagnosis.screening.config import SCREENING


@dataclass(frozen=True)
class Screened:
    """A ``candidate``, parameters to ``start`` from, and the fall in the sum of squares that it promises (``gain``).

    ``shift`` (parameter,): how far the parameters of the fit that it is held against should move with it; ``is_drawn``:
    whether back to the structure as drawn, where a start is worse than that fit and yet may lead further; ``leads``:
    whether it is among the best of its ranking, which go on whatever their first steps show.
    """

    candidate: Candidate
    start: tuple[float, ...]
    gain: float
    shift: FloatArray
    is_drawn: bool = False
    leads: bool = False

    def theta(self, fit: Fit) -> FloatArray:
        """Return where the fit with this candidate begins, on top of ``fit``."""
        return np.append(fit.theta + self.shift, self.start)


@dataclass(frozen=True)
class _Stretch:
    """One batch of the present fit, linearised there."""

    batch: Batch
    states: FloatArray
    part: Linearisation
    shown: FloatArray  # the channels of the fit, in units of sigma
    forces: tuple[History, ...]  # of the fit's force laws; of a frame's alone

    @cached_property
    def rest(self) -> FloatArray:
        """What is left of the recordings, (recording, value), less what initial states can do."""
        return self.part.residual if self.part.frame is None else self.part.raw.reshape(len(self.states), -1)

    def in_frame(self, column: FloatArray) -> FloatArray:
        """Return a column (recording, value) as the linearisation's slopes and basis are given."""
        if self.part.frame is None:
            return column
        samples = self.part.frame.T @ column.reshape(self.batch.data.shape)
        return np.asarray(samples.reshape(len(column), -1))


@dataclass(frozen=True)
class _Present:
    """The present fit, linearised: what each candidate is held against."""

    fit: Fit
    noise_model: NoiseModel
    stretches: tuple[_Stretch, ...]
    inverse: FloatArray  # of the normal matrix of the parameters
    gradient: FloatArray


def screen(fit: Fit, candidates: tuple[Candidate, ...], noise_model: NoiseModel) -> list[Screened]:
    """Return each candidate with its best start, most promising first; harmonic forces apart (`force_screening`)."""
    present = _present(fit, noise_model)
    forced = law_responses(
        fit, [candidate for candidate in candidates if isinstance(candidate, LawCandidate)], noise_model
    )

    def best_of(candidate: Candidate) -> Screened:
        trials = []
        for number, start in enumerate(candidate.first_starts):
            known = forced[candidate.key][number] if isinstance(candidate, LawCandidate) else None
            trials.append(_score(present, candidate, start, known))
        return max(trials, key=lambda trial: trial.gain)

    found = parallel_map(best_of, [c for c in candidates if not isinstance(c, HarmonicCandidate)])
    return sorted(found, key=lambda trial: -trial.gain)


def _present(fit: Fit, noise_model: NoiseModel) -> _Present:
    stretches = []
    system = system_of(fit.hypothesis, fit.theta[None], noise_model.outputs)
    given = fit.hypothesis.nominal.kept is not None and not system.is_linear  # too many modes to march for each
    for batch, states in zip(fit.batches, fit.states, strict=True):
        part = linearise_batch(fit.hypothesis, fit.theta, batch, noise_model, states, brief=True)
        assert part is not None  # it was fitted
        shown = _response(fit.hypothesis, fit.theta[None], batch, noise_model, states)[0]
        forces = forces_along(system, fitted_motion(system, states, batch)) if given else ()
        stretches.append(_Stretch(batch, states, part, shown, forces))
    J = np.concatenate([stretch.part.slopes.reshape(len(fit.theta), -1) for stretch in stretches], axis=1)
    r = np.concatenate([stretch.part.residual.ravel() for stretch in stretches])
    precision = fit.hypothesis.precision
    gradient = J @ r - precision * (fit.theta - fit.hypothesis.centre)
    inverse = np.linalg.inv(J @ J.T + np.diag(precision))
    return _Present(fit, noise_model, tuple(stretches), inverse, gradient)


def _columns(
    present: _Present, candidate: Candidate, start: tuple[float, ...], forced: list[FloatArray] | None
) -> Iterator[tuple[_Stretch, FloatArray]]:
    """Yield each batch and what the candidate adds to it (recording, value).

    For one unit of a scalable candidate; ``forced``: the response in each batch to a law, which is known already.
    """
    move = start[0] - candidate.without[0] if candidate.names and candidate.scalable else 1.0
    for number, stretch in enumerate(present.stretches):
        column = _effect(present, candidate, start, stretch) if forced is None else forced[number]
        with np.errstate(over="ignore", invalid="ignore"):  # of a start that makes the structure unstable
            column = column / move
        yield stretch, column


def _energy(column: FloatArray, framed: FloatArray, stretch: _Stretch) -> FloatArray:
    """Return the sum of squares (recording,) of a column (recording, value), less what initial states do of it."""
    return np.asarray(np.sum(column**2, axis=1) - np.sum(projections(framed, stretch.part.basis) ** 2, axis=1))


def _effect(present: _Present, candidate: Candidate, start: tuple[float, ...], stretch: _Stretch) -> FloatArray:
    """Return what a candidate at ``start`` adds to the channels (recording, value) shown, in units of sigma.

    Both are taken in the shapes, and with the damping, that the candidate asks for: these move a calibrated structure a
    little by themselves. The pull of force laws is taken as given where there are any. Nothing is returned where
    shapes that come with it have no mass: a fit without it may have taken most of a node's away.
    """
    fit, noise_model, batch, states = present.fit, present.noise_model, stretch.batch, stretch.states
    extended = fit.hypothesis.adding(candidate)
    if not isinstance(candidate, LawCandidate):
        states = extended.embedded(states, (len(extended.candidates) - 1,))
    theta = np.append(fit.theta, start)
    if not candidate.is_structural and not stretch.forces:
        return _response(extended, theta[None], batch, noise_model, states)[0] - stretch.shown
    thetas = np.stack([theta, np.append(fit.theta, candidate.without)])
    if not extended.weighs(thetas).all():
        return np.zeros_like(stretch.shown)
    if stretch.forces:
        with_it, without = _forced_response(extended, thetas, batch, noise_model, states, stretch.forces)
    else:
        with_it, without = _response(extended, thetas, batch, noise_model, states)
    return np.asarray(with_it - without)


def _forced_response(
    hypothesis: Hypothesis,
    thetas: FloatArray,
    batch: Batch,
    noise_model: NoiseModel,
    states: FloatArray,
    forces: tuple[History, ...],
) -> FloatArray:
    """Return the channels (variant, recording, value) under given forces, in units of sigma."""
    system = system_of(hypothesis, thetas, noise_model.outputs)
    form = free_form(system, hypothesis.size)
    start = np.broadcast_to(states, (len(thetas), *states.shape))
    y = respond(replace(system, forces=()), start, batch.samples, batch.loads) + drifted(system, batch.begins)
    for variant in range(len(thetas)):
        for law, force in enumerate(forces):
            direct = system.D[variant, :, law] * system.gain[variant]
            y[variant] += driven_channels(form, variant, system.B[variant, :, law], direct, force, system)
    return np.asarray((y / batch.sigma(noise_model)).reshape(len(thetas), len(states), -1))


def _response(
    hypothesis: Hypothesis, thetas: FloatArray, batch: Batch, noise_model: NoiseModel, states: FloatArray
) -> FloatArray:
    """Return the channels (variant, recording, value) in units of sigma."""
    system = system_of(hypothesis, thetas, noise_model.outputs)
    y = respond(system, np.broadcast_to(states, (len(thetas), *states.shape)), batch.samples, batch.loads)
    y = (y + drifted(system, batch.begins)) / batch.sigma(noise_model)
    return np.asarray(y.reshape(len(thetas), len(states), -1))


def law_responses(fit: Fit, laws: list[LawCandidate], noise_model: NoiseModel) -> dict[str, list[list[FloatArray]]]:
    """Return what each law at each of its starts adds, to first order: by its key, start and batch (recording, value).

    Its force along the present motion, at samples and between them, drives each mode of the linear system (Simpson's
    rule).
    """
    found: dict[str, list[list[FloatArray]]] = {law.key: [[] for _ in law.first_starts] for law in laws}
    trials = [(law, start) for law in laws for start in law.first_starts]
    columns = [own for law in laws for own in found[law.key]]
    if not trials:
        return found
    system = system_of(fit.hypothesis, fit.theta[None], noise_model.outputs)
    form = free_form(system, fit.hypothesis.size)
    reduced = fit.hypothesis.reduced(fit.theta[None])
    for batch, states in zip(fit.batches, fit.states, strict=True):
        motion = fitted_motion(system, states, batch)
        answers = parallel_map(partial(_law_response, fit, motion, system, form, reduced, noise_model), trials)
        for own, y in zip(columns, answers, strict=True):
            own.append((y / batch.sigma(noise_model)).reshape(len(states), -1))
    return found


def _law_response(
    fit: Fit,
    motion: History,
    system: System,
    form: ModalForm,
    reduced: ReducedModel,
    noise_model: NoiseModel,
    trial: tuple[LawCandidate, tuple[float, ...]],
) -> FloatArray:
    """Return the channels (recording, time, sensor) that the force of one law along the ``motion`` adds.

    ``trial``: the law and a start of it.
    """
    law, start = trial
    hypothesis, theta = fit.hypothesis, fit.theta[None]
    n = hypothesis.size
    pull = law.pull @ reduced.shapes[0]
    force_at = force_of(law, hypothesis.nominal, np.array([start]), np.exp(theta[:, : len(hypothesis.nominal.parts)]))
    force = History(
        *(-force_at(part[..., :n] @ pull, part[..., n : 2 * n] @ pull) for part in (motion.now, motion.between))
    )
    moved = np.linalg.solve(reduced.mass[0], pull)
    feed = np.zeros(hypothesis.states)
    feed[n : 2 * n] = moved
    picked = hypothesis.nominal.rows(noise_model.sensors) @ reduced.shapes[0]
    direct = feedthrough(picked, moved[:, None], noise_model.sensors)[:, 0] * system.gain[0]
    return driven_channels(form, 0, feed, direct, force, system)


def _score(
    present: _Present, candidate: Candidate, start: tuple[float, ...], forced: list[FloatArray] | None = None
) -> Screened:
    """Return the score of one candidate; ``forced``: its response in each batch where that is known already."""
    along, size, still = 0.0, 0.0, np.zeros(len(present.fit.theta))
    cross = still.copy()
    for stretch, column in _columns(present, candidate, start, forced):
        if not np.isfinite(column).all():
            return Screened(candidate, start, 0.0, still)
        framed = stretch.in_frame(column)
        along += float(np.vdot(column, stretch.rest))  # which has nothing of initial states, as the slopes
        size += float(np.sum(_energy(column, framed, stretch)))
        cross += stretch.part.slopes.reshape(len(cross), -1) @ framed.ravel()
    projected = cross @ present.inverse
    size_left = size - float(projected @ cross)
    along -= float(projected @ present.gradient)
    if size_left <= SCREENING.confounded_share * size or size == 0:
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


def amounts_by_recording(
    fit: Fit, candidates: list[Candidate], noise_model: NoiseModel
) -> list[tuple[FloatArray, FloatArray]]:
    """Return, for each candidate, how much of it each recording asks for, (recording,), and how much of one unit it
    feels: the sum of squares. The first squared times the second is the fall in the recording's own.

    The uncertain factors are kept as they are: what they do is common to all recordings.
    """
    present = _present(fit, noise_model)
    forced = law_responses(
        fit, [candidate for candidate in candidates if isinstance(candidate, LawCandidate)], noise_model
    )
    found = []
    for candidate in candidates:
        known = forced[candidate.key][0] if isinstance(candidate, LawCandidate) else None
        amounts, sizes = [], []
        for stretch, column in _columns(present, candidate, candidate.first_starts[0], known):
            recordings = len(stretch.batch.names)  # of one or more segments each
            along = np.sum((column * stretch.rest).reshape(recordings, -1), axis=1)
            size = np.sum(_energy(column, stretch.in_frame(column), stretch).reshape(recordings, -1), axis=1)
            amounts.append(along / (size + TINY))
            sizes.append(size)
        found.append((np.concatenate(amounts), np.concatenate(sizes)))
    return found
