"""What the best claims and laws amount to: verdict, findings, calibration, notes."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes import MassChange, StiffnessChange
from fe_models.causes.wording import at_place
from fe_models.recordings import Sensor
from fe_models.structure import Structure
from hybrid.diagnosis.config import DOOR
from hybrid.diagnosis.discrepancy.law_search import LawSearch
from hybrid.diagnosis.discrepancy.size import Discrepancy, RemainingDiscrepancy
from hybrid.diagnosis.modal.config import CONCLUSION
from hybrid.diagnosis.modal.error_sizes import LOG_SPREADS, ErrorSizes
from hybrid.diagnosis.modal.evidence import ModalFit, as_drawn, misfit_of
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modal.unsure_sizes import with_unsure_sizes
from hybrid.diagnosis.modes_and_motion.considered import Considered, considered_by_modes, considered_laws
from hybrid.diagnosis.modes_and_motion.forecasts import Forecasts, FoundMotion
from hybrid.diagnosis.modes_and_motion.found import Found
from hybrid.diagnosis.modes_and_motion.look import surely_off
from hybrid.diagnosis.modes_and_motion.modal_findings import (
    State,
    as_sure,
    by_importance,
    findings_of,
    law_finding,
    share_of_two,
    states_of,
)
from hybrid.diagnosis.modes_and_motion.paired_modes import PairedMode, paired_modes
from hybrid.diagnosis.next_measurement.by_modes import next_by_modes
from hybrid.diagnosis.next_measurement.recommendation import NextMeasurement
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.observed.example import Example
from hybrid.diagnosis.outcome.calibration import Calibrated, calibration_of
from hybrid.diagnosis.outcome.extend import extended_structure
from hybrid.diagnosis.outcome.extend_matrices import ExtendedMatrices, extended_matrices
from hybrid.diagnosis.outcome.findings import Finding, Parameter, sentence_of
from hybrid.diagnosis.outcome.verdict import Verdict
from hybrid.identification.identification import Identification

CHANGES_WITH_TIME = (
    "within a recording the motion strays from that of any structure with constant values, each mode by {size:.1%} of"
    " itself a radian, and {share:.1%} of what sensors show is of no mode of it: frequency or damping change with"
    " amplitude or time, or modes are missing, and no force law on the list explains that"
)
DOUBTED = (
    "what {name} shows at {listed} Hz is that of no structure that has the other modes, too: it was given little weight"
)
TWO_AT_ONE_PLACE = (
    "a force law and another cause at the very place of it are seldom two: one thing that is not on the list may look"
    " like both"
)
MENTIONED = 0.02  # probability of a law that is mentioned all the same


@dataclass(frozen=True, repr=False)
class ModalDiagnosis:
    """All that modes say: ``verdict``; ``findings``, local causes first, then groups that are off by more than was
    stated; ``calibration`` of all nominal values; ``unexplained``: share of the drawn structure's misfit that is left;
    the ``states`` that recordings distinguish; every measured mode beside the structure's (``modes``); the ``extended``
    structure; ``notes``; ``seconds`` that it took; ``has_motion``: whether there were recordings, which show force
    laws of structures, too; ``forecasts`` of those for testing, None where none were made; ``groups``: how many of the
    findings, the last ones, are groups that are off; ``next_measurement``: which would decide between rivals, None
    where there are none. Which kinds of causes ``competed``; what was ``considered``, most probable first, and
    ``considered_laws``, where these were sought; whether the motion ``strays`` from that of constant values by more
    than any law explains; what was ``identified`` in the recordings, by their names.
    """

    verdict: Verdict
    findings: tuple[Finding, ...]
    calibration: tuple[Calibrated, ...]
    unexplained: float
    states: tuple[State, ...]
    modes: tuple[PairedMode, ...]
    extended: Structure | ExtendedMatrices
    notes: tuple[str, ...]
    seconds: float
    has_motion: bool
    forecasts: Forecasts | None
    groups: int
    next_measurement: NextMeasurement | None = None
    competed: tuple[str, ...] = ()
    considered: tuple[Considered, ...] = ()
    considered_laws: tuple[Considered, ...] = ()
    strays: bool = False
    identified: Mapping[str, Identification] = field(default_factory=dict)

    @property
    def is_far(self) -> bool:
        """Whether the structure is off in more than one place by more than was stated."""
        return self.groups >= DOOR.far_groups

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


def concluded(
    claims: Claims, laws: LawSearch | None, motion: FoundMotion | None, present: tuple[Sensor, ...]
) -> ModalDiagnosis:
    """Return what the claims amount to, with the force laws and what was found of the ``motion``; ``present``: all
    sensors, also those that are never fitted.
    """
    measured, probability = claims.measured, claims.probability
    claims = replace(claims, fits=[with_unsure_sizes(measured, claims.fits[0]), *claims.fits[1:]])
    fits, best = claims.fits, claims.fits[0]
    found, forecasts = (None, None) if motion is None else (motion.found, motion.forecasts)
    drawn, remaining = as_drawn(measured, best), _remaining(laws, motion)
    before, left = _misfit(measured, drawn, best, forecasts)
    local, both, listed = _with_law(measured, best, laws, found, _local(claims, before, remaining))
    groups = _groups_off(measured, best)
    return ModalDiagnosis(
        verdict=_verdict(measured, best, (*local, *groups), left, remaining, listed),
        findings=(*local, *groups),
        calibration=_calibration(measured, best),
        unexplained=left,
        states=states_of(measured, best),
        modes=paired_modes(measured, drawn, best),
        extended=_extended(measured.nominal, best.theta[: best.nuisances], local),
        notes=(*_notes(measured, best), *_notes_on_motion(laws, remaining), *[TWO_AT_ONE_PLACE] * (both < 1)),
        seconds=0.0,
        has_motion=motion is not None,
        forecasts=forecasts,
        groups=len(groups),
        next_measurement=next_by_modes(measured, fits, probability, present),
        considered=considered_by_modes(measured, fits, probability),
        considered_laws=() if laws is None else considered_laws(laws),
        strays=remaining is not None and not remaining.after.is_usual,
    )


def _remaining(laws: LawSearch | None, motion: FoundMotion | None) -> RemainingDiscrepancy | None:
    """Return what is left of the motion beside the law that was found, if any; None where no laws were looked for, or
    where forecasts reach the noise, so that it is of no consequence.
    """
    if laws is None or motion is None or (motion.forecasts is not None and motion.forecasts.reach_noise):
        return None
    return RemainingDiscrepancy(laws.track.discrepancy, motion.found.track.discrepancy)


def _misfit(measured: ModalData, drawn: ModalFit, best: ModalFit, forecasts: Forecasts | None) -> tuple[float, float]:
    """Return the misfit of the ``drawn`` structure, and which share of that beyond chance the ``best`` fit leaves."""
    before, rows = misfit_of(measured, drawn, best), len(best.residual)
    beyond = max(misfit_of(measured, best, best) - rows, 0.0)  # of what chance leaves
    left = float(np.clip(beyond / max(before - rows, beyond, np.finfo(float).tiny), 0.0, 1.0))
    if forecasts is not None and forecasts.reach_noise:  # of modes that hardly differ any share may be left
        left = min(left, forecasts.unexplained)
    return before, left


def _local(claims: Claims, misfit: float, remaining: RemainingDiscrepancy | None) -> tuple[Finding, ...]:
    """Return the causes of the best claim, each as sure as it may be beside what is left of the motion; ``misfit`` of
    the drawn structure.
    """
    measured = claims.measured
    found = findings_of(measured, claims.fits, claims.probability, misfit, claims.gains)
    if remaining is None:
        return found
    return by_importance([_beside_unknown(finding, remaining.after, len(measured.recordings)) for finding in found])


def _with_law(
    measured: ModalData, best: ModalFit, laws: LawSearch | None, found: Found | None, local: tuple[Finding, ...]
) -> tuple[tuple[Finding, ...], float, float]:
    """Return the force law that was ``found``, if any, before all other findings; and the probabilities that it and a
    cause at its very place are two, and that what moves in time is on the list.
    """
    if laws is None or found is None or found.law is None:
        return local, 1.0, 1.0
    both = share_of_two(measured, best, found.law.candidate)
    listed = both * (1 - laws.other)
    law = as_sure(law_finding(measured, laws, found), both)
    return (law, *(as_sure(finding, listed) for finding in local)), both, listed


def _calibration(measured: ModalData, best: ModalFit) -> tuple[Calibrated, ...]:
    """Return all nominal values with what was stated of them widened by the scales that the modes ask for, as far as
    these may be off: one of them is one of many.
    """
    spread = np.exp(LOG_SPREADS.max()) * best.rows.scales(best.sizes)
    theta = best.theta.copy()
    theta[: best.nuisances] += measured.offset
    return calibration_of(replace(measured.nominal, spread=spread), theta, best.covariance)


def _extended(nominal: NominalModel, theta: FloatArray, local: tuple[Finding, ...]) -> Structure | ExtendedMatrices:
    """Return the model with what was found built in; ``theta`` (nuisance,)."""
    if nominal.coordinates is not None:
        return extended_matrices(nominal, theta, local)
    return extended_structure(nominal, theta, local)


def _beside_unknown(finding: Finding, left: Discrepancy, recordings: int) -> Finding:
    """Return a finding as sure as it may be where something that nobody knows changes all recordings, too: that moves
    modes as well, and whether it or the finding does is even. What differs between recordings it does not explain.
    """
    if len(set(finding.recordings)) < recordings:
        return finding
    return as_sure(finding, 0.5 * (1 + left.usual_probability))


def _groups_off(measured: ModalData, best: ModalFit) -> tuple[Finding, ...]:
    """Return a finding for each stiffness and mass that is off by more than is normal, and surely so."""
    nominal, found = measured.nominal, []
    errors, total = np.sqrt(np.diag(best.covariance)), best.theta[: best.nuisances] + measured.offset
    every = tuple(own.name for own in measured.recordings)
    for number, surely in surely_off(measured, best).items():
        part, error = nominal.parts[number], errors[number]
        factor = float(np.exp(total[number]))
        kind = StiffnessChange if part.quantity == "stiffness" else MassChange
        cause = kind(part.elements, factor, part.group)
        parameters = {"factor": Parameter(factor, factor * float(error), "1")}
        sentence = sentence_of(cause, parameters, nominal.structure)
        found.append(Finding(cause, parameters, surely, 0.0, every, (), sentence))
    return tuple(found)


def _verdict(
    measured: ModalData,
    best: ModalFit,
    findings: tuple[Finding, ...],
    left: float,
    remaining: RemainingDiscrepancy | None,
    listed: float,
) -> Verdict:
    """Return the answer in a word: by the share of the drawn structure's misfit that is ``left``, and by what is
    ``remaining`` of the motion, which no law on the list explains where it is more than usual; by whether what moves in
    time is surely one that is ``listed``. Of a structure that has few of the measured modes nobody says it is right.
    """
    unusual = best.sizes.frequency > CONCLUSION.worth_a_note * ErrorSizes().frequency
    unusual |= len(best.pairs) < CONCLUSION.min_paired * measured.modes
    strays = remaining is not None and not remaining.after.is_usual
    strange = best.claim.changed or unusual or strays
    if not findings:
        return Verdict.UNEXPLAINED if strange else Verdict.NOTHING_WRONG
    if remaining is not None and strays and remaining.share > CONCLUSION.max_left_of_part:
        return Verdict.UNEXPLAINED if left > CONCLUSION.max_left_of_part else Verdict.PARTLY_EXPLAINED
    if strays:
        return Verdict.PARTLY_EXPLAINED
    if best.claim.changed or left > CONCLUSION.max_left_of_explained or listed < CONCLUSION.min_probability:
        return Verdict.PARTLY_EXPLAINED if left < CONCLUSION.max_left_of_part else Verdict.UNEXPLAINED
    return Verdict.EXPLAINED


def _notes(measured: ModalData, best: ModalFit) -> tuple[str, ...]:
    """Return what the user should know: changes without a name, modes that are none of the structure's."""
    notes = []
    if best.claim.changed:
        names = ", ".join(measured.recordings[recording].name for recording in best.claim.changed)
        notes.append(f"the structure was another one in {names}, and no single cause on the list explains the change")
    for recording, own in enumerate(measured.recordings):
        paired = set(best.pairs.measured[best.pairs.recording == recording].tolist())
        alone = [np.exp(log) / (2 * np.pi) for k, log in enumerate(own.log_omega) if k not in paired]
        if alone:
            listed = ", ".join(f"{frequency:.4g}" for frequency in sorted(alone))
            notes.append(f"{own.name} shows modes that are none of the structure's, at {listed} Hz")
        doubted = [
            np.exp(own.log_omega[mode]) / (2 * np.pi)
            for (where, mode), factors in best.inflation.items()
            if where == recording and mode in paired and factors.frequency > CONCLUSION.doubted_sigma
        ]
        if doubted:
            listed = ", ".join(f"{frequency:.4g}" for frequency in sorted(doubted))
            notes.append(DOUBTED.format(name=own.name, listed=listed))
    scale = best.sizes.stiffness_scale
    if scale > CONCLUSION.worth_a_note:
        notes.append(f"stiffnesses are off by {scale:.0f} times what the dataset calls normal")
    return tuple(notes)


def _notes_on_motion(laws: LawSearch | None, remaining: RemainingDiscrepancy | None) -> tuple[str, ...]:
    """Return what the user should know of how the motion differs from what structure and causes do by themselves."""
    if laws is None or remaining is None or remaining.after.is_usual:
        return ()
    about = CHANGES_WITH_TIME.format(**vars(remaining.after))
    rivals = [fit.candidate for fit, own in zip(laws.fits, laws.probabilities, strict=True) if own >= MENTIONED]
    if laws.named is None and rivals:
        about += f"; {rivals[0].kind.replace('_', ' ')} {at_place(rivals[0].reported_location)} is most like it"
    return (about,)
