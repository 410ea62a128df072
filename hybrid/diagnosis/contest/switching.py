"""Recordings that are not of one structure: a cause that acts in some of them only."""

from dataclasses import replace
from functools import partial

import numpy as np

from fe_models.arrays import BoolArray, FloatArray
from fe_models.causes.candidate import Candidate, HarmonicCandidate, LawCandidate
from hybrid.diagnosis.contest.bounds import bound_of
from hybrid.diagnosis.contest.config import GROUPS, SEGMENTS, SHORTLIST
from hybrid.diagnosis.contest.effort import effort_of
from hybrid.diagnosis.contest.growing import Lengths, continued, padded, shortened
from hybrid.diagnosis.contest.odds import log_of_groups
from hybrid.diagnosis.contest.recording_groups import Asked, each_with
from hybrid.diagnosis.fitting.calibration_deviation import goes_far
from hybrid.diagnosis.fitting.harmonic_amplitude import harmonic_amplitude
from hybrid.diagnosis.fitting.least_squares import Fit, fit, left_at
from hybrid.diagnosis.parallel import parallel_map
from hybrid.diagnosis.recorded.batches import Batch, as_made
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.screening.scanning import leaves_much, scan


def fit_switched(
    short: Fit, best: Fit, asked: tuple[Asked, ...], lengths: Lengths, noise_model: NoiseModel, mixed: float = 1.0
) -> list[Fit]:
    """Return fits of one more candidate each that acts in some of the recordings only.

    ``short``: the fit without it, over the shortest segments of the recordings, and what these have ``asked`` for
    beside it; ``best``: of what acts in all of them; ``mixed``: share of the variance of what recordings ask for that
    may be left within two groups of them, unless these are those before and after a change.
    """
    trials = _trials(asked, mixed)
    if not trials or _asks_little(short, asked):
        return []
    number = len(short.hypothesis.candidates)
    again = shortened(best, short.batches, noise_model, padded(short, best.hypothesis))
    rivals = [] if again is None else [again]
    sorted_fits: list[tuple[Fit, BoolArray]] = []
    for candidate, high in trials:
        bound = bound_of([*rivals, *(item for item, _ in sorted_fits)])
        begun = parallel_map(partial(_fit_sorted, short, candidate, noise_model, bound), (high, ~high))
        either = [found for found in begun if found is not None and found[0].charged <= bound]
        sorted_fits += [
            pair for pair in either if pair[0].charged <= min(item.charged for item, _ in either) + SHORTLIST.tied_fall
        ]
    for longer in lengths.cut[1:]:
        limit = bound_of([item for item, _ in sorted_fits])
        further: list[tuple[Fit, BoolArray]] = []
        for item, acting in sorted(sorted_fits, key=lambda pair: pair[0].charged):
            if item.charged <= limit:
                batches = _split(longer, acting, number)
                states, bound = continued(item, batches), bound_of([other for other, _ in further])
                start, enough = (item.hypothesis, item.theta, batches, noise_model, states), lengths.enough(longer)
                then = fit(*start, enough=enough, bound=bound)
                further += [] if then is None else [_sorted_anew(then, acting, longer, number, noise_model)]
        sorted_fits = further
    return [item for item, _ in sorted_fits]


def fit_everywhere(item: Fit, whole: tuple[Batch, ...], noise_model: NoiseModel) -> Fit | None:
    """Return the fit of the same causes acting in all recordings, the ``whole`` of them; None where it fails."""
    return fit(item.hypothesis, item.theta, whole, noise_model, states_in(whole, item))


def _asks_little(short: Fit, asked: tuple[Asked, ...]) -> bool:
    """Return whether the recordings of a chain hardly ask for any candidate in amounts of their own."""
    misfitting = short.misfit - GROUPS.max_noise_sigma * np.sqrt(2 * short.values)
    return (
        short.hypothesis.nominal.is_chain and max(item.gain for item in asked) < GROUPS.min_promised_share * misfitting
    )


