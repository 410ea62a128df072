"""What the best claims and laws amount to: verdict, findings, calibration, notes."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes import MassChange, StiffnessChange
from fe_models.recordings import Sensor
from fe_models.structure import Structure
from hybrid.diagnosis.config import SEARCH_CHOICE
from hybrid.diagnosis.discrepancy.law_search import LawSearch
from hybrid.diagnosis.discrepancy.size import Discrepancy, RemainingDiscrepancy
from hybrid.diagnosis.modal.config import CONCLUSION
from hybrid.diagnosis.modal.error_sizes import LOG_SPREADS, ErrorSizes
from hybrid.diagnosis.modal.evidence import ModalFit, as_drawn
from hybrid.diagnosis.modal.misfit import misfit_of
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modal.unsure_sizes import with_unsure_sizes
from hybrid.diagnosis.modes_and_motion.considered import ConsideredHypothesis, considered_by_modes, considered_laws
from hybrid.diagnosis.modes_and_motion.forecasts import ForecastMotion, MotionForecasts
from hybrid.diagnosis.modes_and_motion.modal_findings import (
    State,
    by_importance,
    depending_on,
    findings_of,
    law_finding,
    probability_of_two,
    states_of,
)
from hybrid.diagnosis.modes_and_motion.motion_fit import MotionFit
from hybrid.diagnosis.modes_and_motion.notes import TWO_AT_ONE_PLACE, note_on_ratios, notes_on_modes, notes_on_motion
from hybrid.diagnosis.modes_and_motion.paired_modes import PairedMode, paired_modes
from hybrid.diagnosis.modes_and_motion.parts_off import Unknown, is_off_throughout, parts_off_beside, parts_surely_off
from hybrid.diagnosis.modes_and_motion.relative_stiffness import relatively_off
from hybrid.diagnosis.modes_and_motion.unmatched_modes import UnmatchedModes, unmatched_modes
from hybrid.diagnosis.next_measurement.by_modes import next_by_modes
from hybrid.diagnosis.next_measurement.recommendation import NextMeasurement
from hybrid.diagnosis.observed.example import Example
from hybrid.diagnosis.outcome.calibration import Calibrated, calibration_of
from hybrid.diagnosis.outcome.extend import extended_structure
from hybrid.diagnosis.outcome.extend_matrices import ExtendedMatrices, extended_matrices
from hybrid.diagnosis.outcome.findings import Finding, Parameter, sentence_of
from hybrid.diagnosis.outcome.verdict import Verdict
from hybrid.identification.identification import Identification


@dataclass(frozen=True, repr=False)
class ModalDiagnosis:
    """All that modes and motion say."""

    verdict: Verdict
    findings: tuple[Finding, ...]  # local causes first, then groups that are off by more than was stated
    calibration: tuple[Calibrated, ...]  # of all nominal values
    unexplained: float  # share of the drawn structure's misfit that is left
    states: tuple[State, ...]  # that the recordings distinguish
    modes: tuple[PairedMode, ...]  # every measured mode beside the structure's
    extended: Structure | ExtendedMatrices  # the structure with what was found
    notes: tuple[str, ...]
    seconds: float  # that it took
    has_motion: bool  # whether there were recordings, which show force laws of structures, too
    forecasts: MotionForecasts | None  # of the recordings for testing, None where none were made
    groups: int  # how many of the findings, the last ones, are groups that are off
    next_measurement: NextMeasurement | None = None  # that would decide between rivals, None where there are none
    competed: tuple[str, ...] = ()  # kinds of causes
    considered: tuple[ConsideredHypothesis, ...] = ()  # by modes, most probable first
    considered_laws: tuple[ConsideredHypothesis, ...] = ()  # where laws were sought
    off_throughout: bool = False  # whether most of its stiffnesses are off, of a frame, however sure each is
    values_off: bool = False  # whether values are off by more than was stated, and that alone is known
    strays: bool = False  # whether the motion is not that of constant values, by more than any law explains
    identified: Mapping[str, Identification] = field(default_factory=dict)  # in the recordings, by their names

    @property
    def is_far(self) -> bool:
        """Whether the structure is off in more than one place by more than was stated, wherever that is."""
        return self.groups >= SEARCH_CHOICE.far_groups or self.off_throughout

    @property
    def scores(self) -> dict[str, dict[str, float | None]]:
        """The NRMSE of forecasts, as of a `Diagnosis`; None where none were made."""
        if self.forecasts is None:
            return {name: {"measured": None, "held_out": None} for name in ("baseline", "extended")}
        return self.forecasts.scores

    @property
    def example(self) -> Example | None:
        """A recording as both structures forecast it, None where no forecasts were made."""
        return None if self.forecasts is None else self.forecasts.example

    @property
    def noise_floor(self) -> float | None:
        """The NRMSE that noise alone makes, None where no forecasts were made."""
        return None if self.forecasts is None else self.forecasts.floor


@dataclass(frozen=True, eq=False)
class Claims:
    """The ``fits`` of all claims to what was ``measured``, most probable first, with their ``probability`` (fit,); what
    changes of the first one gain, ``gains``, by the number of the candidate: see `gains_of`.
    """

    measured: ModalData
    fits: list[ModalFit]
    probability: FloatArray
    gains: Mapping[int, float] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class ModesAndMotion:
    """What modes and motion say: the ``claims``; the search for force ``laws`` and the ``motion`` as it was explained,
    None where these were not looked for.
    """

    claims: Claims
    laws: LawSearch | None
    motion: ForecastMotion | None


def concluded(evidence: ModesAndMotion, present: tuple[Sensor, ...]) -> ModalDiagnosis:
    """Return what the ``evidence`` amounts to; ``present``: all sensors, also those that are never fitted."""
    claims, laws, motion = evidence.claims, evidence.laws, evidence.motion
    measured, probability = claims.measured, claims.probability
    claims = replace(claims, fits=[with_unsure_sizes(measured, claims.fits[0]), *claims.fits[1:]])
    fits, best = claims.fits, claims.fits[0]
    explained, forecasts = (None, None) if motion is None else (motion.explained, motion.forecasts)
    drawn, remaining = as_drawn(measured, best), _remaining(laws, motion)
    before, left = _misfit(measured, drawn, best, forecasts)
    unmatched = unmatched_modes(measured, best)
    exchanged = any(own.exchanged for own in unmatched)
    local = _with_law(measured, best, laws, explained, _causes(claims, before, remaining))
    groups = _groups_off(measured, best, _unknown(laws, remaining, local.listed))
    findings = (*local.findings, *groups)
    nothing_else = not (findings or best.claim.changed or exchanged)
    alone = parts_surely_off(measured, best)
    ratios = [own for own in relatively_off(measured, best) if own.part not in alone]
    meeting = [TWO_AT_ONE_PLACE] * (local.two < 1)
    return ModalDiagnosis(
        verdict=_verdict(best, findings, left, remaining, local.listed, unmatched),
        findings=findings,
        calibration=_calibration(measured, best),
        unexplained=1.0 if exchanged and not findings else left,
        states=states_of(measured, best),
        modes=paired_modes(measured, drawn, best),
        extended=_extended(measured, best.theta[: best.nuisances], local.findings),
        notes=(
            *notes_on_modes(measured, best, unmatched),
            *note_on_ratios(measured, ratios),
            *notes_on_motion(laws, remaining),
            *meeting,
        ),
        seconds=0.0,
        has_motion=motion is not None,
        forecasts=forecasts,
        groups=len(groups),
        off_throughout=not measured.nominal.is_chain and is_off_throughout(measured, best),
        next_measurement=next_by_modes(measured, fits, probability, present),
        considered=considered_by_modes(measured, fits, probability),
        considered_laws=() if laws is None else considered_laws(laws),
        values_off=best.sizes.values_are_off and nothing_else,
        strays=remaining is not None and not remaining.after.is_usual,
    )


def _remaining(laws: LawSearch | None, motion: ForecastMotion | None) -> RemainingDiscrepancy | None:
    """Return what is left of the motion beside the law that was found, if any; None where no laws were looked for, or
    where forecasts reach the noise, so that it is of no consequence.
    """
    if laws is None or motion is None or (motion.forecasts is not None and motion.forecasts.reach_noise):
        return None
    return RemainingDiscrepancy(laws.track.discrepancy, motion.explained.track.discrepancy)


def _misfit(
    measured: ModalData, drawn: ModalFit, best: ModalFit, forecasts: MotionForecasts | None
) -> tuple[float, float]:
    """Return the misfit of the ``drawn`` structure, and which share of that beyond chance the ``best`` fit leaves."""
    before, rows = misfit_of(measured, drawn, best), len(best.residual)
    beyond = max(misfit_of(measured, best, best) - rows, 0.0)  # of what chance leaves
    left = float(np.clip(beyond / max(before - rows, beyond, np.finfo(float).tiny), 0.0, 1.0))
    if forecasts is not None and forecasts.reach_noise:  # of modes that hardly differ any share may be left
        left = min(left, forecasts.unexplained)
    return before, left


def _causes(claims: Claims, misfit: float, remaining: RemainingDiscrepancy | None) -> tuple[Finding, ...]:
    """Return the causes of the best claim, each as sure as it may be beside what is left of the motion; ``misfit`` of
    the drawn structure.
    """
    measured = claims.measured
    found = findings_of(measured, claims.fits, claims.probability, misfit, claims.gains)
    if remaining is None:
        return found
    return by_importance([_beside_unknown(finding, remaining.after, len(measured.recordings)) for finding in found])


@dataclass(frozen=True)
class _LocalFindings:
    """The ``findings`` that have a place, a law first; how probable it is that the law and a cause at its very place
    are ``two``, and that what moves in time is ``listed`` among the causes.
    """

    findings: tuple[Finding, ...]
    two: float = 1.0
    listed: float = 1.0


def _with_law(
    measured: ModalData,
    best: ModalFit,
    laws: LawSearch | None,
    explained: MotionFit | None,
    causes: tuple[Finding, ...],
) -> _LocalFindings:
    """Return the force law that explains the motion, if any, before the ``causes`` of the ``best`` claim."""
    if laws is None or explained is None or explained.law is None:
        return _LocalFindings(causes)
    two = probability_of_two(measured, best, explained.law.candidate)
    listed = two * (1 - laws.other)
    law = depending_on(law_finding(measured, laws, explained), two)
    return _LocalFindings((law, *(depending_on(cause, listed) for cause in causes)), two, listed)


def _calibration(measured: ModalData, best: ModalFit) -> tuple[Calibrated, ...]:
    """Return all nominal values with what was stated of them widened by the scales that the modes ask for, as far as
    these may be off: one of them is one of many.
    """
    spread = np.exp(LOG_SPREADS.max()) * best.rows.scales(best.sizes)
    theta = best.theta.copy()
    theta[: best.nuisances] += measured.offset
    return calibration_of(replace(measured.nominal, spread=spread), theta, best.covariance)


def _extended(measured: ModalData, theta: FloatArray, local: tuple[Finding, ...]) -> Structure | ExtendedMatrices:
    """Return the model with what was found built in; ``theta`` (nuisance,)."""
    if measured.nominal.coordinates is not None:
        return extended_matrices(measured.nominal, measured.offset, theta, local)
    return extended_structure(measured.nominal, theta, local)


def _beside_unknown(finding: Finding, left: Discrepancy, recordings: int) -> Finding:
    """Return a finding as sure as it may be where something that nobody knows changes all recordings, too: that moves
    modes as well, and whether it or the finding does is even. What differs between recordings it does not explain.
    """
    if len(set(finding.recordings)) < recordings:
        return finding
    return depending_on(finding, 0.5 * (1 + left.usual_probability))


def _unknown(laws: LawSearch | None, remaining: RemainingDiscrepancy | None, listed: float) -> Unknown | None:
    """Return what may act that no cause on the list is: in the place of the law that was found, ``listed`` with some
    probability, or beside all that was found.
    """
    found = [] if laws is None else [Unknown(1 - listed, laws.track.discrepancy.whole)]
    if remaining is not None:
        found.append(Unknown(1 - remaining.after.usual_probability, remaining.after.whole))
    return max(found, key=lambda own: own.probability, default=None)


def _groups_off(measured: ModalData, best: ModalFit, unknown: Unknown | None) -> tuple[Finding, ...]:
    """Return a finding for each stiffness and mass that is off by more than is normal, also beside what is
    ``unknown``.
    """
    nominal, found = measured.nominal, []
    errors, total = np.sqrt(np.diag(best.covariance)), best.theta[: best.nuisances] + measured.offset
    every = tuple(own.name for own in measured.recordings)
    for number, surely in parts_off_beside(measured, best, unknown).items():
        part, error = nominal.parts[number], errors[number]
        factor = float(np.exp(total[number]))
        kind = StiffnessChange if part.quantity == "stiffness" else MassChange
        cause = kind(part.elements, factor, part.group)
        parameters = {"factor": Parameter(factor, factor * float(error), "1")}
        sentence = sentence_of(cause, parameters, nominal.structure)
        found.append(Finding(cause, parameters, surely, 0.0, every, (), sentence))
    return tuple(found)


def _verdict(
    best: ModalFit,
    findings: tuple[Finding, ...],
    left: float,
    remaining: RemainingDiscrepancy | None,
    listed: float,
    unmatched: Sequence[UnmatchedModes],
) -> Verdict:
    """Return the answer in a word: by the share of the drawn structure's misfit that is ``left``, and by what is
    ``remaining`` of the motion, which no law on the list explains where it is more than usual; by whether what moves in
    time is surely one that is ``listed``. Of a structure that has few of the measured modes, most being ``unmatched``,
    or of modes with one another's shapes, nobody says it is right; nor of one whose values are off, whichever.
    """
    unusual = best.sizes.frequency > CONCLUSION.max_usual_frequency * ErrorSizes().frequency
    alone = sum(len(own.exchanged) + len(own.others) for own in unmatched)
    unusual |= len(best.pairs) < CONCLUSION.min_paired * (len(best.pairs) + alone)
    unusual |= any(own.exchanged for own in unmatched)
    strays = remaining is not None and not remaining.after.is_usual
    strange = best.claim.changed or unusual or strays or best.sizes.values_are_off
    if not findings:
        return Verdict.UNEXPLAINED if strange else Verdict.NOTHING_WRONG
    if remaining is not None and strays and remaining.share > CONCLUSION.max_left_of_part:
        return Verdict.UNEXPLAINED if left > CONCLUSION.max_left_of_part else Verdict.PARTLY_EXPLAINED
    if strays:
        return Verdict.PARTLY_EXPLAINED
    if best.claim.changed or left > CONCLUSION.max_left_of_explained or listed < CONCLUSION.min_probability:
        return Verdict.PARTLY_EXPLAINED if left < CONCLUSION.max_left_of_part else Verdict.UNEXPLAINED
    return Verdict.EXPLAINED
