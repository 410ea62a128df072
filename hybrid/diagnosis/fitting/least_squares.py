"""Fits of a hypothesis: Gauss-Newton with the initial states projected out and the user's uncertainties as priors.

Minimises sum of squares of (y - y(theta, z0)) / sigma plus those of theta - centre times their `precision`, by
Levenberg and Marquardt's steps in theta; the initial states z0 follow (see `linearisation`).
"""

from dataclasses import dataclass
from math import inf

import numpy as np

from fe_models.arrays import TINY, FloatArray
from fe_models.causes.candidate import LawCandidate
from hybrid.diagnosis.fitting.config import LEAST_SQUARES
from hybrid.diagnosis.fitting.linearisation import Linearisation, linearise_batch
from hybrid.diagnosis.recorded.batches import Batch
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.response.hypothesis import Hypothesis


@dataclass(frozen=True, eq=False)  # two are never equal, so that what was made of one can be looked up by it
class Fit:
    """The best theta (parameter,) of a hypothesis, its ``covariance``, and what is left.

    ``chi2``: sum of squares of the data alone, ``cost`` with the prior. ``states`` and ``residuals`` (in units of
    sigma): one array (recording, ...) for each batch. ``batches``: what was fitted. ``state_errors``: standard
    deviations (recording, state) at this theta, and ``state_slopes`` (parameter, recording, state), for each batch.
    """

    hypothesis: Hypothesis
    theta: FloatArray
    covariance: FloatArray
    chi2: float
    cost: float
    states: tuple[FloatArray, ...]
    residuals: tuple[FloatArray, ...]
    batches: tuple[Batch, ...]
    state_errors: tuple[FloatArray, ...]
    state_slopes: tuple[FloatArray, ...]

    @property
    def claim(self) -> tuple[object, ...]:
        """What a fit says is wrong: its causes, in any order, and in which recordings which of them do not act."""
        keys = [candidate.key for candidate in self.hypothesis.candidates]
        off = {
            (motion, tuple(sorted(keys[i] for i in batch.off)))
            for batch in self.batches
            for motion in batch.order or batch.names
        }
        return tuple(sorted(keys)), frozenset(off)

    @property
    def names(self) -> tuple[str, ...]:
        """The name of the recording of each motion that was fitted."""
        return tuple(name for batch in self.batches for name in batch.names)

    @property
    def values(self) -> float:
        """Number of data, as independent as those of white noise: a low-pass leaves fewer."""
        return sum(part.size * batch.share for part, batch in zip(self.residuals, self.batches, strict=True))

    @property
    def misfit(self) -> float:
        """What is left beyond noise, and the squares of the calibration's deviations, in units of variances."""
        return self.cost - self.values + sum(states.size for states in self.states)

    @property
    def charged(self) -> float:
        """The cost, and one for each entry of an initial state that other hypotheses do not have: what it takes of
        noise. By this fits are compared, over short segments above all, where such entries are many.
        """
        return self.cost + self.hypothesis.extra_entries(self.theta, self.states)

    @property
    def deviations(self) -> FloatArray:
        """How far nominal values are off, (value,), in stated standard deviations: of a value or of its logarithm,
        whichever makes less of it, as its owner did not say which. At 10 %, 0.7 times as much is 3 off, not 3.6.
        """
        nominal = self.hypothesis.nominal
        off = self.theta[: nominal.values].copy()
        off[: nominal.factors] = np.where(
            off[: nominal.factors] < 0, np.expm1(off[: nominal.factors]), off[: nominal.factors]
        )
        return np.asarray(off / self.hypothesis.width[: nominal.values])

    @property
    def log_evidence(self) -> float:
        """Laplace's approximation: the fit, and how much of the prior of the candidates' parameters is left.

        The initial states are the same for all hypotheses but for the two of a harmonic force and of the mode that a
        released support brings, in each recording; their prior is a normal distribution as wide as what was found.
        """
        first = self.hypothesis.nuisances
        own = self.covariance[first:, first:]
        occam = (
            0.5 * np.linalg.slogdet(own)[1] - float(np.log(self.hypothesis.width[first:]).sum()) if len(own) else 0.0
        )
        for rows in self.hypothesis.own_motions(self.theta):
            full = [i for i, states in enumerate(self.states) if states.shape[1] == self.hypothesis.states]
            entries = np.concatenate([self.states[i] @ rows.T for i in full])
            errors = np.concatenate([np.sqrt(self.state_errors[i] ** 2 @ rows.T**2) for i in full])
            square = np.mean(entries**2) + TINY
            occam -= 0.5 * float(np.sum(np.log1p(square / errors**2) + entries**2 / square))
        return -0.5 * self.cost + float(occam)


