"""What the evidence amounts to: a verdict, and all that it rests on."""

from dataclasses import dataclass, replace

import numpy as np

from fe_models.arrays import FloatArray
from hybrid.diagnosis.contest.evidence import Evidence
from hybrid.diagnosis.contest.posterior import Posterior
from hybrid.diagnosis.contest.setting import Setting
from hybrid.diagnosis.fitting.calibration_deviation import within
from hybrid.diagnosis.fitting.config import CALIBRATION
from hybrid.diagnosis.fitting.forecast_score import ForecastScore
from hybrid.diagnosis.fitting.least_squares import Fit, residuals_at
from hybrid.diagnosis.outcome.config import VERDICT
from hybrid.diagnosis.outcome.forecasts import Forecasts, forecasts_of
from hybrid.diagnosis.outcome.hum import Hum, hums_of, verdict_with
from hybrid.diagnosis.outcome.materiality import material, without_weak
from hybrid.diagnosis.outcome.noisier import with_own_noise
from hybrid.diagnosis.outcome.scorer import Scorer
from hybrid.diagnosis.outcome.simulation import Simulation, simulation_of
from hybrid.diagnosis.outcome.verdict import (
    Errors,
    Verdict,
    is_contradicted,
    verdict_of,
)
from hybrid.diagnosis.recorded.noise_model import NoiseModel

CONTRADICTED = (
    "held-out sensors are forecast worse with what is named (NRMSE {before:.4f} before, {after:.4f} after): it may"
    " stand for something else, or one of these sensors shows or sits where it should not"
)


@dataclass(frozen=True)
class Ruling:
    """A ``verdict``, and ``listed``, how probable it is that the list of causes has what is wrong.

    It rests on the ``posterior`` over the fits of the ``evidence`` whose causes matter, on the user's ``simulation``,
    and on what the ``scorer`` ``found`` of forecasts, with their ``errors``. ``final``: the best fit where its causes
    are named, and the one without any cause otherwise; ``theta`` (parameter,): what is reported of its parameters,
    which may be calibrated less than its own. ``hums``: what may stand in the place of the best fit's harmonic forces.
    ``notes``: on test recordings that are only noisier, and on causes that do not matter.
    """

    verdict: Verdict
    listed: float
    evidence: Evidence
    scorer: Scorer
    posterior: Posterior
    simulation: Simulation
    found: Forecasts
    errors: Errors
    final: Fit
    theta: FloatArray
    hums: tuple[Hum, ...]
    notes: tuple[str, ...]

    @property
    def setting(self) -> Setting:
        """What the diagnosis starts from."""
        return self.scorer.setting

    @property
    def best(self) -> Fit:
        """The most probable fit of those whose causes matter."""
        return self.posterior.fits[0]

    @property
    def is_named(self) -> bool:
        """Whether the best fit's causes are named."""
        return self.verdict in (Verdict.EXPLAINED, Verdict.PARTLY_EXPLAINED)

    @property
    def reported(self) -> Fit:
        """The final fit at the theta that is reported."""
        return replace(self.final, theta=self.theta)

    @property
    def after(self) -> ForecastScore:
        """The forecast by the structure that is reported."""
        if self.is_named:
            return self.found.extended
        return self.found.own if self.theta.any() else self.found.drawn


def ruling_of(setting: Setting, evidence: Evidence) -> Ruling:
    """Return what the evidence amounts to."""
    base, noise_model = evidence.base, evidence.noise_model
    scorer, notes = with_own_noise(Scorer.of(setting, evidence), evidence.posterior.fits[0])
    posterior, weak = _mattering(setting, evidence, scorer)
    best = posterior.fits[0]
    simulation = simulation_of(setting, evidence, posterior, scorer)
    # no cause is likelier than a value that far off
    normal = CALIBRATION.max_deviation_sigma if best.hypothesis.candidates else VERDICT.max_usual_sigma
    found = forecasts_of(scorer, simulation.fit, base, best, normal)
    errors = Errors(
        scorer.error(found.calibrated),
        scorer.error(found.extended),
        scorer.floor(found.own),
        found.unexplained,
        scorer.error(found.nominal),
        found.nominal.is_perfect or found.calibrated.is_perfect,
        setting.tolerance,
    )
    wrong = simulation.fit if simulation.is_wrong else base
    verdict, listed = verdict_of(best, evidence.posterior.fits[0], wrong, noise_model, setting.band, errors)
    # of what is left of the recordings themselves
    hums = hums_of(best, noise_model, posterior.temper * evidence.energy)
    verdict = verdict_with(hums, len(best.hypothesis.candidates), verdict)
    before, after = (scorer.held_out_error(forecast) for forecast in (found.nominal, found.extended))
    if verdict is Verdict.EXPLAINED and is_contradicted(before, after, errors):
        verdict, listed = Verdict.PARTLY_EXPLAINED, VERDICT.listed_in_part
        notes = [*notes, CONTRADICTED.format(before=before, after=after)]
    ruling = Ruling(
        verdict=verdict,
        listed=listed,
        evidence=evidence,
        scorer=scorer,
        posterior=posterior,
        simulation=simulation,
        found=found,
        errors=errors,
        final=best,
        theta=best.theta,
        hums=hums,
        notes=(*notes, *weak) if verdict is not Verdict.UNEXPLAINED else tuple(notes),  # of guesses nothing is reported
    )
    return (
        ruling
        if ruling.is_named
        else replace(ruling, final=base, theta=_drawn_or_calibrated(base, noise_model, normal))
    )


def _mattering(setting: Setting, evidence: Evidence, scorer: Scorer) -> tuple[Posterior, list[str]]:
    """Return the posterior among hypotheses whose causes matter, and a note on each cause that does not."""
    posterior, notes = material(evidence, scorer)
    if setting.modal is None:
        return posterior, notes
    posterior, more = without_weak(posterior, evidence, scorer)
    return posterior, notes + more


def _drawn_or_calibrated(base: Fit, noise_model: NoiseModel, most: float) -> FloatArray:
    """Return the theta of a fit without any cause, calibrated by no more than ``most`` standard deviations; zero where
    what is wrong has led that astray.
    """
    drawn, calibrated = np.zeros_like(base.theta), within(base, most)
    left_by = [
        sum(np.inf if part is None else float(np.square(part).sum()) for part in residuals_at(base, theta, noise_model))
        for theta in (drawn, calibrated)
    ]
    return drawn if left_by[0] < left_by[1] else calibrated
