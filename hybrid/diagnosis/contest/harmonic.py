"""Fits of harmonic forces, over whole recordings: segments do not tell a frequency well."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from fe_models.arrays import FloatArray
from fe_models.causes.candidate import Candidate
from hybrid.diagnosis.config import THREADS
from hybrid.diagnosis.contest.bounds import bound_of
from hybrid.diagnosis.contest.config import HARMONIC_SEARCH
from hybrid.diagnosis.contest.starts import best_start
from hybrid.diagnosis.fitting.calibration_deviation import goes_far, within
from hybrid.diagnosis.fitting.least_squares import Fit, fit
from hybrid.diagnosis.parallel import in_chunks, parallel_map
from hybrid.diagnosis.recorded.batches import count_of
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.screening.force_screening import screen_forces
from hybrid.diagnosis.screening.screening import Screened


def fit_forces(
    base: Fit,
    candidates: tuple[Candidate, ...],
    rivals: list[Fit],
    noise_model: NoiseModel,
    advance: Callable[[], object],
) -> list[Fit]:
    """Return fits of the most promising harmonic forces of the ``candidates`` on top of the ``base``; of more, where
    none of the ``rivals`` does better.
    """
    found = _beside_the_drawn(base, candidates, rivals, noise_model, advance)
    forces = _worth_it(base, screen_forces(base, candidates, noise_model))
    return found + _fit_best(base, forces, [*rivals, *found], noise_model, advance)


def _beside_the_drawn(
    base: Fit,
    candidates: tuple[Candidate, ...],
    rivals: list[Fit],
    noise_model: NoiseModel,
    advance: Callable[[], object],
) -> list[Fit]:
    """Return fits of the harmonic forces that the structure as drawn asks for, where the calibration has gone far.

    It may have moved a natural frequency to where a machine runs, and what is left is then the mode itself: a score
    test finds that, and not the machine.
    """
    if not goes_far(base) or not base.hypothesis.is_linear:
        return []
    forces = _screened_at(within(base, 0.0), base, candidates, noise_model)
    apart = HARMONIC_SEARCH.min_lines_apart * noise_model.rate / max(batch.samples for batch in base.batches)
    lines: list[Screened] = []  # the best place of each frequency
    for trial in forces:
        if all(abs(trial.start[0] - line.start[0]) > apart for line in lines):
            lines.append(trial)
    refined = partial(_refined, base, noise_model, bound_of([base, *rivals]))
    found = [item for item in parallel_map(refined, lines[: HARMONIC_SEARCH.max_fitted]) if item is not None]
    advance()
    if not _lead(found, rivals):
        return found
    ahead = max(found, key=lambda item: item.log_evidence)
    nearby = _screened_at(ahead.theta[: len(base.theta)], base, candidates, noise_model)
    return found + _fit_best(base, nearby, rivals, noise_model, advance)


def _screened_at(
    theta: FloatArray, base: Fit, candidates: tuple[Candidate, ...], noise_model: NoiseModel
) -> list[Screened]:
    """Return the harmonic forces with their best frequencies, most promising first, where the base has that ``theta``;
    their fits begin there.
    """
    there = fit(base.hypothesis, theta, base.batches, noise_model, base.states, iterations=0)
    if there is None:
        return []
    forces = _worth_it(base, screen_forces(there, candidates, noise_model))
    return [replace(trial, shift=theta - base.theta, is_drawn=True) for trial in forces]


def _worth_it(base: Fit, forces: list[Screened]) -> list[Screened]:
    return [trial for trial in forces if trial.gain > HARMONIC_SEARCH.min_fall_per_recording * count_of(base.batches)]


def _fit_best(
    base: Fit, forces: list[Screened], rivals: list[Fit], noise_model: NoiseModel, advance: Callable[[], object]
) -> list[Fit]:
    """Return fits of the most promising harmonic forces; of more, their neighbours, where one of them is the best, and
    of all that promise so nearly as much as the first that their fits may be as good.
    """
    found: list[Fit] = []
    is_chain, linear = base.hypothesis.nominal.is_chain, base.hypothesis.is_linear
    # beside a frame's law each takes five seconds, and they are alike
    least = HARMONIC_SEARCH.max_fitted if is_chain or linear else 1
    trials = forces[: HARMONIC_SEARCH.max_fitted if is_chain or not linear else HARMONIC_SEARCH.max_neighbours]
    for number, two in enumerate(in_chunks(trials)):
        tried = number * THREADS.motions
        if tried >= least and not _lead(found, rivals):
            break
        behind = forces[0].gain - two[0].gain
        if tried >= HARMONIC_SEARCH.neighbours and min(item.charged for item in found) + behind > bound_of(found):
            break
        bound = bound_of([base, *rivals, *found])
        near = [trial for trial in two if base.cost - HARMONIC_SEARCH.underrated * trial.gain < bound]
        found += [item for item in parallel_map(partial(_refined, base, noise_model, bound), near) if item is not None]
        advance()
    return found


def _lead(found: list[Fit], rivals: list[Fit]) -> bool:
    """Return whether none of the ``rivals`` is more probable than the best of those ``found``."""
    best = max((item.log_evidence for item in found), default=None)
    return best is not None and all(item.log_evidence <= best for item in rivals)


def _refined(base: Fit, noise_model: NoiseModel, bound: float, trial: Screened) -> Fit | None:
    """Return the fit of a harmonic force over whole recordings, at rest in the initial states to begin with."""
    step = best_start(base.hypothesis, base, noise_model, trial)
    if step is None:
        return None
    return fit(step.hypothesis, step.theta, base.batches, noise_model, step.states, bound=bound)
