"""A change between recordings beside a cause that acts in all of them."""

from collections.abc import Callable
from dataclasses import replace

from fe_models.causes.candidate import Candidate, HarmonicCandidate
from hybrid.diagnosis.contest.config import GROUPS, SHORTLIST
from hybrid.diagnosis.contest.growing import Lengths, ReferenceFits, lengths_of, reference_fits_of
from hybrid.diagnosis.contest.pairs import reference_fits_with
from hybrid.diagnosis.contest.posterior import Posterior
from hybrid.diagnosis.contest.recording_groups import Groups, asked_for, clear_share
from hybrid.diagnosis.contest.search import contest
from hybrid.diagnosis.contest.switching import fit_switched
from hybrid.diagnosis.fitting.calibration_deviation import factors_off
from hybrid.diagnosis.fitting.excess_energy import excess_energy
from hybrid.diagnosis.fitting.least_squares import Fit, fit
from hybrid.diagnosis.recorded.batches import count_of
from hybrid.diagnosis.recorded.noise import Band
from hybrid.diagnosis.recorded.noise_model import NoiseModel


def changes_beside(
    nominal: ReferenceFits,
    groups: Groups | None,
    alone: tuple[Fit, ...],
    candidates: tuple[Candidate, ...],
    noise_model: NoiseModel,
    band: Band,
    advance: Callable[[], object],
) -> list[Fit]:
    """Return fits of one cause in all recordings and another in some of them only.

    Of two ``groups`` of recordings the first may be all that one of them shows: in all of them the other hides it. It
    may be any of those ``alone`` in all recordings as well, where what these ask for beside it is clear.
    """
    batches = nominal.whole.batches
    if count_of(batches) < GROUPS.min_recordings:
        return []
    seen = [] if groups is None else _seen_before(nominal, groups, candidates, noise_model, band, advance)
    clear = clear_share(count_of(batches))
    # there nothing else acts
    surely = [item for item in seen if not excess_energy(item, noise_model, band).significant]
    # two laws take too long
    starts = [(item, GROUPS.max_within_share if item.hypothesis.is_linear else clear) for item in surely]
    found: list[Fit] = []
    done: set[str] = set()
    for number, (start, mixed) in enumerate((*starts, *((item, clear) for item in alone if clear > 0))):
        cause = start.hypothesis.candidates[-1].key
        explained = number >= len(starts) and any(
            not excess_energy(item, noise_model, band).significant for item in found
        )
        if cause in done or explained:
            continue
        done.add(cause)
        reference, lengths, _ = reference_fits_with(start, batches, noise_model)
        advance()
        if reference is not None:
            asked = asked_for(reference.short, candidates, noise_model)
            found += fit_switched(reference.short, reference.whole, asked, lengths, noise_model, mixed)
    return found


def groups_in(posterior: Posterior) -> Groups | None:
    """Return the recordings in two groups, as the best fit that has any has them: spared, and not."""
    for item in posterior.fits:
        spared, acting = (tuple(b for b in item.batches if bool(b.off) == off) for off in (True, False))
        if spared:
            return tuple(replace(batch, off=()) for batch in spared), acting
    return None


def changed(
    nominal: ReferenceFits,
    groups: Groups | None,
    candidates: tuple[Candidate, ...],
    noise_model: NoiseModel,
    advance: Callable[[], object],
) -> list[Fit]:
    """Return fits of causes that act in one of two ``groups`` of recordings only: what this group alone shows.

    A search beside it may find its size, where what all of them ask for to first order leads astray. Not a harmonic
    force, which is of any size in each recording anyway.
    """
    grounds = [] if groups is None else _nearest_first(nominal, groups, noise_model)
    if len(grounds) < 2:
        return []
    near, (far, own) = grounds[0][0].whole, grounds[1]
    without = tuple(replace(batch, off=(len(nominal.hypothesis.candidates),)) for batch in near.batches)
    others = tuple(candidate for candidate in candidates if not isinstance(candidate, HarmonicCandidate))
    found = []
    for item in contest(far, others, own, noise_model, advance, SHORTLIST.kept_of_group)[: GROUPS.max_alike]:
        begun = None if item.hypothesis.is_linear else (*near.states, *item.states)
        found.append(fit(item.hypothesis, item.theta, (*without, *far.whole.batches), noise_model, begun))
    return [item for item in found if item is not None]


def _nearest_first(
    nominal: ReferenceFits, groups: Groups, noise_model: NoiseModel
) -> list[tuple[ReferenceFits, Lengths]]:
    """Return the nominal fits of two groups of recordings, with their segments; the one that fits better first."""
    hypothesis = nominal.hypothesis
    lengths = [lengths_of(group, hypothesis.states) for group in groups]
    grounds = [reference_fits_of(hypothesis, hypothesis.centre, own, noise_model) for own in lengths]
    pairs = [(reference, own) for reference, own in zip(grounds, lengths, strict=True) if reference is not None]
    return sorted(pairs, key=lambda pair: pair[0].whole.misfit / pair[0].whole.values)


def _seen_before(
    nominal: ReferenceFits,
    groups: Groups,
    candidates: tuple[Candidate, ...],
    noise_model: NoiseModel,
    band: Band,
    advance: Callable[[], object],
) -> list[Fit]:
    """Return the best fit to those of two groups of recordings that are nearer to the nominal structure, if any, and
    what these recordings alone hardly tell from it; none where nothing is wrong in them.
    """
    for reference, own in _nearest_first(nominal, groups, noise_model)[:1]:
        if not excess_energy(reference.whole, noise_model, band).significant and not factors_off(reference.whole):
            break
        ranked = contest(reference, candidates, own, noise_model, advance, SHORTLIST.kept_of_group)
        return [
            item
            for item in ranked[: GROUPS.max_alike]
            if item.log_evidence > ranked[0].log_evidence - GROUPS.alike_nats
        ]
    return []
