"""Where fits of one candidate more may begin, and where first steps from there lead."""

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes.candidate import ForceCandidate
from hybrid.diagnosis.contest.config import SEGMENTS
from hybrid.diagnosis.contest.growing import padded
from hybrid.diagnosis.fitting.calibration_deviation import goes_far
from hybrid.diagnosis.fitting.config import LEAST_SQUARES
from hybrid.diagnosis.fitting.least_squares import Fit, Step, first_steps
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.screening.screening import Screened


def best_start(hypothesis: Hypothesis, base: Fit, noise_model: NoiseModel, trial: Screened) -> Step | None:
    """Return where first steps lead with one candidate more, from its best start, over the segments of the ``base``.

    A law that leads no lower than the base begins at each of its gaps, too.
    """
    found = _best_from(hypothesis, base, noise_model, trial, starts_of(trial, base))
    if found is not None and found.cost < base.cost:
        return found
    return _lowest([found, _best_from(hypothesis, base, noise_model, trial, gaps_of(trial, base))])


def starts_of(trial: Screened, base: Fit) -> list[FloatArray]:
    """Return where a fit of one candidate more may begin.

    What is wrong may have led the calibration of the ``base`` astray: for a force the drawn structure is a start, too.
    There a cable hardly goes slack at first: once it does, the structure moves further than the base lets it.
    """
    theta, candidate = trial.theta(base), trial.candidate
    if not _also_drawn(trial, base):
        return [theta]
    return [theta, _drawn(trial, base, candidate.negligible or trial.start)]


def gaps_of(trial: Screened, base: Fit) -> list[FloatArray]:
    """Return further starts of a law with a gap: where a stop is hit in the structure as drawn, the motion of the
    ``base`` does not show. From one gap of five the steps lead there. A cable that is slack most of the time begins so.
    """
    gaps = trial.candidate.first_starts
    starts = (trial.start,) if trial.candidate.negligible else gaps if len(gaps) > 1 else ()
    return [_drawn(trial, base, start) for start in starts] if _also_drawn(trial, base) else []


def _also_drawn(trial: Screened, base: Fit) -> bool:
    return not trial.is_drawn and isinstance(trial.candidate, ForceCandidate) and goes_far(base)


def _drawn(trial: Screened, base: Fit, start: tuple[float, ...]) -> FloatArray:
    """Return the parameters with a candidate's ``start`` in the structure as drawn."""
    theta = np.append(base.theta + trial.shift, start)
    theta[: base.hypothesis.nuisances] = 0.0
    return theta


def _best_from(
    hypothesis: Hypothesis, base: Fit, noise_model: NoiseModel, trial: Screened, starts: list[FloatArray]
) -> Step | None:
    """Return where first steps lead from the best of ``starts`` (parameter,)."""
    extended = hypothesis.adding(trial.candidate)
    states, count = padded(base, extended), SEGMENTS.first_drawn_steps if trial.is_drawn else LEAST_SQUARES.first_steps
    return _lowest(
        [first_steps(extended, start, base.batches, noise_model, states, count, base.cost) for start in starts]
    )


def _lowest(steps: list[Step | None]) -> Step | None:
    return min((step for step in steps if step is not None), key=lambda step: step.cost, default=None)
