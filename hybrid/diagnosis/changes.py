"""A change between recordings beside a cause that acts in all of them."""

from collections.abc import Callable
from dataclasses import replace

from hybrid.diagnosis.candidate import Candidate
from hybrid.diagnosis.fitting import Fit
from hybrid.diagnosis.frame import Frame
from hybrid.diagnosis.noise import Band
from hybrid.diagnosis.pairs import ground_with, left, misfit
from hybrid.diagnosis.posterior import Posterior
from hybrid.diagnosis.records import Batch
from hybrid.diagnosis.search import Ground, contest, ground_of, lengths_of
from hybrid.diagnosis.switching import apart, fit_switched, groups_of

Groups = tuple[tuple[Batch, ...], tuple[Batch, ...]]

CLEAR = 0.3  # see `clear_share`


def changes_beside(
    nominal: Ground,
    posterior: Posterior,
    candidates: tuple[Candidate, ...],
    frame: Frame,
    band: Band,
    advance: Callable[[], object],
) -> list[Fit]:
    """Return fits of one cause in all recordings and another in some of them only, where these clearly differ.

    The first is the best alone and, where there are two groups, what one of them shows: elsewhere the other hides it.
    """
    batches = nominal.whole.batches
    alone = [item for item in posterior.fits if item.hypothesis.candidates and not any(b.off for b in item.batches)]
    groups = _groups(nominal, posterior.fits[0], candidates, frame)
    seen = [] if groups is None else _seen_before(nominal, groups, candidates, frame, advance)
    first = [item for item in seen if not left(item, frame, band).significant]  # there nothing else acts
    found: list[Fit] = []
    mixed = clear_share(sum(len(batch.names) for batch in batches)) if not first else 1.0
    for start in [*first, *alone[:1]]:
        ground, lengths, _ = ground_with(start, batches, frame)
        advance()
        if ground is not None:
            found += fit_switched(ground.short, ground.whole, candidates, lengths, frame, mixed)
    return found


def _groups(nominal: Ground, best: Fit, candidates: tuple[Candidate, ...], frame: Frame) -> Groups | None:
    """Return the recordings in two groups: as the best fit has them, or as what they ask for clearly has them."""
    if any(batch.off for batch in best.batches):
        acting, spared = (tuple(b for b in best.batches if bool(b.off) == off) for off in (False, True))
        return tuple(replace(b, off=()) for b in spared), acting
    batches = nominal.whole.batches
    high = groups_of(nominal.short, candidates, frame, clear_share(sum(len(batch.names) for batch in batches)))
    return None if high is None else apart(batches, high)


def clear_share(recordings: int) -> float:
    """Return the share of the variance of normal draws that is less than this within the better two of all groups of
    them in about 1 of 25 cases: 2e-4 for three recordings, 0.11 for nine.
    """
    return CLEAR ** (1 + 6 / (recordings - 2))


def _seen_before(
    nominal: Ground,
    groups: Groups,
    candidates: tuple[Candidate, ...],
    frame: Frame,
    advance: Callable[[], object],
) -> list[Fit]:
    """Return the best fit to those of two groups of recordings that are nearer to the nominal structure, if any."""
    hypothesis = nominal.hypothesis
    lengths = [lengths_of(group, hypothesis.states) for group in groups]
    grounds = [ground_of(hypothesis, hypothesis.centre, own, frame) for own in lengths]
    pairs = [(ground, own) for ground, own in zip(grounds, lengths, strict=True) if ground is not None]
    ground, own = min(pairs, key=lambda pair: misfit(pair[0].whole) / pair[0].whole.values, default=(None, None))
    if ground is None or own is None:
        return []
    return [item for item in contest(ground, candidates, own, frame, advance) if item.hypothesis.candidates][:1]
