"""Recordings that are not of one structure: a cause that acts in some of them only."""

from dataclasses import replace

import numpy as np

from fe_models.dofs import BoolArray, FloatArray
from hybrid.diagnosis.candidate import Candidate
from hybrid.diagnosis.fitting import ENOUGH, Fit, fit
from hybrid.diagnosis.frame import Frame
from hybrid.diagnosis.hypothesis import Hypothesis
from hybrid.diagnosis.linearisation import linearise_batch
from hybrid.diagnosis.records import Batch, count_of
from hybrid.diagnosis.screening import amounts_by_recording
from hybrid.diagnosis.search import CLOSE_ENOUGH, Lengths, bound_of, continued, padded
from hybrid.diagnosis.wave import wave

FEWEST = 3  # recordings in which two groups can be told
TRIED = 4  # candidates, the most promising if each recording had its own amount
TRIED_LAWS = 2  # of them force laws
ONE_GROUP = 0.4  # of the variance within two groups: more is one group for a force law, whose fits take long
ROUNDS = 3  # of sorting the recordings by the fit and fitting again
SETTLING = 3  # steps of Newton's method in which initial states follow a law that comes or goes


def fit_switched(
    short: Fit, best: Fit, candidates: tuple[Candidate, ...], lengths: Lengths, frame: Frame, mixed: float = 1.0
) -> list[Fit]:
    """Return fits of one more candidate each that acts in some of the recordings only.

    ``short``: the fit without it, over the shortest segments of the recordings; ``best``: of what acts in all of them;
    ``mixed``: share of the variance of what recordings ask for that may be left within two groups of them.
    """
    if count_of(short.batches) < FEWEST:
        return []
    number = len(short.hypothesis.candidates)
    states = padded(short.states, best.hypothesis)
    again = fit(best.hypothesis, best.theta, short.batches, frame, states, enough=CLOSE_ENOUGH)
    rivals = [] if again is None else [again]
    sorted_fits: list[tuple[Fit, BoolArray]] = []
    for candidate, amounts in _unequal(short, candidates, frame):
        high, within = _two_groups(amounts)
        if within > (min(mixed, ONE_GROUP) if candidate.is_law else mixed):
            continue
        for acting in (high, ~high):
            bound = bound_of([*rivals, *(item for item, _ in sorted_fits)])
            found = _fit_sorted(short, candidate, acting, frame, bound)
            sorted_fits += [] if found is None or found[0].cost > bound else [found]
    for longer in lengths.cut[1:]:
        enough = ENOUGH if longer is lengths.whole else CLOSE_ENOUGH
        limit = bound_of([item for item, _ in sorted_fits])
        further: list[tuple[Fit, BoolArray]] = []
        for item, acting in sorted(sorted_fits, key=lambda pair: pair[0].cost):
            if item.cost <= limit:
                batches = _split(longer, acting, number)
                states, bound = continued(item, batches), bound_of([other for other, _ in further])
                then = fit(item.hypothesis, item.theta, batches, frame, states, enough=enough, bound=bound)
                further += [] if then is None else [(then, acting)]
        sorted_fits = further
    return [item for item, _ in sorted_fits]


def groups_of(short: Fit, candidates: tuple[Candidate, ...], frame: Frame, mixed: float) -> BoolArray | None:
    """Return which recordings (recording,) belong to the one of two groups that the most promising of the candidates
    tell apart; None where none leaves at most the share ``mixed`` of the variance within them.
    """
    for _, amounts in _unequal(short, candidates, frame):
        high, within = _two_groups(amounts)
        if within <= mixed:
            return high
    return None


def apart(batches: tuple[Batch, ...], high: BoolArray) -> tuple[tuple[Batch, ...], tuple[Batch, ...]]:
    """Return the recordings of each of two groups."""
    parts = [(batch, own) for batch, own in _apart(batches, high)]
    lower, upper = (
        tuple(batch.take(np.flatnonzero(own == side).tolist()) for batch, own in parts if (own == side).any())
        for side in (False, True)
    )
    return lower, upper


def acting_recordings(fit: Fit, number: int) -> tuple[str, ...]:
    """Return the names of the recordings where candidate ``number`` of a fit acts."""
    if fit.hypothesis.candidates[number].oscillator:
        names = [name for batch in fit.batches for name in batch.names]
        return tuple(name for name, acts in zip(names, wave(fit, number).acting, strict=True) if acts)
    return tuple(name for batch in fit.batches if number not in batch.off for name in batch.names)


