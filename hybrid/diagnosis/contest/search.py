"""The contest: every cause at every place is screened, the promising ones are fitted, and the fits compared."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial

import numpy as np

from fe_models.causes.candidate import Candidate, ChangeCandidate, ForceCandidate
from fe_models.progress import nothing
from hybrid.diagnosis.contest.bounds import bound_of
from hybrid.diagnosis.contest.config import PAIRS, SEGMENTS, SHORTLIST
from hybrid.diagnosis.contest.growing import (
    Lengths,
    ReferenceFits,
    continued,
    fit_growing,
    padded,
    shortened,
)
from hybrid.diagnosis.contest.harmonic import fit_forces
from hybrid.diagnosis.contest.neighbours import laws_beside, of_other_kinds
from hybrid.diagnosis.contest.odds import Odds
from hybrid.diagnosis.contest.shortlist import (
    foremost,
    most_promising_of_each_kind,
    promising,
    with_others,
)
from hybrid.diagnosis.contest.starts import best_start, starts_of
from hybrid.diagnosis.fitting.calibration_deviation import factors_off
from hybrid.diagnosis.fitting.least_squares import Fit, Step, fit
from hybrid.diagnosis.parallel import in_chunks, parallel_map
from hybrid.diagnosis.recorded.batches import Batch
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.screening.confounded_factors import confounded_candidates
from hybrid.diagnosis.screening.modal_scan import modal_scan
from hybrid.diagnosis.screening.scanning import scan, unseen
from hybrid.diagnosis.screening.screening import Screened, screen


def contest(
    reference: ReferenceFits,
    candidates: tuple[Candidate, ...],
    lengths: Lengths,
    noise_model: NoiseModel,
    advance: Callable[[], object] = nothing,
    kept: int = SHORTLIST.kept,
    alone: Iterable[Fit] = (),
) -> tuple[Fit, ...]:
    """Return the fits of one of the ``candidates`` each on top of the ``reference``, best evidence first.

    ``alone``: fits of single causes, each of which may begin here as it ended there.
    """
    short, base = reference.short, reference.whole
    odds = Odds.among(candidates, reference.hypothesis.nominal.alike)
    taken = {candidate.key for candidate in reference.hypothesis.candidates}
    others = tuple(candidate for candidate in candidates if candidate.key not in taken)
    is_frame = short.hypothesis.nominal.kept is not None
    by_modes = modal_scan(base, others, noise_model, short) if is_frame else []
    beside_law = is_frame and not base.hypothesis.is_linear  # where each takes a march of whole recordings
    tested = screen(base, tuple(c for c in others if not (beside_law and isinstance(c, ChangeCandidate))), noise_model)
    screened = screen(short, others, noise_model)
    ranked, scanned = (
        [confounded_candidates(base, others), screened, tested, by_modes],
        scan(short, others, noise_model),
    )
    advance()
    trials = promising(ranked, scanned, kept, odds)
    if beside_law:
        trials = most_promising_of_each_kind(trials)
    trials = with_others(trials, [*unseen(short, others, noise_model), *_found_alone(short, alone)])

    def begin(chosen: list[Screened], known: Fit | None = None) -> list[Fit]:
        return _begun(reference.hypothesis, short, chosen, noise_model, odds, advance, known)

    present = begin(trials)
    if present:
        best = min(present, key=lambda item: item.charged)
        present += begin(others_there(best, [*ranked, scanned], trials), best)
        present += laws_beside(present, screened, begin)
    for longer in lengths.cut[1:]:
        present = _race(present, longer, noise_model, lengths.enough(longer), odds)
        advance()
    present += _promising_over_whole(reference, tested, present, lengths, noise_model)
    present += fit_forces(base, others, present, noise_model, advance)
    return tuple(sorted(present, key=lambda item: -item.log_evidence))


def others_there(best: Fit, ranked: list[list[Screened]], tried: list[Screened]) -> list[Screened]:
    """Return further trials of other kinds where the last cause of the ``best`` sits, if its calibration is far off."""
    if not (best.hypothesis.candidates[-1].is_structural and factors_off(best)):
        return []
    done = {trial.candidate.key for trial in tried}
    more = {(t.candidate.key, t.is_drawn): t for ranking in reversed(ranked) for t in ranking}
    return of_other_kinds(best, [trial for (key, _), trial in more.items() if key not in done and trial.gain > 0])


def _found_alone(short: Fit, alone: Iterable[Fit]) -> list[Screened]:
    """Return the best of the single causes ``alone`` that are no force laws, with the calibration that they ended with.

    Beside a law what is large is not scanned for, and its calibration may be astray where much else is wrong.
    """
    if short.hypothesis.is_linear:
        return []
    trials, nuisances = list[Screened](), short.hypothesis.nuisances
    held = {candidate.key for candidate in short.hypothesis.candidates}
    for item in alone:
        candidate = item.hypothesis.candidates[-1]
        if not isinstance(candidate, ForceCandidate) and candidate.key not in held:
            shift = np.zeros_like(short.theta)
            shift[:nuisances] = item.theta[:nuisances] - short.theta[:nuisances]
            start = tuple(item.theta[item.hypothesis.slices[-1]].tolist())
            trials.append(Screened(candidate, start, 0.0, shift, is_drawn=True))
    return trials[: PAIRS.max_found_alone]


def _promising_over_whole(
    reference: ReferenceFits, ranked: list[Screened], present: list[Fit], lengths: Lengths, noise_model: NoiseModel
) -> list[Fit]:
    """Return fits of causes that promise more over whole recordings than the best of the ``present`` takes away.

    They were behind on segments, which hide what is rare (a stop that is hit now and then beside a late sensor), or
    lead astray (a cable that is slack most of the time).
    """
    base = reference.whole
    best = min((item.charged for item in present), default=base.cost)
    wanted = base.cost - best + SEGMENTS.max_behind_share * (best - base.values)
    known = {item.hypothesis.candidates[-1].key for item in present}
    promised = {trial.candidate.key: trial for trial in reversed(ranked) if trial.gain > wanted}
    trials = [trial for key, trial in promised.items() if key not in known]

    def fitted(trial: Screened) -> Fit | None:
        hypothesis = reference.hypothesis.adding(trial.candidate)
        start = replace(reference.short, states=padded(reference.short, hypothesis))
        return fit_growing(hypothesis, trial.theta(base), lengths, noise_model, start)

    found = parallel_map(fitted, sorted(trials, key=lambda item: -item.gain)[: SEGMENTS.racing_promising])
    return [item for item in found if item is not None]


def rivals_contest(
    best: Fit,
    candidates: tuple[Candidate, ...],
    lengths: Lengths,
    noise_model: NoiseModel,
    plain: Fit,
    advance: Callable[[], object] = nothing,
) -> tuple[Fit, ...]:
    """Return fits with another cause in the place of the last but one of ``best``, which leaves nothing but noise.

    Only what comes near it on short segments is followed; ``plain``: the fit of those without any cause.
    """
    causes = best.hypothesis.candidates
    hypothesis = replace(best.hypothesis, candidates=(*causes[:-2], causes[-1]))
    both = np.delete(best.theta, np.arange(len(best.theta))[best.hypothesis.slices[-2]])
    short = fit(hypothesis, both, lengths.cut[0], noise_model, padded(plain, hypothesis), SEGMENTS.short_iterations)
    again = shortened(best, lengths.cut[0], noise_model, padded(plain, best.hypothesis))
    if short is None or again is None:
        return ()
    odds = Odds.among(candidates, hypothesis.nominal.alike)
    taken = {candidate.key for candidate in causes}
    others = tuple(candidate for candidate in candidates if candidate.key not in taken)
    trials = promising([screen(short, others, noise_model)], scan(short, others, noise_model), PAIRS.max_rivals, odds)
    present = [again, *_begun(hypothesis, short, trials, noise_model, odds, advance, again)]
    for longer in lengths.cut[1:]:
        present = _race(present, longer, noise_model, lengths.enough(longer), odds)
        advance()
    return tuple(item for item in present if item.hypothesis.candidates[-1].key not in taken)


def _begun(
    hypothesis: Hypothesis,
    short: Fit,
    trials: list[Screened],
    noise_model: NoiseModel,
    odds: Odds,
    advance: Callable[[], object],
    known: Fit | None = None,
) -> list[Fit]:
    """Return fits of one candidate more over the shortest segments; ``known``: one that others must come near.

    The first steps of each tell more than any guess; only the best after that go on.
    """
    trials = sorted(trials, key=lambda trial: -len(starts_of(trial, short)))  # what takes longest not last of all
    steps = parallel_map(partial(best_start, hypothesis, short, noise_model), trials, advance)
    begun = [(trial, step) for trial, step in zip(trials, steps, strict=True) if step is not None]
    best: dict[str, Fit] = {}
    for two in in_chunks(foremost(begun, odds)):
        bound = bound_of([*best.values(), *([] if known is None else [known])])

        def further(step: Step, bound: float = bound) -> Fit | None:
            start = step.hypothesis, step.theta, short.batches, noise_model, step.states
            return fit(*start, iterations=SEGMENTS.short_iterations, enough=SEGMENTS.enough_fall, bound=bound)

        for item in parallel_map(further, two):
            key = "" if item is None else item.hypothesis.candidates[-1].key
            if item is not None and (key not in best or item.cost < best[key].cost):
                best[key] = item
        advance()
    return list(best.values())


def _race(fits: list[Fit], longer: tuple[Batch, ...], noise_model: NoiseModel, enough: float, odds: Odds) -> list[Fit]:
    """Return the fits that are not too far behind, one of them linear in any case, continued over longer segments.

    Of more than there is time for those that lead with their ``odds``.
    """
    limit = bound_of(fits)
    found: list[Fit] = []
    beside_law = any(item.hypothesis.is_beside_law for item in fits)
    ranked = sorted(fits, key=lambda item: item.charged)
    near = min((item.charged for item in fits), default=np.inf) + SHORTLIST.tied_fall * odds.alike
    tied = sum(item.hypothesis.is_linear and item.charged <= near for item in ranked)
    most = SEGMENTS.racing_laws if beside_law else max(SEGMENTS.racing, min(tied, SHORTLIST.max_tied))
    ranked.sort(key=lambda item: item.charged + odds.price(item.hypothesis.candidates[-1]))
    racing = [item for item in ranked[:most] if item.charged <= limit]
    if not any(item.hypothesis.is_linear for item in racing):  # laws may take up what no cause explains, and hide it
        racing += [item for item in ranked if item.hypothesis.is_linear][:1]
    for two in in_chunks(racing):

        def further(item: Fit, bound: float = bound_of(found)) -> Fit | None:
            states, most = continued(item, longer), bound if item.charged <= limit else np.inf
            return fit(item.hypothesis, item.theta, longer, noise_model, states, enough=enough, bound=most)

        found += [item for item in parallel_map(further, two) if item is not None]
    return found