def _trials(asked: tuple[Asked, ...], mixed: float) -> list[tuple[Candidate, BoolArray]]:
    """Return the candidates to fit, each with one of two groups of recordings (recording,) to begin with: its own.

    Where one tells a change, that is where all others begin which tell none: one thing changed, and they are rivals.
    """
    most = [
        min(mixed, GROUPS.max_within_share) if isinstance(item.candidate, LawCandidate) else mixed for item in asked
    ]
    change = next((item.high for item in asked if item.is_change), None)
    if mixed < 1.0 and change is not None:
        return [(item.candidate, item.high if item.is_change else change) for item in asked]
    telling = [item.within <= share or item.is_change for item, share in zip(asked, most, strict=True)]
    return [(item.candidate, item.high) for item, tells in zip(asked, telling, strict=True) if tells]


def acting_recordings(fit: Fit, number: int) -> tuple[str, ...]:
    """Return the names of the recordings where candidate ``number`` of a fit acts."""
    if isinstance(fit.hypothesis.candidates[number], HarmonicCandidate):
        return tuple(name for name, acts in zip(fit.names, harmonic_amplitude(fit, number).acting, strict=True) if acts)
    return tuple(name for batch in fit.batches if number not in batch.off for name in batch.names)


def _fit_sorted(
    short: Fit, candidate: Candidate, noise_model: NoiseModel, bound: float, acting: BoolArray
) -> tuple[Fit, BoolArray] | None:
    """Return the fit over the shortest segments and where it acts, the recordings sorted anew after each round.

    None where it fails, or would act in all or none of the recordings.
    """
    hypothesis = short.hypothesis.adding(candidate)
    number = len(hypothesis.candidates) - 1
    starts = candidate.first_starts
    thetas = [np.append(short.theta, starts[len(starts) // 2]), *_as_drawn(short, candidate, acting, noise_model)]
    present: tuple[Fit, BoolArray] | None = None
    for _ in range(GROUPS.sorting_rounds):
        if acting.all() or not acting.any():
            return present
        batches, states = _split(short.batches, acting, number), _states(short, acting)
        tried = [
            fit(hypothesis, theta, batches, noise_model, states, enough=SEGMENTS.enough_fall, bound=bound)
            for theta in thetas
        ]
        item = min((one for one in tried if one is not None), key=lambda one: one.cost, default=None)
        if item is None:
            return present
        present, thetas = (item, acting), [item.theta]
        better = _preference(item, short.batches, short.states, number, noise_model)
        if (better == acting).all():
            break
        acting = better
    return present


def _as_drawn(short: Fit, candidate: Candidate, acting: BoolArray, noise_model: NoiseModel) -> list[FloatArray]:
    """Return a start of a fit in the structure as drawn, the candidate as large as those recordings ask for in which it
    acts; none where the ``short`` fit, of recordings of two structures perhaps, is not astray.
    """
    if not (goes_far(short) or leaves_much(short)):
        return []
    parts = [(batch, np.flatnonzero(chosen).tolist()) for batch, chosen in each_with(short.batches, acting)]
    own = tuple(batch.take(chosen) for batch, chosen in parts if chosen)
    found = scan(replace(short, batches=own), (candidate,), noise_model)
    return [trial.theta(short) for trial in found]


def _split(batches: tuple[Batch, ...], acting: BoolArray, number: int) -> tuple[Batch, ...]:
    """Return each batch in two: the recordings where candidate ``number`` acts, and the others."""
    parts = []
    for batch, own in each_with(batches, acting):
        for chosen, off in ((own, batch.off), (~own, (*batch.off, number))):
            if chosen.any():
                parts.append(replace(batch.take(np.flatnonzero(chosen).tolist()), off=off))
    return tuple(parts)


def _states(short: Fit, acting: BoolArray) -> tuple[FloatArray, ...]:
    """Return a fit's initial states, split as `_split` splits its batches."""
    return tuple(
        states[np.repeat(chosen, batch.pieces)]
        for (batch, own), states in zip(each_with(short.batches, acting), short.states, strict=True)
        for chosen in (own, ~own)
        if chosen.any()
    )


def _sorted_anew(
    item: Fit, acting: BoolArray, whole: tuple[Batch, ...], number: int, noise_model: NoiseModel
) -> tuple[Fit, BoolArray]:
    """Return a fit and where the candidate acts, with the recordings sorted by it, if that is better.

    ``whole``: its batches before they were split. Longer segments tell more than those by which they were sorted. Not
    of a frame's force laws, which would take too long.
    """
    if not (item.hypothesis.is_linear or effort_of(item.hypothesis.nominal).thorough):
        return item, acting
    better = _preference(item, whole, states_in(whole, item), number, noise_model)
    if better.all() or not better.any() or (better == acting).all():
        return item, acting
    batches = _split(whole, better, number)
    again = fit(item.hypothesis, item.theta, batches, noise_model, states_in(batches, item))
    return (item, acting) if again is None or again.cost > item.cost else (again, better)


def states_in(batches: tuple[Batch, ...], item: Fit) -> tuple[FloatArray, ...] | None:
    """Return the initial states of a fit's recordings as they stand in other ``batches``, at rest in what did not act;
    None of a linear hypothesis, whose states are solved for.
    """
    hypothesis, found = item.hypothesis, dict[object, FloatArray]()
    if hypothesis.is_linear:
        return None
    for batch, states in zip(item.batches, item.states, strict=True):
        whole = hypothesis.embedded(states, batch.off, SEGMENTS.first_force)
        own = whole.reshape(len(batch.names), batch.pieces, -1)
        found.update(zip(batch.order or batch.names, own, strict=True))  # several motions may share a name
    return tuple(
        np.concatenate([found[key] for key in batch.order or batch.names])[:, hypothesis.states_of(batch.off)]
        for batch in batches
    )


def _preference(
    item: Fit, batches: tuple[Batch, ...], states: tuple[FloatArray, ...] | None, number: int, noise_model: NoiseModel
) -> BoolArray:
    """Return in which recordings the candidate does better acting than not, as it was fitted; ``states`` of the
    ``batches`` to begin with, needed where there are laws.

    Those before or after a change, unless the recordings are surer of other groups than all groups are many.
    """
    with_it, without = (
        np.concatenate(
            [
                _cost_by_recording(
                    item.hypothesis, item.theta, replace(batch, off=(*batch.off, *off)), begun, noise_model
                )
                for batch, begun in zip(batches, states or (None,) * len(batches), strict=True)
            ]
        )
        for off in ((), (number,))
    )
    made = as_made(batches)
    finite = np.minimum([without, with_it], GROUPS.endless)
    told = (finite[0] - finite[1])[made]  # by each recording, for acting there
    after = np.arange(len(told)) >= np.arange(1, len(told))[:, None]  # (change, recording)
    ordered = np.concatenate([after, ~after])
    best, free = ordered[np.argmax(ordered @ told)], np.asarray(told > 0)
    surer = 2 * (log_of_groups(best) - log_of_groups(free))
    chosen = free if len(set(free)) == 1 or told[free].sum() - told[best].sum() > surer else best
    return chosen[np.argsort(made)]


def _cost_by_recording(
    hypothesis: Hypothesis, theta: FloatArray, batch: Batch, states: FloatArray | None, noise_model: NoiseModel
) -> FloatArray:
    """Return the sum of squares (recording,) at one theta, the initial states of all segments fitted."""
    left = left_at(hypothesis, theta, batch, noise_model, states)
    if left is None:
        return np.full(len(batch.names), np.inf)
    return np.sum(left.reshape(len(batch.names), -1) ** 2, axis=1)
