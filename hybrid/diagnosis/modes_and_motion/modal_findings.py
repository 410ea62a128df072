"""What the best claims amount to: causes with their probabilities and rivals, groups that are off, states."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes import StiffnessChange
from fe_models.causes.candidate import ChangeCandidate, LawCandidate
from hybrid.diagnosis.discrepancy.config import DISCREPANCY
from hybrid.diagnosis.discrepancy.law_search import LawSearch
from hybrid.diagnosis.modal.config import CLAIM_SCAN
from hybrid.diagnosis.modal.evidence import ModalFit
from hybrid.diagnosis.modal.misfit import misfit_of
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modal.mode_values import FREQUENCY
from hybrid.diagnosis.modes_and_motion.motion_fit import MotionFit
from hybrid.diagnosis.modes_and_motion.parts_off import parts_surely_off
from hybrid.diagnosis.nominal.nodes_at import nodes_at
from hybrid.diagnosis.outcome.findings import (
    NOT_ON_THE_LIST,
    OTHER_CAUSES,
    Alternative,
    Finding,
    built,
    parameters_of,
    sentence_of,
)

MIN_RIVAL_PROBABILITY = 0.01  # probability from which on a rival is listed by itself
ACTS_IN_SOME = "{sentence} It acts in {recordings} only."


@dataclass(frozen=True)
class State:
    """Recordings of one structure, by name: the natural ``frequencies`` (mode,), Hz, and damping ``ratios`` (mode,)
    that they show, means weighed by their uncertainty, with standard deviations of the frequencies, ``errors`` (mode,).
    """

    recordings: tuple[str, ...]
    frequencies: tuple[float, ...]
    errors: tuple[float, ...]
    ratios: tuple[float, ...]


def findings_of(
    measured: ModalData,
    fits: Sequence[ModalFit],
    probability: FloatArray,
    nominal_misfit: float,
    gains: Mapping[int, float] | None = None,
) -> tuple[Finding, ...]:
    """Return the causes of the best of the ``fits``, most important first; ``probability`` (fit,) of each claim,
    ``gains`` of changes by the number of the candidate.

    ``nominal_misfit``: of the structure as drawn; a cause explains as much of it as comes back without it.
    """
    best = fits[0]
    own = misfit_of(measured, best, best)
    found = []
    for number in range(len(best.claim.acts)):
        without = misfit_of(measured, _without(best, number), best)
        share = float(np.clip((without - own) / max(nominal_misfit, without, np.finfo(float).tiny), 0.0, 1.0))
        finding = _finding(measured, fits, probability, number, share)
        found.append(replace(finding, gain=(gains or {}).get(number)))
    return by_importance(found)


def by_importance(findings: Sequence[Finding]) -> tuple[Finding, ...]:
    """Return findings by what each explains, as surely as it does."""
    return tuple(sorted(findings, key=lambda finding: -finding.explains * finding.probability))


def law_finding(measured: ModalData, laws: LawSearch, motion: MotionFit) -> Finding:
    """Return the force law in a ``motion``, with the laws that may act in its place."""
    others, best = laws.fits[1:], motion.law or laws.fits[0]
    cause, deviations = built(best.candidate, best.theta, np.sqrt(np.diag(best.covariance)))
    parameters = parameters_of(cause, deviations)
    rivals = []
    for fit, own in zip(others, laws.probabilities[1:], strict=True):
        if own >= MIN_RIVAL_PROBABILITY:
            rival, errors = built(fit.candidate, fit.theta, np.sqrt(np.diag(fit.covariance)))
            location = fit.candidate.reported_location
            rivals.append(Alternative(rival.kind, location, float(own), parameters_of(rival, errors)))
    rest = 1 - laws.other - float(laws.probabilities[0]) - sum(item.probability for item in rivals)
    shares = ((OTHER_CAUSES, rest), (NOT_ON_THE_LIST, laws.other))
    remainder = [Alternative(kind, {}, own) for kind, own in shares if own >= MIN_RIVAL_PROBABILITY]
    names = tuple(own.name for own in measured.recordings)
    sentence = sentence_of(cause, parameters, measured.nominal.structure)
    explains = float(np.clip(1 - (motion.track.discrepancy.whole / laws.track.discrepancy.whole) ** 2, 0.0, 1.0))
    return Finding(cause, parameters, float(laws.probabilities[0]), explains, names, (*rivals, *remainder), sentence)


def probability_of_two(measured: ModalData, best: ModalFit, law: LawCandidate) -> float:
    """Return how probable it is that a law and a cause of a fit at its very place are two, and not one that is not on
    the list, which both resemble: by chance they seldom meet. One where none is there.
    """
    structure = measured.nominal.structure
    here = nodes_at(law.location, structure)
    others = [nodes_at(candidate.location, structure) for candidate in best.claim.hypothesis.candidates]
    if not here or here not in others or len(structure.nodes) == 1:
        return 1.0
    two = CLAIM_SCAN.further_probability / len(structure.nodes)
    return two / (two + DISCREPANCY.odds_off_list)


def depending_on(finding: Finding, surely: float) -> Finding:
    """Return a finding that is right only where something else is, of a probability ``surely``."""
    if surely == 1.0:
        return finding
    others = tuple(
        replace(item, probability=surely * item.probability)
        for item in finding.alternatives
        if item.kind != NOT_ON_THE_LIST
    )
    own = surely * finding.probability
    rest = 1 - own - sum(item.probability for item in others)
    remainder = (Alternative(NOT_ON_THE_LIST, {}, rest),) if rest >= MIN_RIVAL_PROBABILITY else ()
    return replace(finding, probability=own, alternatives=(*others, *remainder))


def _without(item: ModalFit, number: int) -> ModalFit:
    """Return a fit's theta as one of its claim less one cause."""
    less = item.start.less(number)
    return replace(item, claim=less.claim, theta=less.theta)