@dataclass(frozen=True)
class _Point:
    """Where a search is: ``theta``, the batches linearised there, and the ``cost``."""

    theta: FloatArray
    parts: tuple[Linearisation, ...]
    cost: float

    @property
    def states(self) -> tuple[FloatArray, ...]:
        """The initial states of each batch."""
        return tuple(part.states for part in self.parts)

    def after(self, step: FloatArray) -> tuple[FloatArray, ...]:
        """Return the initial states that go with a ``step`` of theta."""
        return tuple(
            part.states + part.state_step + np.einsum("p,prs->rs", step, part.state_slopes) for part in self.parts
        )


@dataclass(frozen=True)
class _Problem:
    """What is fitted to what."""

    hypothesis: Hypothesis
    batches: tuple[Batch, ...]
    noise_model: NoiseModel

    def at(self, theta: FloatArray, states: tuple[FloatArray, ...] | None, slopes: bool = True) -> _Point | None:
        """Return the point of ``theta``, None where a batch fails."""
        parts = []
        for number, batch in enumerate(self.batches):
            own = None if states is None else states[number]
            try:
                part = linearise_batch(self.hypothesis, theta, batch, self.noise_model, own, slopes, brief=True)
            except np.linalg.LinAlgError:  # masses that are not positive: a step too far
                return None
            if part is None:
                return None
            parts.append(part)
        data = sum(float(np.square(part.raw).sum()) for part in parts)
        prior = float(np.sum(self.hypothesis.precision * (theta - self.hypothesis.centre) ** 2))
        return _Point(theta, tuple(parts), data + prior)

    def begun(self, theta: FloatArray, states: tuple[FloatArray, ...] | None) -> _Point | None:
        """Return where a search begins: at ``theta``, or with force laws as much weaker as they must be."""
        for share in LEAST_SQUARES.law_strengths:
            weaker = _weakened(self.hypothesis, theta, share)
            point = self.at(np.clip(weaker, self.hypothesis.lower, self.hypothesis.upper), states)
            if point is not None:
                return point
        return None

    def normal_equations(self, point: _Point) -> tuple[FloatArray, FloatArray]:
        """Return J J^T (parameter, parameter) and J r (parameter,), the prior's part in both."""
        J = np.concatenate([part.slopes.reshape(len(point.theta), -1) for part in point.parts], axis=1)
        r = np.concatenate([part.residual.ravel() for part in point.parts])
        precision = self.hypothesis.precision
        return J @ J.T + np.diag(precision), J @ r - precision * (point.theta - self.hypothesis.centre)

    def improved(self, point: _Point, damping: float, slopes: bool = True) -> tuple[_Point | None, float]:
        """Return the next point, None where no step leads down, and the damping that it took.

        Without ``slopes`` no step can follow.
        """
        H, gradient = self.normal_equations(point)
        hopeful = slopes and self.hypothesis.is_linear  # they take far longer, and a step that fails needs none
        for tried in LEAST_SQUARES.damping.tries(damping):
            step = np.linalg.solve(H + tried * np.diag(np.diag(H)), gradient)
            theta = np.clip(point.theta + step, self.hypothesis.lower, self.hypothesis.upper)
            states = point.after(theta - point.theta)
            then = self.at(theta, states, slopes=hopeful)
            if then is not None and then.cost <= point.cost:
                return then if hopeful or not slopes else self.at(theta, states), tried
            hopeful = False
        return None, LEAST_SQUARES.damping.most


@dataclass(frozen=True)
class Step:
    """Where first steps lead: ``theta`` (parameter,) of a ``hypothesis``, initial ``states``, and the ``cost``."""

    hypothesis: Hypothesis
    theta: FloatArray
    states: tuple[FloatArray, ...]
    cost: float

    @property
    def charged(self) -> float:
        """The cost as fits are compared by it."""
        return self.cost + self.hypothesis.extra_entries(self.theta, self.states)


