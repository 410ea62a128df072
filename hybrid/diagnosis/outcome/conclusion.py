"""From evidence to what a report says: verdict, findings, extended structure, and forecasts before and after."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fe_models.dofs import FloatArray
from fe_models.structure import Structure
from hybrid.diagnosis.causes.candidate import Candidate
from hybrid.diagnosis.contest.evidence import Evidence
from hybrid.diagnosis.contest.pairs import factors_off, left
from hybrid.diagnosis.contest.posterior import Posterior, of_candidate, rivals_of
from hybrid.diagnosis.contest.setting import Setting
from hybrid.diagnosis.fitting.fitting import Fit, residuals_at
from hybrid.diagnosis.fitting.forecasting import DEVIATION, Forecast, model_of, within
from hybrid.diagnosis.nominal.plant import Plant
from hybrid.diagnosis.outcome.acting import recordings_of
from hybrid.diagnosis.outcome.advice import Advice, advise
from hybrid.diagnosis.outcome.extend import extended_structure
from hybrid.diagnosis.outcome.findings import (
    Finding,
    at_place,
    cause_of,
    is_held,
    place_words,
    reported_location,
    sentence_of,
)
from hybrid.diagnosis.outcome.materiality import material, weak, without_weak
from hybrid.diagnosis.outcome.scorer import Scorer
from hybrid.diagnosis.outcome.simulation import Simulation, modal_finding, modal_notes, simulation_of
from hybrid.diagnosis.outcome.verdict import ABNORMAL, Errors, Verdict, verdict_of
from hybrid.diagnosis.recorded.frame import Frame
from hybrid.diagnosis.shown.example import Example, example_of
from hybrid.diagnosis.shown.show import Shown, show

RIVALS = 0.005  # least probability of an alternative that is told
SUREST = 0.999  # no probability is said to be more
UNSEEN = (
    "the training recordings show nothing{more} wrong, the test recordings do: what acts there is not felt in those;"
    " train on recordings that show it"
)


@dataclass(frozen=True)
class Diagnosis:
    """All that a report says; ``notes`` what the user should know about the data."""

    verdict: Verdict
    findings: tuple[Finding, ...]
    calibration: tuple[tuple[str, dict[str, Any], float, float], ...]
    unexplained: float
    scores: dict[str, dict[str, float | None]]
    noise_floor: float
    extended: Structure
    shown: Shown
    example: Example
    advice: tuple[Advice, ...]
    posterior: Posterior
    notes: tuple[str, ...]
    seconds: float


def concluded(setting: Setting, evidence: Evidence) -> Diagnosis:
    """Return the diagnosis that the evidence amounts to."""
    base, frame, dataset = evidence.base, evidence.frame, setting.dataset
    scorer = Scorer.of(setting, evidence)
    posterior, notes = material(evidence, scorer)
    if setting.modal is not None:
        posterior, immaterial = without_weak(posterior, evidence, scorer)
        notes += immaterial
    best = posterior.fits[0]
    simulation = simulation_of(setting, evidence, posterior, scorer)
    normal = DEVIATION if best.hypothesis.candidates else ABNORMAL  # no cause is likelier than a value that far off
    nominal, calibrated, extended = (
        scorer.forecast(item, most) for item, most in ((simulation.fit, 0.0), (simulation.fit, normal), (best, np.inf))
    )
    drawn, own = nominal, calibrated  # of the structure itself
    if simulation.fit is not base:
        drawn, own = (scorer.forecast(base, most) for most in (0.0, normal))
    unexplained = _share_left(extended, nominal)
    errors = Errors(scorer.error(calibrated), scorer.error(extended), scorer.floor(own), unexplained)
    wrong = simulation.fit if simulation.is_wrong else base
    verdict, listed = verdict_of(best, evidence.posterior.fits[0], wrong, frame, setting.band, errors)
    named = verdict in (Verdict.EXPLAINED, Verdict.PARTLY_EXPLAINED)
    final, theta = (best, best.theta) if named else _as_drawn_or_calibrated(base, frame, normal)
    findings: tuple[Finding, ...] = ()
    if named:
        findings = _findings(setting, scorer, posterior, simulation, (nominal, drawn), listed)
        notes += _apart(setting, findings)
        if not errors.near and not left(best, frame, setting.band).significant and not factors_off(best):
            notes.append(UNSEEN.format(more=" more"))
    elif verdict is Verdict.NOTHING_WRONG:
        unexplained = 0.0
        notes += _far_off(setting.plant, replace(base, theta=theta).deviations)
        if simulation.fit is base:  # else a cause may matter for the structure, if not for the user's modal model
            notes += [weak(best, number, posterior.temper) for number in range(len(best.hypothesis.candidates))]
    elif not left(base, frame, setting.band).significant and not factors_off(base):
        notes.append(UNSEEN.format(more=""))
    if not named:
        extended = own if theta.any() else drawn
    notes += modal_notes(simulation, nominal, own, scorer, named)
    advice = advise(posterior, evidence.searched, evidence.energy) if named else ()
    shown = show(dataset, simulation.fit, final, nominal, calibrated, frame)
    return Diagnosis(
        verdict=verdict,
        findings=findings,
        calibration=tuple(_calibration(setting.plant, theta, posterior.temper * final.covariance)),
        unexplained=unexplained,
        scores={
            name: {"measured": scorer.error(found), "held_out": scorer.held_out_error(found)}
            for name, found in (("baseline", nominal), ("extended", extended))
        },
        noise_floor=errors.floor,
        extended=extended_structure(setting.plant, theta[: base.hypothesis.nuisances], findings),
        shown=shown,
        example=example_of(
            scorer.shown,
            model_of(simulation.fit, frame, np.zeros_like(simulation.fit.theta)),
            model_of(final, frame, theta),
            dataset.sensors,
            setting.measured,
            frame,
            shown.observed.frequencies,
        ),
        advice=advice,
        posterior=posterior,
        notes=(*setting.notes, *evidence.notes, *notes, *(item.sentence for item in advice)),
        seconds=0.0,
    )


def _as_drawn_or_calibrated(base: Fit, frame: Frame, most: float) -> tuple[Fit, FloatArray]:
    """Return the fit without any cause and its theta: calibrated by no more than ``most`` standard deviations, or zero
    where what is wrong has led that astray.
    """
    drawn, calibrated = np.zeros_like(base.theta), within(base, most)
    left_by = [sum(float(np.square(part).sum()) for part in residuals_at(base, t, frame)) for t in (drawn, calibrated)]
    return base, drawn if left_by[0] < left_by[1] else calibrated


def _far_off(plant: Plant, deviations: FloatArray) -> list[str]:
    """Return a note on each nominal value that is further off than usual, in stated standard deviations (value,)."""
    return [
        f"{what} of {place_words(where)} is {abs(deviation):.1f} of its stated standard deviations"
        f" {'below' if deviation < 0 else 'above'} its nominal value: rare, but likelier than any cause"
        for (what, where), deviation in zip(_factors(plant), deviations, strict=False)
        if abs(deviation) > DEVIATION
    ]


def _share_left(extended: Forecast, nominal: Forecast) -> float:
    """Return the share of the nominal model's wrong energy that the extended one leaves."""
    gain = max(nominal.energy - nominal.floor_energy, 1e-300)
    return float(np.clip((extended.energy - extended.floor_energy) / gain, 0.0, 1.0))


