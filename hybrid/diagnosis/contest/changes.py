"""A change between recordings beside a cause that acts in all of them."""

from collections.abc import Callable
from dataclasses import replace

from hybrid.diagnosis.causes.candidate import Candidate
from hybrid.diagnosis.contest.growing import Ground, Lengths, ground_of, lengths_of
from hybrid.diagnosis.contest.pairs import ground_with
from hybrid.diagnosis.contest.posterior import Posterior
from hybrid.diagnosis.contest.recording_groups import FEWEST, Groups, asked_for, clear_share
from hybrid.diagnosis.contest.search import contest
from hybrid.diagnosis.contest.switching import ONE_GROUP, fit_switched
from hybrid.diagnosis.fitting.far_off import factors_off
from hybrid.diagnosis.fitting.fitting import Fit, fit
from hybrid.diagnosis.fitting.left_over import left
from hybrid.diagnosis.recorded.gauge import Gauge
from hybrid.diagnosis.recorded.noise import Band
from hybrid.diagnosis.recorded.records import count_of

ALIKE = 20.0  # in log evidence: what some of the recordings cannot tell apart all of them may
MOST_ALIKE = 3  # of these
KEPT_OF_GROUP = 6  # candidates kept from each screening: all recordings have been searched before


def changes_beside(
    nominal: Ground,
    groups: Groups | None,
    alone: tuple[Fit, ...],
    candidates: tuple[Candidate, ...],
    gauge: Gauge,
    band: Band,
    advance: Callable[[], object],
) -> list[Fit]:
    """Return fits of one cause in all recordings and another in some of them only.

    Of two ``groups`` of recordings the first may be all that one of them shows: in all of them the other hides it. It
    may be any of those ``alone`` in all recordings as well, where what these ask for beside it is clear.
    """
    batches = nominal.whole.batches
    if count_of(batches) < FEWEST:
        return []
    seen = [] if groups is None else _seen_before(nominal, groups, candidates, gauge, band, advance)
    clear = clear_share(count_of(batches))
    surely = [item for item in seen if not left(item, gauge, band).significant]  # there nothing else acts
    starts = [(item, ONE_GROUP if item.hypothesis.is_linear else clear) for item in surely]  # two laws take too long
    found: list[Fit] = []
    done: set[str] = set()
    for number, (start, mixed) in enumerate((*starts, *((item, clear) for item in alone if clear > 0))):
        cause = start.hypothesis.candidates[-1].key
        explained = number >= len(starts) and any(not left(item, gauge, band).significant for item in found)
        if cause in done or explained:
            continue
        done.add(cause)
        ground, lengths, _ = ground_with(start, batches, gauge)
        advance()
        if ground is not None:
            asked = asked_for(ground.short, candidates, gauge)
            found += fit_switched(ground.short, ground.whole, asked, lengths, gauge, mixed)
    return found


def groups_in(posterior: Posterior) -> Groups | None:
    """Return the recordings in two groups, as the best fit that has any has them: spared, and not."""
    for item in posterior.fits:
        spared, acting = (tuple(b for b in item.batches if bool(b.off) == off) for off in (True, False))
        if spared:
            return tuple(replace(batch, off=()) for batch in spared), acting
    return None


def changed(
    nominal: Ground,
    groups: Groups | None,
    candidates: tuple[Candidate, ...],
    gauge: Gauge,
    advance: Callable[[], object],
) -> list[Fit]:
    """Return fits of causes that act in one of two ``groups`` of recordings only: what this group alone shows.

    A search beside it may find its size, where what all of them ask for to first order leads astray. Not a harmonic
    force, which is of any size in each recording anyway.
    """
    grounds = [] if groups is None else _nearest_first(nominal, groups, gauge)
    if len(grounds) < 2:
        return []
    near, (far, own) = grounds[0][0].whole, grounds[1]
    without = tuple(replace(batch, off=(len(nominal.hypothesis.candidates),)) for batch in near.batches)
    others = tuple(candidate for candidate in candidates if not candidate.oscillator)
    found = []
    for item in contest(far, others, own, gauge, advance, KEPT_OF_GROUP)[:MOST_ALIKE]:
        begun = None if item.hypothesis.is_linear else (*near.states, *item.states)
        found.append(fit(item.hypothesis, item.theta, (*without, *far.whole.batches), gauge, begun))
    return [item for item in found if item is not None]


def _nearest_first(nominal: Ground, groups: Groups, gauge: Gauge) -> list[tuple[Ground, Lengths]]:
    """Return the nominal fits of two groups of recordings, with their segments; the one that fits better first."""
    hypothesis = nominal.hypothesis
    lengths = [lengths_of(group, hypothesis.states) for group in groups]
    grounds = [ground_of(hypothesis, hypothesis.centre, own, gauge) for own in lengths]
    pairs = [(ground, own) for ground, own in zip(grounds, lengths, strict=True) if ground is not None]
    return sorted(pairs, key=lambda pair: pair[0].whole.misfit / pair[0].whole.values)


def _seen_before(
    nominal: Ground,
    groups: Groups,
    candidates: tuple[Candidate, ...],
    gauge: Gauge,
    band: Band,
    advance: Callable[[], object],
) -> list[Fit]:
    """Return the best fit to those of two groups of recordings that are nearer to the nominal structure, if any, and
    what these recordings alone hardly tell from it; none where nothing is wrong in them.
    """
    for ground, own in _nearest_first(nominal, groups, gauge)[:1]:
        if not left(ground.whole, gauge, band).significant and not factors_off(ground.whole):
            break
        ranked = contest(ground, candidates, own, gauge, advance, KEPT_OF_GROUP)
        return [item for item in ranked[:MOST_ALIKE] if item.log_evidence > ranked[0].log_evidence - ALIKE]
    return []