def _finding(
    measured: ModalData, fits: Sequence[ModalFit], probability: FloatArray, number: int, share: float
) -> Finding:
    """Return candidate ``number`` of the best fit, which explains a ``share`` of the misfit, with its rivals."""
    best = fits[0]
    hypothesis, acts = best.claim.hypothesis, best.claim.acts[number]
    candidate, part = hypothesis.candidates[number], hypothesis.slices[number]
    cause, deviations = built(candidate, best.theta[part], np.sqrt(np.diag(best.covariance)[part]))
    parameters = parameters_of(cause, deviations)
    names = tuple(measured.recordings[recording].name for recording in acts)
    sentence = sentence_of(cause, parameters, measured.nominal.structure)
    if len(acts) < len(measured.recordings):
        sentence = ACTS_IN_SOME.format(sentence=sentence, recordings=", ".join(names))
    named, rivals = _rivals(measured, fits, probability, number)
    return Finding(cause, parameters, named, share, names, rivals, sentence)


def _is_nominal_value(measured: ModalData, item: ModalFit, best: ModalFit, number: int) -> bool:
    """Return whether a fit without a cause of the ``best`` says the same by a nominal value, to the same side: that of
    a single element alone, too.
    """
    candidate, part = best.claim.hypothesis.candidates[number], best.claim.hypothesis.slices[number]
    own = candidate.part if isinstance(candidate, ChangeCandidate) else None
    cause = candidate.build(*best.theta[part].tolist())
    if own is None or not isinstance(cause, StiffnessChange):
        return False
    if len(best.claim.acts[number]) < len(measured.recordings) or own not in parts_surely_off(measured, item):
        return False
    if measured.nominal.parts[own].elements != (candidate.location.get("element"),):
        return False
    return bool(np.greater(cause.factor, 1).all() == (item.theta[own] + measured.offset[own] > 0))


def _rivals(
    measured: ModalData, fits: Sequence[ModalFit], probability: FloatArray, number: int
) -> tuple[float, tuple[Alternative, ...]]:
    """Return how probable candidate ``number`` of the best fit is, and what may stand in its place."""
    best = fits[0]
    wanted = best.claim.hypothesis.candidates[number].key
    others = {candidate.key for candidate in best.claim.hypothesis.candidates} - {wanted}
    named, unknown, without, rivals = 0.0, 0.0, 0.0, dict[str, tuple[Alternative, float]]()
    for item, own in zip(fits, probability, strict=True):
        candidates = item.claim.hypothesis.candidates
        if wanted in {candidate.key for candidate in candidates} or _is_nominal_value(measured, item, best, number):
            named += own
            continue
        instead = [candidate for candidate in candidates if candidate.key not in others]
        if not instead and item.claim.changed:
            unknown += own
            continue
        if not instead:  # nominal values alone
            without += own
            continue
        first = instead[0]
        known = rivals.get(first.key, (None, 0.0))[1]
        alternative = Alternative(first.kind, first.reported_location, 0.0)
        rivals[first.key] = (alternative, known + float(own))
    listed = [replace(item, probability=own) for item, own in rivals.values() if own >= MIN_RIVAL_PROBABILITY]
    rest = without + sum(own for _, own in rivals.values() if own < MIN_RIVAL_PROBABILITY)
    shares = ((OTHER_CAUSES, rest), (NOT_ON_THE_LIST, unknown))
    remainders = [Alternative(kind, {}, own) for kind, own in shares if own >= MIN_RIVAL_PROBABILITY]
    return float(named), (*sorted(listed, key=lambda item: -item.probability), *remainders)


def states_of(measured: ModalData, best: ModalFit) -> tuple[State, ...]:
    """Return the groups of recordings that the best claim distinguishes, with the modes of each."""
    groups: dict[tuple[tuple[int, ...], bool], list[int]] = {}
    for recording in range(len(measured.recordings)):
        groups.setdefault((best.claim.idle_in(recording), recording in best.claim.changed), []).append(recording)
    return tuple(_state(measured, best, group) for group in groups.values())


def _state(measured: ModalData, best: ModalFit, group: list[int]) -> State:
    """Return the state of a ``group`` of recordings: of each mode the means over these."""
    pairs, rows = best.pairs, []
    for mode in sorted(set(pairs.mode.tolist())):
        here = [n for n in np.flatnonzero(pairs.mode == mode) if pairs.recording[n] in group]
        if not here:
            continue
        seen = [(measured.recordings[pairs.recording[n]], int(pairs.measured[n])) for n in here]
        weight = np.array([1 / own.covariance[k, FREQUENCY, FREQUENCY] for own, k in seen])
        weight = weight / weight.sum()
        log = sum(w * own.log_omega[k] for w, (own, k) in zip(weight, seen, strict=True))
        variance = sum(w**2 * own.covariance[k, FREQUENCY, FREQUENCY] for w, (own, k) in zip(weight, seen, strict=True))
        ratio = sum(w * own.ratios[k] for w, (own, k) in zip(weight, seen, strict=True))
        frequency = float(np.exp(log)) / (2 * np.pi)
        rows.append((frequency, frequency * float(np.sqrt(variance)), float(ratio)))
    names = tuple(measured.recordings[recording].name for recording in group)
    frequencies, errors, ratios = zip(*rows, strict=True) if rows else ((), (), ())
    return State(names, frequencies, errors, ratios)