def _findings(
    setting: Setting,
    scorer: Scorer,
    posterior: Posterior,
    simulation: Simulation,
    before: tuple[Forecast, Forecast],
    listed: float,
) -> tuple[Finding, ...]:
    """Return the causes of the best fit and a wrong modal model, what explains most first.

    ``before``: forecasts of the user's simulation and of the structure itself. ``listed``: how probable it is that what
    is wrong is on the list at all; given that, the posterior tells how probable each cause is.
    """
    best, findings = posterior.fits[0], list[Finding]()
    whole, model = scorer.forecast(best), model_of(best, scorer.frame)
    nominal, drawn = before
    had = max(nominal.energy - nominal.floor_energy, 1e-300)
    names = _names(setting)
    if simulation.is_wrong:
        findings.append(modal_finding(simulation, nominal, whole, SUREST * listed, names))
    for number, candidate in enumerate(best.hypothesis.candidates):
        cause, parameters = cause_of(best, number, posterior.temper)
        without = _strongest_without(posterior, candidate)
        lost = drawn.energy if without is None else scorer.forecast(without).energy
        acting = recordings_of(best, number, model, scorer.test, setting.measured, scorer.frame, posterior.temper)
        findings.append(
            Finding(
                cause,
                parameters,
                min(of_candidate(posterior, candidate), SUREST) * listed,
                float(np.clip((lost - whole.energy) / had, 0.0, 1.0)),
                tuple(name for name in names if name in acting),
                tuple(
                    (rival.kind, reported_location(rival), p * listed)
                    for rival, p in rivals_of(posterior, candidate, RIVALS)
                ),
                sentence_of(cause, parameters, held=is_held(setting.plant.structure.supports, cause)),
            )
        )
    return tuple(sorted(findings, key=lambda finding: -finding.explains))


