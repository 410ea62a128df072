"""Where fits of one candidate more may begin, and where first steps from there lead."""

import numpy as np

from fe_models.dofs import FloatArray
from hybrid.diagnosis.contest.growing import padded
from hybrid.diagnosis.fitting.fitting import FIRST, Fit, Step, first_steps
from hybrid.diagnosis.fitting.forecasting import goes_far
from hybrid.diagnosis.recorded.gauge import Gauge
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.screening.screening import Screened

FIRST_DRAWN = 3  # first steps from the structure as drawn: the first ones mend all that is off besides


def best_start(hypothesis: Hypothesis, base: Fit, gauge: Gauge, trial: Screened) -> Step | None:
    """Return where first steps lead with one candidate more, from its best start, over the segments of the ``base``."""
    extended = hypothesis.adding(trial.candidate)
    states, count = padded(base.states, extended), FIRST_DRAWN if trial.is_drawn else FIRST
    steps = [
        first_steps(extended, theta, base.batches, gauge, states, count, base.cost) for theta in starts_of(trial, base)
    ]
    return min((step for step in steps if step is not None), key=lambda step: step.cost, default=None)


def starts_of(trial: Screened, base: Fit) -> list[FloatArray]:
    """Return where a fit of one candidate more may begin.

    What is wrong may have led the calibration of the ``base`` astray: for a force the drawn structure is a start, too.
    There a cable hardly goes slack at first: once it does, the structure moves further than the base lets it. And where
    a stop is hit there, the motion of the base does not tell: from one gap of five the steps lead to the right one.
    """
    theta, candidate = trial.theta(base), trial.candidate
    if trial.is_drawn or candidate.pull is None or not goes_far(base):
        return [theta]
    drawn = theta.copy()
    drawn[: base.hypothesis.nuisances] = 0.0
    if candidate.hardly:
        drawn[len(base.theta) :] = candidate.hardly
        return [theta, drawn]
    elsewhere = candidate.first_starts if len(candidate.first_starts) > 1 else ()
    return [theta, drawn, *(np.append(drawn[: len(base.theta)], start) for start in elsewhere)]
