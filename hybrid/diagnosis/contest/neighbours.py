"""The places next to those that were found: on a frame they look alike, and the right one may not have been fitted."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import combinations
from typing import Any

from fe_models.causes.candidate import Candidate, LawCandidate
from fe_models.structure import Structure
from hybrid.diagnosis.contest.config import NEIGHBOURS
from hybrid.diagnosis.fitting.least_squares import Fit, fit
from hybrid.diagnosis.nominal.nodes_at import nodes_at
from hybrid.diagnosis.parallel import parallel_map
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.screening.screening import Screened


def fits_beside(
    best: Fit,
    base: Fit,
    candidates: tuple[Candidate, ...],
    noise_model: NoiseModel,
    advance: Callable[[], object],
    known: Sequence[Fit],
) -> list[Fit]:
    """Return fits with each cause of the ``best`` at the places next to its own, going on where one of them is better.

    On frames, and where the best leaves little of what the ``base`` does; ``known`` ones are not fitted again.
    """
    found: list[Fit] = []
    if best.hypothesis.nominal.is_chain or looks_wrong(best, base):
        return found
    tried = {item.claim for item in (best, *known)}
    for _ in range(NEIGHBOURS.max_steps):
        moved = [item for item in _moved(best, candidates) if item.claim not in tried]
        tried |= {item.claim for item in moved}
        found += [item for item in parallel_map(partial(_settled, noise_model), moved, advance) if item is not None]
        here, best = best, max((best, *found), key=lambda item: item.log_evidence)
        if best is here:
            break
    return found


def fits_tied(
    fits: Sequence[Fit],
    temper: float,
    candidates: tuple[Candidate, ...],
    noise_model: NoiseModel,
    advance: Callable[[], object],
) -> list[Fit]:
    """Return fits with the causes of the first of the ``fits``, the best, at places that do as well on a frame: next to
    those that are known to, and so on. One of them may be the right one. ``temper``: what log evidences are divided by.
    """
    best, found, tried = fits[0], list[Fit](), {item.claim for item in fits}
    if best.hypothesis.nominal.is_chain:
        return found
    least, kinds = best.log_evidence - NEIGHBOURS.as_good_nats * temper, _kinds(best)
    edge = [item for item in fits if item.log_evidence >= least and _kinds(item) == kinds]
    while edge and len(found) < NEIGHBOURS.max_fits:
        edge.sort(key=lambda item: item.log_evidence)  # a place that several lead to begins from the best of them
        moved = {start.claim: start for item in edge for start in _moved(item, candidates)}
        starts = [start for claim, start in moved.items() if claim not in tried]
        tried |= moved.keys()
        settled = [item for item in parallel_map(partial(_settled, noise_model), starts, advance) if item is not None]
        edge = [item for item in settled if item.log_evidence >= least]
        found += settled
    return found


def of_other_kinds(best: Fit, trials: Sequence[Screened]) -> list[Screened]:
    """Return those ``trials`` of structural causes that sit where the last cause of a fit does, and are of other kinds.

    A mass does what a softer beam next to it does, but for what the calibration must go along with.
    """
    structure, own = best.hypothesis.nominal.structure, best.hypothesis.candidates[-1]
    here = nodes_at(own.location, structure)
    return [
        trial
        for trial in trials
        if trial.candidate.is_structural
        and trial.candidate.kind != own.kind
        and not here.isdisjoint(nodes_at(trial.candidate.location, structure))
    ]


def laws_beside(
    present: list[Fit], trials: Sequence[Screened], begin: Callable[[list[Screened], Fit], list[Fit]]
) -> list[Fit]:
    """Return fits next to the best of the ``present``, if that is of a force law at a frame's node, and so on.

    From where ``trials`` begin, while that gets better and the best leaves more than noise: a stop that is hit in each
    period promises more at wrong places near, the right one is not among those with the most, and no fit moves there by
    itself. ``begin``: returns fits of trials.
    """
    found, best = list[Fit](), min(present, key=lambda item: item.charged)
    if best.hypothesis.nominal.is_chain:
        return found
    done = {item.hypothesis.candidates[-1].key for item in present}
    for _ in range(NEIGHBOURS.max_steps):
        if (
            not isinstance(best.hypothesis.candidates[-1], LawCandidate)
            or best.chi2 <= NEIGHBOURS.max_noise_ratio * best.values
        ):
            break
        beside = [trial for trial in _next_to(best, trials) if trial.candidate.key not in done]
        done |= {trial.candidate.key for trial in beside}
        found += begin(beside, best)
        here, best = best, min((best, *found), key=lambda item: item.charged)
        if best is here:
            break
    return found


def adjoin(item: Fit) -> bool:
    """Return whether two causes of a fit sit at one place or, on a frame, at places next to each other.

    By chance few do, unless there is one node alone: what is one cause, and none of the list, may look like both.
    """
    structure = item.hypothesis.nominal.structure
    if len(structure.nodes) == 1:
        return False
    places = [nodes_at(candidate.location, structure) for candidate in item.hypothesis.candidates]
    if item.hypothesis.nominal.is_chain:  # where most places adjoin
        return any(one == other != set() for one, other in combinations(places, 2))
    joined = [set(element.nodes) for element in structure.elements]
    return any(
        not one.isdisjoint(other) or any(not (one.isdisjoint(ends) or other.isdisjoint(ends)) for ends in joined)
        for one, other in combinations(places, 2)
    )


def looks_wrong(best: Fit, base: Fit) -> bool:
    """Return whether the best leaves so much of what the ``base`` does that its places are guesses."""
    return best.misfit > NEIGHBOURS.max_left_share * base.misfit


def _moved(item: Fit, candidates: tuple[Candidate, ...]) -> list[Fit]:
    """Return a fit with one of its causes moved to each next place: where another fit may begin.

    The cause is as large there as it was, by what is felt at either place. Not to where another one of its kind is.
    """
    moved, hypothesis = [], item.hypothesis
    taken = {candidate.key for candidate in hypothesis.candidates}
    for number, own in enumerate(hypothesis.candidates):
        for other in candidates:
            alike = other.kind == own.kind and type(other) is type(own)
            if (
                alike
                and other.key not in taken
                and _is_next(own.location, other.location, hypothesis.nominal.structure)
            ):
                moved_there = replace(other, brings=own.brings)
                causes = (*hypothesis.candidates[:number], moved_there, *hypothesis.candidates[number + 1 :])
                theta, part = item.theta.copy(), hypothesis.slices[number]
                size = (theta[part] - own.neutral) / own.width
                theta[part] = other.neutral + size * other.width
                moved.append(replace(item, hypothesis=replace(hypothesis, candidates=causes), theta=theta))
    return moved


def _next_to(best: Fit, trials: Sequence[Screened]) -> list[Screened]:
    """Return those trials of the kind of a fit's last cause that are at places next to its own."""
    structure, own = best.hypothesis.nominal.structure, best.hypothesis.candidates[-1]
    alike = [trial for trial in trials if trial.candidate.kind == own.kind]
    return [trial for trial in alike if _is_next(own.location, trial.candidate.location, structure)]


def _settled(noise_model: NoiseModel, start: Fit) -> Fit | None:
    return fit(start.hypothesis, start.theta, start.batches, noise_model, start.states)


def _kinds(item: Fit) -> tuple[str, ...]:
    return tuple(sorted(candidate.kind for candidate in item.hypothesis.candidates))


def _is_next(one: dict[str, Any], other: dict[str, Any], structure: Structure) -> bool:
    """Return whether two places are nodes that an element joins, or elements that meet, and alike in all else."""
    if "element" in one and "element" in other:
        return one != other and not nodes_at(one, structure).isdisjoint(nodes_at(other, structure))
    if "node" in one and "node" in other:
        rest = [{key: value for key, value in place.items() if key != "node"} for place in (one, other)]
        nodes = {one["node"], other["node"]}
        return rest[0] == rest[1] and any(nodes == set(element.nodes) for element in structure.elements)
    return False
