"""Forecasts before and after: by what the user simulates with, by the structure, and with what was found."""

from dataclasses import dataclass

import numpy as np

from hybrid.diagnosis.fitting.forecast_score import ForecastScore
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.outcome.config import SHARE
from hybrid.diagnosis.outcome.scorer import Scorer


@dataclass(frozen=True)
class Forecasts:
    """By the user's simulation, ``nominal`` and ``calibrated`` within what is normal; by its structure, which is
    another where a modal model stands for it, ``drawn`` and ``own``, likewise; and with what was found, ``extended``.
    """

    nominal: ForecastScore
    calibrated: ForecastScore
    drawn: ForecastScore
    own: ForecastScore
    extended: ForecastScore

    @property
    def unexplained(self) -> float:
        """The share of the nominal model's wrong energy that the extended one leaves; nothing of next to nothing."""
        return share_left(self.nominal, self.extended)


def forecasts_of(scorer: Scorer, simulated: Fit, base: Fit, best: Fit, normal: float) -> Forecasts:
    """Return the forecasts by fits of the user's simulation and of its structure, ``base`` without any cause.

    ``normal``: how far a nominal value may be calibrated, in stated standard deviations.
    """
    nominal, calibrated = (scorer.forecast(simulated, most) for most in (0.0, normal))
    drawn, own = nominal, calibrated
    if simulated is not base:
        drawn, own = (scorer.forecast(base, most) for most in (0.0, normal))
    return Forecasts(nominal, calibrated, drawn, own, scorer.forecast(best))


def share_left(before: ForecastScore, after: ForecastScore) -> float:
    """Return the share of the wrong energy ``before`` that is left ``after``; nothing of next to nothing."""
    return 0.0 if before.excess <= SHARE.max_by_chance * before.floor_energy else share(after.excess, before.excess)


def share(part: float, whole: float) -> float:
    """Return what a part is of the whole, between 0 and 1; of next to nothing nothing."""
    found = float(np.clip(part / whole, 0.0, 1.0))
    return found if found > SHARE.next_to_nothing else 0.0