def first_steps(
    hypothesis: Hypothesis,
    theta: FloatArray,
    batches: tuple[Batch, ...],
    noise_model: NoiseModel,
    states: tuple[FloatArray, ...],
    steps: int = LEAST_SQUARES.first_steps,
    bound: float = inf,
) -> Step | None:
    """Return where the first ``steps`` of a `fit` lead; None as of `fit`.

    A force law takes two; another candidate beside one two at most; both more while they fall steeply, the other
    candidate only if that would lead below the cost ``bound``. Without one up to twice as many are taken, while each
    halves the cost and that would lead there. Without the slopes there, which take longest.
    """
    problem = _Problem(hypothesis, batches, noise_model)
    least, most, steep, conclusive = steps, 2 * steps, LEAST_SQUARES.max_cost_ratio, 0
    if not hypothesis.is_linear:
        comes = isinstance(hypothesis.candidates[-1], LawCandidate)
        least, most = (
            LEAST_SQUARES.first_law_steps if comes else min(steps, LEAST_SQUARES.first_law_steps),
            LEAST_SQUARES.max_law_iterations,
        )
        steep, conclusive = 1 - LEAST_SQUARES.steep_fall_share, LEAST_SQUARES.conclusive_steps
        bound = inf if comes else bound  # how a law that starts far off falls says nothing of where it ends
    taken, best = 0, problem.begun(theta, states)
    point = best
    while point is not None:
        then = problem.improved(point, LEAST_SQUARES.damping.start, slopes=False)[0]
        if then is None:
            break
        fall = then.cost / point.cost
        taken, best = taken + 1, then
        falls = fall < steep and (taken < conclusive or then.cost * fall ** (most - taken) < bound)
        if taken >= (most if falls else least):
            break
        point = problem.at(then.theta, then.states)  # the slopes, too
    return None if best is None else Step(hypothesis, best.theta, best.states, best.cost)


def fit(
    hypothesis: Hypothesis,
    theta: FloatArray,
    batches: tuple[Batch, ...],
    noise_model: NoiseModel,
    states: tuple[FloatArray, ...] | None = None,
    iterations: int = LEAST_SQUARES.max_iterations,
    enough: float = LEAST_SQUARES.min_chi2_fall,
    bound: float = inf,
) -> Fit | None:
    """Return the best fit from ``theta`` (parameter,) by Levenberg and Marquardt; None where no start is possible.

    ``states``: where initial states begin, one array (recording, state) for each batch, needed with force laws. A fit
    that would not get its `Fit.charged` below ``bound``, even if every step to come brought as much as the last, is
    broken off.
    """
    problem = _Problem(hypothesis, batches, noise_model)
    point = problem.begun(theta, states)
    if point is None:
        return None
    values = sum(batch.data.size for batch in batches)
    damping, bound = LEAST_SQUARES.damping.start, bound - hypothesis.extra_entries(point.theta, point.states)
    iterations = iterations if hypothesis.is_linear else min(iterations, LEAST_SQUARES.max_law_iterations)
    for to_come in reversed(range(iterations)):
        then, damping = problem.improved(point, damping)
        if then is None:
            break
        gain, point = point.cost - then.cost, then
        # a first step cut short may be small before large ones
        is_conclusive = damping == LEAST_SQUARES.damping.start or to_come < iterations - 1
        damping = LEAST_SQUARES.damping.eased(damping)
        if gain < enough * max(1.0, point.cost / values) or (is_conclusive and point.cost - to_come * gain > bound):
            break
    return Fit(
        hypothesis,
        point.theta,
        np.asarray(np.linalg.inv(problem.normal_equations(point)[0])),
        sum(float(np.square(part.raw).sum()) for part in point.parts),
        point.cost,
        point.states,
        tuple(part.raw for part in point.parts),
        batches,
        tuple(part.state_errors for part in point.parts),
        tuple(part.state_slopes for part in point.parts),
    )


def residuals_at(item: Fit, theta: FloatArray, noise_model: NoiseModel) -> tuple[FloatArray | None, ...]:
    """Return what the hypothesis of a fit leaves at ``theta``, an array (recording, time, sensor) for each batch.

    In units of the noise, the initial states fitted; None where the motion explodes.
    """
    return tuple(
        left_at(item.hypothesis, theta, batch, noise_model, states)
        for batch, states in zip(item.batches, item.states, strict=True)
    )


def left_at(
    hypothesis: Hypothesis, theta: FloatArray, batch: Batch, noise_model: NoiseModel, states: FloatArray | None
) -> FloatArray | None:
    """Return what a hypothesis leaves of a batch at ``theta``, (recording, time, sensor), as `residuals_at`.

    ``states``: where initial states begin, needed where there are laws: they follow these by Newton's steps.
    """
    for _ in range(0 if hypothesis.less(batch.off).is_linear else LEAST_SQUARES.newton_steps):
        part = linearise_batch(hypothesis, theta, batch, noise_model, states)
        if part is None:
            return None
        states = part.states + part.state_step
    part = linearise_batch(hypothesis, theta, batch, noise_model, states, slopes=False)
    return None if part is None else part.raw


def _weakened(hypothesis: Hypothesis, theta: FloatArray, share: float) -> FloatArray:
    """Return theta with a ``share`` of each candidate's force law: motions of a softening spring may grow for ever."""
    weaker = theta.copy()
    for candidate, part in hypothesis.each(LawCandidate):
        neutral = candidate.neutral[0]
        weaker[part.start] = neutral + share * (theta[part.start] - neutral)
    return weaker
