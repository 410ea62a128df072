"""Causes that have led a calibration beside a force law astray: there it hides them from the score test."""

from dataclasses import replace

from hybrid.diagnosis.causes.candidate import Candidate
from hybrid.diagnosis.fitting.fitting import Fit, fit
from hybrid.diagnosis.fitting.forecasting import DEVIATION, within
from hybrid.diagnosis.recorded.frame import Frame
from hybrid.diagnosis.screening.screening import Screened, screen

MOST = 12  # candidates: places that look alike are many


def taken_back(item: Fit, candidates: tuple[Candidate, ...], frame: Frame) -> list[Screened]:
    """Return the linear candidates that the score test ranks first where a calibration is taken back to what is normal.

    None where it is normal.
    """
    theta = within(item, DEVIATION)
    if (theta == item.theta).all():
        return []
    back = fit(item.hypothesis, theta, item.batches, frame, item.states, iterations=0)
    linear = tuple(candidate for candidate in candidates if not candidate.is_law)
    found = [] if back is None else screen(back, linear, frame)[:MOST]
    return [replace(trial, shift=trial.shift + theta - item.theta, is_drawn=True) for trial in found]
