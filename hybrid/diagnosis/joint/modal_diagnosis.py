"""Diagnosis by modes: of recordings, whose modes are identified first and whose motion shows force laws, or of a table.

It needs no nearly right model: nominal values may be off by far more than was stated, and how far is estimated.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from time import perf_counter

import numpy as np
from scipy.stats import norm
from threadpoolctl import threadpool_limits

from fe_models.arrays import FloatArray
from fe_models.causes import MassChange, StiffnessChange
from fe_models.causes.candidate import Candidate
from fe_models.causes.known import Channel
from fe_models.causes.places import Motion
from fe_models.causes.wording import at_place
from fe_models.errors import InputError
from fe_models.linear import LinearModel
from fe_models.modes import mac
from fe_models.recordings import Dataset
from fe_models.structure import Structure
from hybrid.diagnosis.config import THREADS
from hybrid.diagnosis.discrepancy.law_search import LawSearch
from hybrid.diagnosis.discrepancy.laws_in_recordings import Left, laws_in, left_after, without_law
from hybrid.diagnosis.joint.measured_in_dataset import as_measured, measured_in
from hybrid.diagnosis.joint.modal_findings import LISTED as LISTED_RIVAL
from hybrid.diagnosis.joint.modal_findings import State, findings_of, law_finding, states_of
from hybrid.diagnosis.modal.all_candidates import all_candidates_of
from hybrid.diagnosis.modal.claim import Measured
from hybrid.diagnosis.modal.config import CONCLUSION, FIT
from hybrid.diagnosis.modal.evidence import ModalFit, fit_claim, misfit_of
from hybrid.diagnosis.modal.paired_rows import predicted_of
from hybrid.diagnosis.modal.search import Search, null_fit, probabilities
from hybrid.diagnosis.nominal.any_model import with_parts_scaled
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.outcome.calibration import Calibrated, calibration_of
from hybrid.diagnosis.outcome.extend import extended_structure
from hybrid.diagnosis.outcome.extend_matrices import ExtendedMatrices, extended_matrices
from hybrid.diagnosis.outcome.findings import NOT_ON_THE_LIST, Alternative, Finding, Parameter, sentence_of
from hybrid.diagnosis.outcome.verdict import Verdict

CHANGES_WITH_TIME = (
    "within a recording the motion strays from that of any structure with constant values, by {size:.1%} of itself a"
    " radian: frequency or damping change with amplitude or time, and no force law on the list explains that"
)
UNKNOWN_FORCES = (
    "unknown forces, as of wind and traffic, drove {names}: no force law was looked for, and shapes have no scale, so"
    " that masses and stiffnesses are known but for a factor that all of them share"
)
MENTIONED = 0.02  # probability of a law that is mentioned all the same


@dataclass(frozen=True)
class PairedMode:
    """A measured mode beside the structure's: ``recording``; frequencies (Hz) ``measured``, with its standard deviation
    ``error``, by the ``drawn`` structure and with what was found (``extended``); damping ratio ``ratio`` and its
    standard deviation ``ratio_error``; MAC at the sensors with both.
    """

    recording: str
    measured: float
    error: float
    ratio: float
    ratio_error: float
    drawn: float | None
    extended: float | None
    mac_drawn: float | None
    mac_extended: float | None


@dataclass(frozen=True, repr=False)
class ModalDiagnosis:
    """All that modes say: ``verdict``; ``findings``, local causes first, then groups that are off by more than was
    stated; ``calibration`` of all nominal values; ``unexplained``: share of the drawn structure's misfit that is left;
    the ``states`` that recordings distinguish; every measured mode beside the structure's (``modes``); the ``extended``
    structure; ``notes``; ``seconds`` that it took; ``has_motion``: whether there were recordings, which show force
    laws, too.
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