def _names(setting: Setting) -> tuple[str, ...]:
    """Return the names of the recordings in the dataset's order, each once: several in one file share one."""
    return tuple(dict.fromkeys(recording.name for recording in setting.dataset.recordings))


def _apart(setting: Setting, findings: tuple[Finding, ...]) -> list[str]:
    """Return a line on each finding that acts in some recordings only."""
    names = _names(setting)
    return [
        f"the recordings are not all of one structure: {finding.cause.kind} {at_place(finding.cause.location)}"
        f" acts in {', '.join(finding.recordings)}, and does not, or too little to tell, in"
        f" {', '.join(name for name in names if name not in finding.recordings)}"
        for finding in findings
        if len(finding.recordings) < len(names)
    ]


def _strongest_without(posterior: Posterior, candidate: Candidate) -> Fit | None:
    """Return the fit of the best hypothesis less one candidate, None where that was not fitted."""
    rest = {other.key for other in posterior.fits[0].hypothesis.candidates} - {candidate.key}
    for item in posterior.fits:
        if rest and {other.key for other in item.hypothesis.candidates} == rest:
            return item
    return None


def _factors(plant: Plant) -> list[tuple[str, dict[str, Any]]]:
    """Return quantity and location of each uncertain factor."""
    parts = [(part.quantity, part.location) for part in plant.parts]
    return [*parts, *(("damping", {"modes": [mode + 1]}) for mode in range(len(plant.ratios)))]


def _calibration(
    plant: Plant, theta: FloatArray, covariance: FloatArray
) -> list[tuple[str, dict[str, Any], float, float]]:
    """Return quantity, location, factor and its standard deviation; an element's comes on top of its group's.

    No standard deviation is larger than the one stated: recordings cannot tell less than nothing.
    """
    names = [*_factors(plant), *(("stiffness", {"element": number}) for number in plant.scatter.elements)]
    own, rest = slice(0, plant.factors), slice(plant.factors, plant.values)
    weights = plant.scatter.weights
    factors = np.append(np.exp(theta[own]), 1 + theta[rest] @ weights)
    deviation = np.minimum(np.sqrt(np.diag(covariance)[own]), plant.spread[own]) * factors[: plant.factors]
    scattered = np.sqrt(np.einsum("pe,pq,qe->e", weights, covariance[rest, rest], weights))
    scattered = np.minimum(scattered, np.linalg.norm(plant.spread[rest, None] * weights, axis=0))
    return [
        (what, where, float(factor), float(std))
        for (what, where), factor, std in zip(names, factors, np.append(deviation, scattered), strict=True)
        if what != "damping" or where["modes"][0] <= plant.below  # of modes beyond a low-pass nothing is told
    ]
