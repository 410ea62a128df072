"""Two causes at once: looked for where one leaves more than noise, or bends the calibration beyond what is normal."""

from collections.abc import Callable
from dataclasses import replace

from fe_models.causes.candidate import Candidate, LawCandidate
from hybrid.diagnosis.contest.bounds import bound_of
from hybrid.diagnosis.contest.config import PAIRS
from hybrid.diagnosis.contest.effort import effort_of
from hybrid.diagnosis.contest.growing import Lengths, ReferenceFits, lengths_of, padded, reference_fits_of, short_fit
from hybrid.diagnosis.contest.posterior import Posterior
from hybrid.diagnosis.contest.search import contest, rivals_contest
from hybrid.diagnosis.fitting.calibration_deviation import factors_off
from hybrid.diagnosis.fitting.excess_energy import excess_energy
from hybrid.diagnosis.fitting.least_squares import Fit, fit
from hybrid.diagnosis.parallel import parallel_map
from hybrid.diagnosis.recorded.batches import Batch
from hybrid.diagnosis.recorded.noise import Band
from hybrid.diagnosis.recorded.noise_model import NoiseModel


def asks_for_more(item: Fit, base: Fit, noise_model: NoiseModel, band: Band) -> bool:
    """Return whether a second cause should be looked for: something is left, and the first took away enough.

    What a fit fails by is its excess and the deviation of its calibration together: factors far beyond what their owner
    thinks normal may hide any error.
    """
    if not item.hypothesis.candidates:
        return False
    astray, effort = factors_off(item), effort_of(item.hypothesis.nominal)
    if explains_change(item, base) and not (effort.thorough and astray):
        return False
    if not excess_energy(item, noise_model, band).significant:
        return astray
    return item.misfit <= PAIRS.max_single_share * base.misfit


def pair_fits(
    posterior: Posterior,
    candidates: tuple[Candidate, ...],
    batches: tuple[Batch, ...],
    noise_model: NoiseModel,
    band: Band,
    advance: Callable[[], object],
) -> list[Fit]:
    """Return fits of two causes: the best single ones each with all others, and what may stand in the first's place.

    That is looked for where nothing but noise is left, on a chain after each second cause that gains enough, and on a
    frame once, where the second takes away most of what the first leaves, and much is left: the first may only have
    stood for the right one. Each of the best two alone, too.
    """
    singles = [
        item for item in posterior.fits if item.hypothesis.candidates and not any(batch.off for batch in item.batches)
    ]
    effort, bound = effort_of(posterior.fits[0].hypothesis.nominal), bound_of(singles)
    starts = [item for item in singles[: PAIRS.max_firsts] if effort.thorough or item.charged <= bound]
    nominal = next((item for item in posterior.fits if not item.hypothesis.candidates), None)
    found: list[Fit] = []
    done: set[str] = set()
    turns, anew = effort.contests, False
    while starts and turns:
        turns -= 1
        start = starts.pop(0)
        first = start.hypothesis.candidates[-1]
        if first.key in done:
            continue
        done.add(first.key)
        reference, lengths, plain = reference_fits_with(start, batches, noise_model)
        advance()
        seconds = (
            () if reference is None else contest(reference, candidates, lengths, noise_model, advance, alone=singles)
        )
        if reference is None or not seconds:
            continue
        best = seconds[0]
        found += [*seconds, *each_alone(best, noise_model)]
        next_single = effort.thorough or len(start.hypothesis.candidates) == 1
        least = min(found, key=lambda item: item.misfit)
        if len(done) > 1 and next_single and nominal is not None and is_hopeless(least, nominal):
            break
        if not excess_energy(best, noise_model, band).significant and not factors_off(best):
            return found + list(rivals_contest(best, candidates, lengths, noise_model, plain, advance))
        gained = (best.log_evidence - reference.whole.log_evidence) / posterior.temper
        if effort.thorough and gained >= PAIRS.min_second_nats:
            starts.insert(0, best)
        elif not (effort.thorough or anew) and _is_halved(reference.whole, best):
            starts, turns, anew = [best, *starts], turns + 1, True
    return found


def _is_halved(first: Fit, pair: Fit) -> bool:
    """Return whether the second cause of a ``pair`` takes away most of what the ``first`` leaves, and leaves much.

    Not a force law, beside which a search takes a minute of a frame.
    """
    leaves_much = pair.chi2 > PAIRS.max_left_ratio * pair.values
    return (
        leaves_much
        and not isinstance(pair.hypothesis.candidates[-1], LawCandidate)
        and pair.misfit < PAIRS.max_halved_share * first.misfit
    )


def reference_fits_with(
    start: Fit, batches: tuple[Batch, ...], noise_model: NoiseModel
) -> tuple[ReferenceFits | None, Lengths, Fit]:
    """Return what a second cause is held against: the last cause of a fit alone, in all recordings.

    None where it has no fit; with the segments, and the nominal fit of the shortest.
    """
    others = tuple(range(len(start.hypothesis.candidates) - 1))
    hypothesis, theta = start.hypothesis.less(others), start.theta[start.hypothesis.parameters_of(others)]
    lengths = lengths_of(batches, hypothesis.states)
    plain = short_fit(hypothesis.nominal, lengths, noise_model)
    quiet = replace(plain, states=padded(plain, hypothesis))
    return reference_fits_of(hypothesis, theta, lengths, noise_model, quiet), lengths, plain


def each_alone(pair: Fit, noise_model: NoiseModel) -> list[Fit]:
    """Return fits of each cause of a ``pair`` without the other, which may only have led the search to it.

    Where two supports give way, the one kept begins with the other's motion; it matters beside force laws only.
    """
    both = pair.hypothesis

    def alone(number: int) -> Fit | None:
        off = tuple(other for other in range(len(both.candidates)) if other != number)
        states = tuple(part[:, both.states_of(off)] for part in pair.states)
        return fit(both.less(off), pair.theta[both.parameters_of(off)], pair.batches, noise_model, states)

    return [item for item in parallel_map(alone, range(len(both.candidates))) if item is not None]


def explains_change(item: Fit, base: Fit) -> bool:
    """Return whether one cause that acts in some recordings only leaves next to nothing of what the ``base`` does."""
    changes = len(item.hypothesis.candidates) == 1 and any(batch.off for batch in item.batches)
    return changes and item.misfit < PAIRS.max_sorted_share * base.misfit


def is_hopeless(best: Fit, base: Fit) -> bool:
    """Return whether the best of two causes leaves so much of what the ``base`` does that neither is likely right."""
    return best.misfit > PAIRS.max_pair_share * base.misfit