def _unequal(short: Fit, candidates: tuple[Candidate, ...], frame: Frame) -> list[tuple[Candidate, FloatArray]]:
    """Return the most promising candidates with the amount of each that every recording asks for."""
    taken = {candidate.key for candidate in short.hypothesis.candidates}
    usable = [c for c in candidates if c.names and not c.oscillator and c.key not in taken]
    if not short.hypothesis.is_linear:  # whose initial states are searched, too: one size of them for all recordings
        usable = [candidate for candidate in usable if candidate.released is None]
    middle = [replace(c, starts=(c.first_starts[len(c.first_starts) // 2],)) for c in usable]
    asked = amounts_by_recording(short, middle, frame)
    ranked = [
        (float(gains.sum()), candidate, amounts)
        for candidate, (amounts, gains) in zip(usable, asked, strict=True)
        if np.isfinite(amounts).all()
    ]
    ranked.sort(key=lambda item: -item[0])
    chosen: list[tuple[Candidate, FloatArray]] = []
    for _, candidate, amounts in ranked:
        laws = sum(other.is_law for other, _ in chosen)
        if len(chosen) < TRIED and not (candidate.is_law and laws >= TRIED_LAWS):
            chosen.append((candidate, amounts))
    return chosen


def _two_groups(amounts: FloatArray) -> tuple[BoolArray, float]:
    """Return which of the ``amounts`` (recording,) belong to the upper of two groups, split for the least variance.

    Second: the share of the variance that is left within the groups.
    """
    order = np.argsort(amounts)
    ranked = amounts[order]
    spread = [np.var(ranked[:k]) * k + np.var(ranked[k:]) * (len(ranked) - k) for k in range(1, len(ranked))]
    high = np.zeros(len(amounts), dtype=bool)
    high[order[int(np.argmin(spread)) + 1 :]] = True
    return high, float(min(spread) / (np.var(amounts) * len(amounts) + 1e-300))


def _fit_sorted(
    short: Fit, candidate: Candidate, acting: BoolArray, frame: Frame, bound: float
) -> tuple[Fit, BoolArray] | None:
    """Return the fit over the shortest segments and where it acts, the recordings sorted anew after each round.

    None where it fails, or would act in all or none of the recordings.
    """
    hypothesis = short.hypothesis.adding(candidate)
    number = len(hypothesis.candidates) - 1
    starts = candidate.first_starts
    theta = np.append(short.theta, starts[len(starts) // 2])
    present: tuple[Fit, BoolArray] | None = None
    for _ in range(ROUNDS):
        if acting.all() or not acting.any():
            return present
        batches = _split(short.batches, acting, number)
        item = fit(hypothesis, theta, batches, frame, _states(short, acting), enough=CLOSE_ENOUGH, bound=bound)
        if item is None:
            return present
        present, theta = (item, acting), item.theta
        better = _preference(item, short, number, frame)
        if (better == acting).all():
            break
        acting = better
    return present


def _split(batches: tuple[Batch, ...], acting: BoolArray, number: int) -> tuple[Batch, ...]:
    """Return each batch in two: the recordings where candidate ``number`` acts, and the others."""
    parts = []
    for batch, own in _apart(batches, acting):
        for chosen, off in ((own, batch.off), (~own, (*batch.off, number))):
            if chosen.any():
                parts.append(replace(batch.take(np.flatnonzero(chosen).tolist()), off=off))
    return tuple(parts)


def _states(short: Fit, acting: BoolArray) -> tuple[FloatArray, ...]:
    """Return a fit's initial states, split as `_split` splits its batches."""
    return tuple(
        states[np.repeat(chosen, batch.pieces)]
        for (batch, own), states in zip(_apart(short.batches, acting), short.states, strict=True)
        for chosen in (own, ~own)
        if chosen.any()
    )


def _apart(batches: tuple[Batch, ...], acting: BoolArray) -> list[tuple[Batch, BoolArray]]:
    ends = np.cumsum([len(batch.names) for batch in batches])
    return list(zip(batches, np.split(acting, ends[:-1]), strict=True))


def _preference(item: Fit, short: Fit, number: int, frame: Frame) -> BoolArray:
    """Return in which recordings the candidate does better acting than not, as it was fitted."""
    with_it, without = (
        np.concatenate(
            [
                _cost_by_recording(item.hypothesis, item.theta, replace(batch, off=(*batch.off, *off)), states, frame)
                for batch, states in zip(short.batches, short.states, strict=True)
            ]
        )
        for off in ((), (number,))
    )
    return np.asarray(with_it < without)


def _cost_by_recording(
    hypothesis: Hypothesis, theta: FloatArray, batch: Batch, states: FloatArray, frame: Frame
) -> FloatArray:
    """Return the sum of squares (recording,) at one theta, the initial states of all segments fitted."""
    linear = not any(c.is_law for i, c in enumerate(hypothesis.candidates) if i not in batch.off)
    for _ in range(0 if linear else SETTLING):
        part = linearise_batch(hypothesis, theta, batch, frame, states)
        if part is None:
            return np.full(len(batch.names), np.inf)
        states = part.states + part.state_step
    part = linearise_batch(hypothesis, theta, batch, frame, states, slopes=False)
    if part is None:
        return np.full(len(batch.names), np.inf)
    return np.sum(part.raw.reshape(len(batch.names), -1) ** 2, axis=1)
