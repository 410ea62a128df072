"""What the user simulates with: the structure itself, or a modal model of which causes say nothing.

Causes are sought in the structure. A modal model is then wrong by itself where the best hypothesis of the structure
does better than the modal model with as many of the same causes as help it, both calibrated within what is normal.
"""

from dataclasses import dataclass

import numpy as np

from fe_models.causes import WrongModalModel
from fe_models.errors import InputError
from hybrid.diagnosis.contest.evidence import Evidence
from hybrid.diagnosis.contest.posterior import Posterior
from hybrid.diagnosis.contest.setting import Setting
from hybrid.diagnosis.fitting.calibration_deviation import deviation_of
from hybrid.diagnosis.fitting.config import CALIBRATION
from hybrid.diagnosis.fitting.excess_energy import excess_energy
from hybrid.diagnosis.fitting.forecast_score import ForecastScore, model_of, predicted, shown_of
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.nominal.modal_difference import difference
from hybrid.diagnosis.outcome.findings import Alternative, Finding
from hybrid.diagnosis.outcome.materiality import is_trifle
from hybrid.diagnosis.outcome.modal_fits import fit_in_modal_model, fits_in_modal_model
from hybrid.diagnosis.outcome.scorer import Scorer
from hybrid.diagnosis.recorded.noise_model import NoiseModel

FARTHEST = 500.0  # in log odds: what exp can be taken of


@dataclass(frozen=True)
class Simulation:
    """``fit``: of what the user simulates with, without any cause.

    ``probability``: that it is a modal model which is wrong by itself, 0 where that does not matter for forecasts;
    ``beside``: its forecast with those causes of the best fit that help it, None if there are no causes. ``differs``:
    in words, how a modal model differs from its structure; empty where it does not.
    """

    fit: Fit
    probability: float = 0.0
    beside: ForecastScore | None = None
    differs: str = ""

    @property
    def is_wrong(self) -> bool:
        """Whether the simulation's modal model is a finding."""
        return self.probability > 0


def simulation_of(setting: Setting, evidence: Evidence, posterior: Posterior, scorer: Scorer) -> Simulation:
    """Return the user's simulation; the best fit of the ``posterior`` is that of the structure.

    A modal model whose forecasts differ from those of its structure by less than noise shows is taken for it.
    """
    base, best, modal = evidence.base, posterior.fits[0], setting.modal
    if modal is None:
        return Simulation(base)
    plain = fit_in_modal_model(base, (), modal, setting, evidence)
    if plain is None:
        raise InputError("[simulation] modal_model: under the structure's own force laws its motion grows for ever")
    if not _forecasts_differ(base, plain, evidence.noise_model, setting.tolerance):
        return Simulation(base)
    differs = difference(setting.nominal, modal)
    causes = best.hypothesis.candidates
    fits = [plain, *fits_in_modal_model(best, modal, setting, evidence)]
    same = max(fits, key=lambda item: item.log_evidence)
    most = max(CALIBRATION.max_deviation_sigma, deviation_of(best))  # what the one needs, the other may have
    before, after = (scorer.forecast(item, most) for item in (same, best))
    nominal = scorer.forecast(plain, 0.0)
    trifle = is_trifle(before, after, nominal, bool(causes))
    guess = trifle and excess_energy(best, evidence.noise_model, setting.band).significant
    ours, theirs = (evidence.as_searched(item).log_evidence for item in (best, same))
    log_odds = (ours - theirs) / posterior.temper
    matters = scorer.error(before) - scorer.error(after) > setting.tolerance * scorer.floor(after)
    if guess or not matters or log_odds <= 0:
        return Simulation(plain, differs=differs)
    probability = float(1 / (1 + np.exp(-min(log_odds, FARTHEST))))
    return Simulation(plain, probability, before if causes else None, differs)


def modal_finding(
    simulation: Simulation,
    nominal: ForecastScore,
    whole: ForecastScore,
    probability: float,
    alternatives: tuple[Alternative, ...],
    recordings: tuple[str, ...],
) -> Finding:
    """Return the finding that the modal model is wrong.

    ``nominal``: its forecast; ``whole``: that by the extended structure.
    """
    cause, structure = WrongModalModel(), simulation.fit.hypothesis.nominal.structure
    return Finding(
        cause,
        {},
        probability,
        float(np.clip(((simulation.beside or nominal).energy - whole.energy) / nominal.excess, 0.0, 1.0)),
        recordings,
        alternatives,
        cause.sentence({"differs": simulation.differs}, structure),
    )


def modal_notes(
    simulation: Simulation, nominal: ForecastScore, own: ForecastScore, scorer: Scorer, named: bool
) -> list[str]:
    """Return what the user should know of a modal model.

    ``nominal``: its forecast; ``own``: that of the structure, calibrated; ``named``: whether there are findings.
    """
    if scorer.setting.modal is None:
        return []
    if not simulation.differs:
        return ["the modal model forecasts as its structure does: what differs would not show beside noise"]
    told = [] if simulation.is_wrong else [f"the modal model is not that of its structure: {simulation.differs}"]
    if scorer.error(own) <= scorer.error(nominal):
        share = 1 - min(own.excess / nominal.excess, 1.0)
        told.append(f"the structure's own modes, calibrated, avoid {share:.0%} of what the modal model gets wrong")
    else:
        told.append(
            "the structure's own modes, calibrated, forecast worse than the modal model: NRMSE"
            f" {scorer.error(own):.4f} against {scorer.error(nominal):.4f}"
            + ("" if named else "; leave modal_model out to have the structure diagnosed")
        )
    return told


def _forecasts_differ(own: Fit, other: Fit, noise_model: NoiseModel, tolerance: float) -> bool:
    """Return whether two models, as drawn, forecast so differently that it would show beside noise, by more than the
    user's ``tolerance``.
    """
    square, values = 0.0, 0.0
    for batch in own.batches:
        first = shown_of(batch.samples)
        one, two = (
            predicted(model_of(item, noise_model, np.zeros_like(item.theta)), batch, noise_model.roles)
            for item in (own, other)
        )
        apart = ((one - two) / batch.sigma(noise_model))[:, first:]
        square += float(np.square(apart).sum())
        values += apart.size * batch.share
    return square > ((1 + tolerance) ** 2 - 1) * values