def diagnose_modes(dataset: Dataset, advance: Callable[[str], object] | None = None) -> ModalDiagnosis:
    """Return the diagnosis of a dataset by the modes of its training recordings; ``advance`` hears what is done.

    `InputError` where the dataset has no structure, or no recording shows a mode of it.
    """
    begun, tell, dataset = perf_counter(), advance or (lambda _: None), as_measured(dataset)
    with threadpool_limits(THREADS.linear_algebra, "blas"):
        tell("modes of the recordings")
        measured, ambient = measured_in(dataset, tell)
        tell("nominal values")
        drawn = null_fit(measured)
        if drawn is None or not len(drawn.pairs):
            raise InputError("no recording shows a mode of this structure: check node numbers, directions and units")
        beside = _rebased(dataset, measured, drawn)
        search, fits = _searched(*beside, tell)
        tell("force laws")
        best = fits[0], search.log_odds(fits[0].claim)
        laws = (
            None
            if ambient or isinstance(dataset.model, LinearModel)
            else laws_in(dataset, (measured, drawn), beside, best)
        )
        if laws is not None and laws.replaces_causes and laws.named is not None:
            linear, _ = measured_in(without_law(dataset, laws), lambda _: None)
            beside = _rebased(dataset, *_refitted(linear, drawn))
            search, fits = _searched(*beside, lambda _: None)
        tell("conclusion")
        after = None if laws is None else left_after(dataset, beside[0], fits[0], laws)
        found = _concluded(beside[0], fits, probabilities(search, fits), laws, after)
        notes = (*found.notes, UNKNOWN_FORCES.format(names=", ".join(ambient))) if ambient else found.notes
    return replace(found, notes=notes, seconds=perf_counter() - begun)


def _searched(measured: Measured, null: ModalFit, tell: Callable[[str], object]) -> tuple[Search, list[ModalFit]]:
    """Return the search for causes that modes tell, and the fits of all claims, most probable first."""
    search = Search.of(measured, _candidates(measured))
    return search, search.run(null, tell)


def _refitted(measured: Measured, known: ModalFit) -> tuple[Measured, ModalFit]:
    """Return what was measured, and the fit of nothing wrong; that which is ``known`` where there is none."""
    null = null_fit(measured)
    return measured, known if null is None or not len(null.pairs) else null


def _rebased(dataset: Dataset, measured: Measured, null: ModalFit) -> tuple[Measured, ModalFit]:
    """Return what was measured beside the structure with its parts as the null fit has them, and that fit anew.

    Modes of the drawn structure are a poor basis for those of one that is off by a fifth.
    """
    for _ in range(FIT.max_rebased):
        parts = len(measured.nominal.parts)
        shift = null.theta[:parts]
        if np.abs(shift).max(initial=0.0) < FIT.max_basis_shift:
            break
        nominal = with_parts_scaled(measured.nominal, dataset, np.exp(shift))
        if len(nominal.spread) != len(measured.nominal.spread):
            break  # other patterns are felt; the older basis serves
        offset = measured.offset.copy()
        offset[:parts] += shift
        moved = replace(measured, nominal=nominal, offset=offset)
        theta = null.theta.copy()
        theta[:parts] = 0.0
        again = fit_claim(moved, moved.null, theta, null.sizes)
        if again is None or again.evidence < null.evidence:
            break
        measured, null = moved, again
    return measured, null


def _candidates(measured: Measured) -> tuple[Candidate, ...]:
    """Return all causes at all places, their priors by a motion in which each mode has as much energy as any other."""
    nominal = measured.nominal
    omega, shapes = nominal.modes
    amplitude = np.random.default_rng(0).standard_normal((200, len(omega)))
    motion = Motion((amplitude / omega) @ shapes.T, amplitude @ shapes.T)
    channels = tuple(Channel(sensor.name, 1.0, 1.0) for sensor in measured.sensors)  # of drifts, which no mode shows
    return all_candidates_of(nominal, motion, channels)


