"""From evidence to what a report says: verdict, findings, extended structure, and forecasts before and after."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from fe_models.recordings import TOLERANCE
from fe_models.structure import Structure
from hybrid.diagnosis.contest.evidence import Evidence
from hybrid.diagnosis.contest.posterior import Posterior
from hybrid.diagnosis.contest.setting import Setting
from hybrid.diagnosis.next_measurement.by_series import next_by_series
from hybrid.diagnosis.next_measurement.recommendation import NextMeasurement
from hybrid.diagnosis.observed.example import Example, example_of
from hybrid.diagnosis.observed.observations import Observations, observe
from hybrid.diagnosis.outcome.calibration import Calibrated, calibration_of
from hybrid.diagnosis.outcome.extend import extended_structure
from hybrid.diagnosis.outcome.findings import Finding
from hybrid.diagnosis.outcome.named import named_by
from hybrid.diagnosis.outcome.remarks import remarks_on
from hybrid.diagnosis.outcome.ruling import Ruling, ruling_of
from hybrid.diagnosis.outcome.verdict import Verdict
from hybrid.diagnosis.recorded.motions import motions_of
from hybrid.identification.identification import Identification


@dataclass(frozen=True, repr=False)
class Diagnosis:
    """All that a report says.

    ``verdict`` and ``findings``, what explains most first; ``calibration`` of the nominal values; ``unexplained``:
    share of the nominal model's wrong energy that is left. ``scores``: forecast NRMSE of the user's simulation,
    "baseline", and of the ``extended`` structure, of the "measured" and the "held_out" channels (None without any);
    ``noise_floor``: what noise alone makes of the first. ``observations``: what the simulation gets wrong, and one
    recording as an ``example`` of it. ``next_measurement``: which would decide between rivals, None where there are
    none. ``posterior`` over all fits that matter; ``alike``: whether all recordings are of one structure, None where
    that is not known, or there is one only; ``notes``: what the user should know about the data; ``seconds`` that it
    took. What a first look ``identified`` in the recordings, by their names. ``tolerance``: the user's, see
    `Assumptions`.
    """

    verdict: Verdict
    findings: tuple[Finding, ...]
    calibration: tuple[Calibrated, ...]
    unexplained: float
    scores: dict[str, dict[str, float | None]]
    noise_floor: float
    extended: Structure
    observations: Observations
    example: Example
    next_measurement: NextMeasurement | None
    posterior: Posterior
    alike: bool | None
    notes: tuple[str, ...]
    seconds: float
    identified: Mapping[str, Identification] = field(default_factory=dict)
    tolerance: float = TOLERANCE

    def __repr__(self) -> str:
        return f"Diagnosis({self.verdict.value}: {', '.join(map(repr, self.findings)) or 'no finding'})"


def concluded(setting: Setting, evidence: Evidence) -> Diagnosis:
    """Return the diagnosis that the evidence amounts to."""
    ruling = ruling_of(setting, evidence)
    found, posterior, nominal = ruling.found, ruling.posterior, setting.nominal
    findings = named_by(ruling)
    then = None
    if ruling.is_named:
        then = next_by_series(posterior, evidence.searched, setting.dataset.sensors, ruling.listed)
    shown = observe(
        setting.dataset, ruling.simulation.fit, ruling.final, found.nominal, found.calibrated, evidence.noise_model
    )
    remarks = remarks_on(ruling, findings, shown)
    return Diagnosis(
        verdict=ruling.verdict,
        findings=findings,
        calibration=calibration_of(nominal, ruling.theta, posterior.widened * ruling.final.covariance),
        unexplained=0.0 if ruling.verdict is Verdict.NOTHING_WRONG else found.unexplained,
        scores=_scores(ruling),
        noise_floor=ruling.errors.floor,
        extended=extended_structure(nominal, ruling.theta[: evidence.base.hypothesis.nuisances], findings),
        observations=shown,
        example=_example(ruling, shown),
        next_measurement=then,
        posterior=posterior,
        alike=_alike(ruling, findings),
        notes=(*setting.notes, *evidence.notes, *remarks),
        seconds=0.0,
        tolerance=setting.tolerance,
    )


def _alike(ruling: Ruling, findings: tuple[Finding, ...]) -> bool | None:
    """Return whether all recordings are of one structure: not where a cause acts in some of them only."""
    motions = motions_of(ruling.setting.dataset).total()
    if motions < 2 or ruling.verdict.is_wanting:
        return None
    return all(len(finding.recordings) == motions for finding in findings)


def _scores(ruling: Ruling) -> dict[str, dict[str, float | None]]:
    """Return the NRMSE of forecasts before and after, of measured and of held-out channels."""
    scorer = ruling.scorer
    return {
        name: {"measured": scorer.error(forecast), "held_out": scorer.held_out_error(forecast)}
        for name, forecast in (("baseline", ruling.found.nominal), ("extended", ruling.after))
    }


def _example(ruling: Ruling, shown: Observations) -> Example:
    """Return one recording as the user's simulation forecasts it, and as the structure that is reported does."""
    scorer, simulated = ruling.scorer, ruling.simulation.fit
    return example_of(
        scorer.shown,
        scorer.example_model(simulated, np.zeros_like(simulated.theta)),
        scorer.example_model(ruling.final, None if ruling.is_named else ruling.theta),
        scorer.roles,
        shown.observed.frequencies,
    )
