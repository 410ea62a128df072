"""Recordings that are not of one structure: a cause that acts in some of them only.

So far causes in whose presence the motion stays linear in its initial state; force laws that come and go take too long.
"""

from dataclasses import replace

import numpy as np

from fe_models.dofs import BoolArray, FloatArray
from hybrid.diagnosis.candidates import Candidate
from hybrid.diagnosis.fitting import Fit, Frame, linearise_batch
from hybrid.diagnosis.records import Batch
from hybrid.diagnosis.screening import amounts_by_recording
from hybrid.diagnosis.search import fit_growing, lengths_of

TRIED = 5  # candidates, the most promising if each recording had its own amount
ROUNDS = 2  # of sorting the recordings by the fit and fitting again


def fit_switched(
    short: Fit, candidates: tuple[Candidate, ...], batches: tuple[Batch, ...], frame: Frame
) -> tuple[Fit, ...]:
    """Return fits of one more candidate each that acts in some of the recordings only, best evidence first.

    ``short``: the fit without it, over short segments of the recordings ``batches``.
    """
    usable = [c for c in candidates if c.names and not c.is_law and not c.oscillator]
    ranked = []
    for candidate, (amounts, gains) in zip(usable, amounts_by_recording(short, usable, frame), strict=True):
        ranked.append((float(gains.sum()), candidate, amounts, gains))
    ranked.sort(key=lambda item: -item[0])
    found = []
    for _, candidate, amounts, gains in ranked[:TRIED]:
        high = _two_groups(amounts, gains)
        for acting in (high, ~high):
            if acting.any() and not acting.all():
                best = _fit_sorted(short, candidate, acting, batches, frame)
                if best is not None:
                    found.append(best)
    return tuple(sorted(found, key=lambda item: -item.log_evidence))


def acting_recordings(fit: Fit, number: int) -> tuple[str, ...]:
    """Return the names of the recordings where candidate ``number`` of a fit acts."""
    return tuple(name for batch in fit.batches if number not in batch.off for name in batch.names)


def _two_groups(amounts: FloatArray, weights: FloatArray) -> BoolArray:
    """Return which of the ``amounts`` (recording,) belong to the upper of two groups: the split with least variance."""
    order = np.argsort(amounts)
    ranked = amounts[order]
    spread = [np.var(ranked[:k]) * k + np.var(ranked[k:]) * (len(ranked) - k) for k in range(1, len(ranked))]
    high = np.zeros(len(amounts), dtype=bool)
    high[order[int(np.argmin(spread)) + 1 :]] = True
    return high


def _fit_sorted(
    short: Fit, candidate: Candidate, acting: BoolArray, batches: tuple[Batch, ...], frame: Frame
) -> Fit | None:
    hypothesis = short.hypothesis.adding(candidate)
    number = len(hypothesis.candidates) - 1
    present: Fit | None = None
    for _ in range(ROUNDS):
        split = _split(batches, acting, number)
        start = np.append(short.theta, candidate.first_starts[0]) if present is None else present.theta
        present = fit_growing(hypothesis, start, lengths_of(split, hypothesis.states), frame)
        if present is None:
            return None
        better = _preference(present, batches, number, frame)
        if (better == acting).all() or better.all() or not better.any():
            break
        acting = better
    return present


def _split(batches: tuple[Batch, ...], acting: BoolArray, number: int) -> tuple[Batch, ...]:
    parts, first = [], 0
    for batch in batches:
        own = acting[first : first + len(batch.names)]
        first += len(batch.names)
        if own.any():
            parts.append(batch.take([int(i) for i in np.flatnonzero(own)]))
        if not own.all():
            parts.append(replace(batch.take([int(i) for i in np.flatnonzero(~own)]), off=(*batch.off, number)))
    return tuple(parts)


def _preference(fit: Fit, batches: tuple[Batch, ...], number: int, frame: Frame) -> BoolArray:
    """Return in which recordings the candidate does better acting than not, as it was fitted."""
    left = []
    for off in ((), (number,)):
        rows = []
        for batch in batches:
            part = linearise_batch(fit.hypothesis, fit.theta, replace(batch, off=off), frame, None, slopes=False)
            assert part is not None  # linear systems always answer
            rows.append(np.sum(part.raw**2, axis=(1, 2)))
        left.append(np.concatenate(rows))
    return np.asarray(left[0] < left[1])