def _concluded(
    measured: Measured, fits: list[ModalFit], probability: FloatArray, laws: LawSearch | None, after: Left | None
) -> ModalDiagnosis:
    """Return what the fits amount to, most probable first, with the force laws and what is left ``after`` all."""
    best = fits[0]
    nominal, first = measured.nominal, best.nuisances
    theta = best.theta.copy()
    theta[:first] += measured.offset
    drawn = replace(best, claim=measured.null, theta=-measured.offset)
    before, rows = misfit_of(measured, drawn, best), len(best.residual)
    beyond = max(misfit_of(measured, best) - rows, 0.0)  # of what chance leaves
    left = float(np.clip(beyond / max(before - rows, beyond, np.finfo(float).tiny), 0.0, 1.0))
    local = findings_of(measured, fits, probability, before)
    if after is not None:
        local = tuple(_beside_unknown(finding, after, len(measured.recordings)) for finding in local)
    if laws is not None and laws.named is not None:
        local = (law_finding(measured, laws), *local)
    groups = _groups_off(measured, best, theta)
    widened = replace(nominal, spread=best.rows.scales(best.sizes))  # as far off as values may be here
    return ModalDiagnosis(
        verdict=_verdict(best, (*local, *groups), left, after),
        findings=(*local, *groups),
        calibration=calibration_of(widened, theta, best.covariance),
        unexplained=left,
        states=states_of(measured, best),
        modes=paired_modes(measured, drawn, best),
        extended=_extended(nominal, best.theta[:first], local),
        notes=(*_notes(measured, best), *_notes_on_motion(laws, after)),
        seconds=0.0,
        has_motion=laws is not None,
    )


def _extended(nominal: NominalModel, theta: FloatArray, local: tuple[Finding, ...]) -> Structure | ExtendedMatrices:
    """Return the model with what was found built in; ``theta`` (nuisance,)."""
    if nominal.coordinates is not None:
        return extended_matrices(nominal, theta, local)
    return extended_structure(nominal, theta, local)


def _beside_unknown(finding: Finding, after: Left, recordings: int) -> Finding:
    """Return a finding as sure as it may be where something that nobody knows changes all recordings, too: that moves
    modes as well, and whether it or the finding does is even. What differs between recordings it does not explain.
    """
    if len(set(finding.recordings)) < recordings or after.usual == 1.0:
        return finding
    surely = 0.5 * (1 + after.usual)
    others = tuple(replace(item, probability=surely * item.probability) for item in finding.alternatives)
    own = surely * finding.probability
    rest = 1 - own - sum(item.probability for item in others if item.kind != NOT_ON_THE_LIST)
    listed = tuple(item for item in others if item.kind != NOT_ON_THE_LIST)
    remainder = (Alternative(NOT_ON_THE_LIST, {}, rest),) if rest >= LISTED_RIVAL else ()
    return replace(finding, probability=own, alternatives=(*listed, *remainder))


def _groups_off(measured: Measured, best: ModalFit, theta: FloatArray) -> tuple[Finding, ...]:
    """Return a finding for each stiffness and mass that is off by more than is normal, and surely so.

    ``theta``: factors' logarithms as the user drew them. The probability is that a factor is off by more than the
    stated standard deviations, by its own uncertainty.
    """
    nominal, found = measured.nominal, []
    errors = np.sqrt(np.diag(best.covariance))
    every = tuple(own.name for own in measured.recordings)
    for number, part in enumerate(nominal.parts):
        stated, off, error = nominal.spread[number], abs(theta[number]), errors[number]
        surely = float(norm.cdf((off - CONCLUSION.normal_sigma * stated) / max(error, np.finfo(float).tiny)))
        if surely < CONCLUSION.min_probability or not (part.elements or part.group):
            continue
        factor = float(np.exp(theta[number]))
        kind = StiffnessChange if part.quantity == "stiffness" else MassChange
        cause = kind(part.elements, factor, part.group)
        parameters = {"factor": Parameter(factor, factor * float(error), "1")}
        sentence = sentence_of(cause, parameters, nominal.structure)
        found.append(Finding(cause, parameters, surely, 0.0, every, (), sentence))
    return tuple(found)


