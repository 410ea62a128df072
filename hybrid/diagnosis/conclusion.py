"""From evidence to what a report says: verdict, findings, extended structure, and forecasts before and after."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fe_models.dofs import FloatArray
from fe_models.structure import Structure
from hybrid.diagnosis.acting import recordings_of
from hybrid.diagnosis.advice import Advice, advise
from hybrid.diagnosis.candidate import Candidate
from hybrid.diagnosis.evidence import Evidence
from hybrid.diagnosis.example import Example, example_of
from hybrid.diagnosis.extend import extended_structure
from hybrid.diagnosis.findings import Finding, cause_of, place_words, reported_location, sentence_of
from hybrid.diagnosis.fitting import Fit, residuals_at
from hybrid.diagnosis.forecasting import DEVIATION, Forecast, model_of, within
from hybrid.diagnosis.frame import Frame
from hybrid.diagnosis.materiality import material, weak
from hybrid.diagnosis.pairs import left
from hybrid.diagnosis.plant import Plant
from hybrid.diagnosis.posterior import Posterior, of_candidate, rivals_of
from hybrid.diagnosis.scatter import with_scatter
from hybrid.diagnosis.scorer import Scorer
from hybrid.diagnosis.setting import Setting
from hybrid.diagnosis.show import Shown, show
from hybrid.diagnosis.verdict import Errors, Verdict, verdict_of

RIVALS = 0.005  # least probability of an alternative that is told
SUREST = 0.999  # no probability is said to be more


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
    scorer = Scorer.of(setting, frame)
    posterior, notes = material(evidence, scorer)
    weighed = setting.searched if setting.is_astray else frame  # what the fit was found with
    best = with_scatter(posterior.fits[0], evidence.candidates, dataset.assumptions.uncertainty.stiffness, weighed)
    posterior = replace(posterior, fits=(best, *posterior.fits[1:]))
    nominal, calibrated, extended = (
        scorer.forecast(item, most) for item, most in ((base, 0.0), (base, DEVIATION), (best, np.inf))
    )
    unexplained = _share_left(extended, nominal)
    errors = Errors(scorer.error(calibrated), scorer.error(extended), scorer.floor(calibrated), unexplained)
    verdict, doubt = verdict_of(best, base, frame, setting.band, errors)
    named = verdict in (Verdict.EXPLAINED, Verdict.PARTLY_EXPLAINED)
    final, theta = (best, best.theta) if named else _as_drawn_or_calibrated(base, frame)
    findings: tuple[Finding, ...] = ()
    if named:
        findings = _findings(setting, scorer, posterior, nominal, doubt)
        notes += _apart(setting, findings)
    elif verdict is Verdict.NOTHING_WRONG:
        unexplained = 0.0
        notes += [weak(best, number) for number in range(len(best.hypothesis.candidates))]
    if not named:
        extended = calibrated if theta.any() else nominal
    advice = advise(posterior, frame) if named else ()
    factors = tuple(float(value) for value in np.exp(theta[: base.hypothesis.nuisances]))
    shown = show(dataset, base, nominal, calibrated, left(base, frame, setting.band), frame)
    return Diagnosis(
        verdict=verdict,
        findings=findings,
        calibration=tuple(_calibration(setting.plant, factors, final.covariance)),
        unexplained=unexplained,
        scores={
            name: {"measured": scorer.error(found), "held_out": scorer.held_out_error(found)}
            for name, found in (("baseline", nominal), ("extended", extended))
        },
        noise_floor=errors.floor,
        extended=extended_structure(setting.plant, factors, findings),
        shown=shown,
        example=example_of(
            scorer.shown,
            model_of(base, frame, np.zeros_like(base.theta)),
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


def _as_drawn_or_calibrated(base: Fit, frame: Frame) -> tuple[Fit, FloatArray]:
    """Return the fit without any cause and its theta: calibrated, or zero where what is wrong has led that astray."""
    drawn, calibrated = np.zeros_like(base.theta), within(base, DEVIATION)
    left_by = [sum(float(np.square(part).sum()) for part in residuals_at(base, t, frame)) for t in (drawn, calibrated)]
    return base, drawn if left_by[0] < left_by[1] else calibrated


def _share_left(extended: Forecast, nominal: Forecast) -> float:
    """Return the share of the nominal model's wrong energy that the extended one leaves."""
    gain = max(nominal.energy - nominal.floor_energy, 1e-300)
    return float(np.clip((extended.energy - extended.floor_energy) / gain, 0.0, 1.0))


def _findings(
    setting: Setting, scorer: Scorer, posterior: Posterior, nominal: Forecast, doubt: float
) -> tuple[Finding, ...]:
    """Return the causes of the best fit, the one that explains most first."""
    best, findings = posterior.fits[0], []
    whole, model = scorer.forecast(best), model_of(best, scorer.frame)
    had = max(nominal.energy - nominal.floor_energy, 1e-300)
    for number, candidate in enumerate(best.hypothesis.candidates):
        cause, parameters = cause_of(best, number, posterior.temper)
        without = _strongest_without(posterior, candidate)
        lost = nominal.energy if without is None else scorer.forecast(without).energy
        findings.append(
            Finding(
                cause,
                parameters,
                min(of_candidate(posterior, candidate), doubt, SUREST),
                float(np.clip((lost - whole.energy) / had, 0.0, 1.0)),
                recordings_of(best, number, model, scorer.test, setting.measured, scorer.frame, posterior.temper),
                tuple(
                    (rival.kind, reported_location(rival), p) for rival, p in rivals_of(posterior, candidate, RIVALS)
                ),
                sentence_of(cause, parameters),
            )
        )
    return tuple(sorted(findings, key=lambda finding: -finding.explains))


def _apart(setting: Setting, findings: tuple[Finding, ...]) -> list[str]:
    """Return a line on each finding that acts in some recordings only."""
    names = list(dict.fromkeys(recording.name for recording in setting.dataset.recordings))
    return [
        f"the recordings are not all of one structure: {finding.cause.kind} at {place_words(finding.cause.location)}"
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


def _calibration(
    plant: Plant, factors: tuple[float, ...], covariance: FloatArray
) -> list[tuple[str, dict[str, Any], float, float]]:
    """Return quantity, location, factor and its standard deviation."""
    names: list[tuple[str, dict[str, Any]]] = [(part.quantity, part.location) for part in plant.parts]
    names += [("damping", {"modes": [mode + 1]}) for mode in range(len(plant.ratios))]
    deviation = np.sqrt(np.diag(covariance)[: len(factors)])
    return [
        (what, where, factor, float(factor * std))
        for (what, where), factor, std in zip(names, factors, deviation, strict=True)
    ]