def _verdict(best: ModalFit, findings: tuple[Finding, ...], left: float, after: Left | None) -> Verdict:
    """Return the answer in a word: by the share of the drawn structure's misfit that is ``left``, and by what is left
    of the motion ``after`` all, which no law on the list explains where it is more than usual.
    """
    strange = best.claim.changed or (after is not None and not after.is_usual)
    if not findings:
        return Verdict.UNEXPLAINED if strange else Verdict.NOTHING_WRONG
    if after is not None and not after.is_usual and after.share > CONCLUSION.max_left_of_part:
        return Verdict.UNEXPLAINED if left > CONCLUSION.max_left_of_part else Verdict.PARTLY_EXPLAINED
    if after is not None and not after.is_usual:
        return Verdict.PARTLY_EXPLAINED
    if best.claim.changed or left > CONCLUSION.max_left_of_explained:
        return Verdict.PARTLY_EXPLAINED if left < CONCLUSION.max_left_of_part else Verdict.UNEXPLAINED
    return Verdict.EXPLAINED


def _notes(measured: Measured, best: ModalFit) -> tuple[str, ...]:
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
    scale = best.sizes.stiffness_scale
    if scale > CONCLUSION.worth_a_note:
        notes.append(f"stiffnesses are off by {scale:.0f} times what the dataset calls normal")
    return tuple(notes)


def _notes_on_motion(laws: LawSearch | None, after: Left | None) -> tuple[str, ...]:
    """Return what the user should know of how the motion differs from what structure and causes do by themselves."""
    if laws is None or after is None or after.is_usual:
        return ()
    about = CHANGES_WITH_TIME.format(size=after.after)
    rivals = [fit.candidate for fit, own in zip(laws.fits, laws.probabilities, strict=True) if own >= MENTIONED]
    if laws.named is None and rivals:
        about += f"; {rivals[0].kind.replace('_', ' ')} {at_place(rivals[0].reported_location)} is most like it"
    return (about,)


def paired_modes(measured: Measured, drawn: ModalFit, best: ModalFit) -> tuple[PairedMode, ...]:
    """Return every measured mode beside those of the drawn and of the extended structure."""
    sides = [_modes_beside(measured, item) for item in (drawn, best)]
    found = []
    for recording, own in enumerate(measured.recordings):
        for k in np.argsort(own.log_omega):
            (before, mac_before), (after, mac_after) = (side.get((recording, int(k)), (None, None)) for side in sides)
            frequency = float(np.exp(own.log_omega[k])) / (2 * np.pi)
            error, ratio_error = (float(np.sqrt(own.covariance[k, i, i])) for i in (0, 1))
            found.append(
                PairedMode(
                    own.name,
                    frequency,
                    frequency * error,
                    float(own.ratios[k]),
                    ratio_error,
                    before,
                    after,
                    mac_before,
                    mac_after,
                )
            )
    return tuple(found)


def _modes_beside(measured: Measured, item: ModalFit) -> dict[tuple[int, int], tuple[float, float]]:
    """Return frequency (Hz) and MAC of the structure's mode, by recording and number of the measured one."""
    found = {}
    predicted, pairs = predicted_of(measured, item.claim, item.theta)
    for recording, k, mode in zip(pairs.recording, pairs.measured, pairs.mode, strict=True):
        modes = predicted[item.claim.off(int(recording))]
        criterion = mac(measured.recordings[recording].shapes[k][:, None], modes.shapes[0, mode][:, None])
        frequency = float(np.exp(modes.log_omega[0, mode])) / (2 * np.pi)
        found[int(recording), int(k)] = (frequency, float(criterion[0, 0]))
    return found
