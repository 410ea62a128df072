"""Fits by time series for the audit: cases of the chain, their hypotheses, and the density that is integrated.

Integrated over are nominal values and the causes' sizes; initial states are those that fit best at each, as the program
takes them, and the noise is known. The program compares evidences of causes and of none, in which what the nominal
values' own volume is cancels: it is added here as the fit without a cause has it.
"""

from dataclasses import dataclass

import numpy as np

from benchmarks.audit.chain import RATE, SAMPLES, SENSORS, Problem, log_normal
from benchmarks.audit.nested import Target
from benchmarks.audit.ranks import draws_of, ranks_of
from fe_models.arrays import FloatArray
from hybrid.diagnosis.contest.odds import Odds
from hybrid.diagnosis.contest.posterior import PRIOR_NOTHING_WRONG
from hybrid.diagnosis.fitting.least_squares import Fit, fit
from hybrid.diagnosis.fitting.linearisation import linearise_batch
from hybrid.diagnosis.recorded.batches import Batch
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.state_space import system_of
from hybrid.diagnosis.response.system import linear_channels

NOISE = 0.1  # of each channel
STARTS = (-0.3, 0.0, 0.3)  # prior standard deviations from doing nothing, at which a fit begins


@dataclass(frozen=True, eq=False)
class _Density:
    """The log density of the recordings of a fit, its initial states as they fit best, and of theta."""

    item: Fit
    noise_model: NoiseModel

    def __call__(self, theta: FloatArray) -> float | None:
        hypothesis, total = self.item.hypothesis, 0.0
        for batch in self.item.batches:
            try:
                part = linearise_batch(hypothesis, theta, batch, self.noise_model, None, slopes=False, brief=True)
            except np.linalg.LinAlgError:  # masses that are not positive
                return None
            if part is None:
                return None
            total += float(np.square(part.raw).sum())
        return -0.5 * total + log_normal(theta, hypothesis.centre, hypothesis.width)


def case(problem: Problem, seed: int, claims: int) -> list[Target]:
    """Return the targets of a case: nothing wrong, and the best of the hypotheses of a cause."""
    rng = np.random.default_rng(seed)
    batch, noise_model = _recorded(*problem.true_case(rng), rng)
    null = fit(problem.hypothesis(), problem.hypothesis().centre, (batch,), noise_model)
    if null is None:
        raise RuntimeError(f"case {seed}: the chain as drawn cannot be fitted")
    odds = Odds.among(problem.candidates, problem.nominal.alike)
    fits = [_fitted(problem.hypothesis(candidate), batch, noise_model) for candidate in problem.candidates]
    known = [(item, odds.log(item.hypothesis.candidates[0])) for item in fits if item is not None]
    best = sorted(known, key=lambda own: -(own[0].log_evidence + own[1]))[:claims]
    volume = 0.5 * float(np.linalg.slogdet(null.covariance)[1]) - float(np.log(null.hypothesis.width).sum())
    listed = [(null, 0.0), *((item, float(np.log(PRIOR_NOTHING_WRONG)) + own) for item, own in best)]
    return [_target(item, noise_model, volume, own) for item, own in listed]


def ranked(problem: Problem, seed: int) -> dict[str, list[int]]:
    """Return the ranks of true values by the kind of parameter, of truth that is drawn from its prior."""
    rng = np.random.default_rng(seed)
    hypothesis, theta = problem.from_prior(rng, seed)
    item = _fitted(hypothesis, *_recorded(hypothesis, theta, rng))
    if item is None:
        return {}
    nominal = problem.nominal
    kinds = [part.quantity for part in nominal.parts] + ["damping"] * len(nominal.ratios)
    kinds += ["dispersion"] * (hypothesis.nuisances - len(kinds)) + [hypothesis.candidates[0].kind]
    return ranks_of(kinds, theta, draws_of(item.theta, item.covariance, rng))


def _recorded(hypothesis: Hypothesis, theta: FloatArray, rng: np.random.Generator) -> tuple[Batch, NoiseModel]:
    """Return a recording of the chain at ``theta``, from a random state."""
    outputs = NoiseModel(SENSORS, RATE, np.ones(len(SENSORS))).outputs
    system = system_of(hypothesis, theta[None], outputs)
    n = hypothesis.size
    start = rng.standard_normal(hypothesis.states) * np.repeat([1.0, 10.0], n)  # m, m/s: the chain's modes are at 10/s
    clean = linear_channels(system, start[None, None], SAMPLES)[0]  # (recording, time, sensor)
    sigma = NOISE * clean.std(axis=(0, 1))
    data = clean + sigma * rng.standard_normal(clean.shape)
    return Batch(data, ("r",)), NoiseModel(SENSORS, RATE, sigma)


def _fitted(hypothesis: Hypothesis, batch: Batch, noise_model: NoiseModel) -> Fit | None:
    """Return the best fit of a hypothesis of one cause, from sizes to either side of nothing."""
    found = []
    for share in STARTS:
        theta = hypothesis.centre
        theta[-1] += share * hypothesis.width[-1]
        found.append(fit(hypothesis, theta, (batch,), noise_model))
    return min((item for item in found if item is not None), key=lambda item: item.cost, default=None)


def _target(item: Fit, noise_model: NoiseModel, volume: float, odds: float) -> Target:
    hypothesis = item.hypothesis
    named = " and ".join(candidate.key for candidate in hypothesis.candidates) or "nothing"
    closed = item.log_evidence + volume
    return Target(
        named,
        _Density(item, noise_model),
        hypothesis.lower,
        hypothesis.upper,
        item.theta,
        item.covariance,
        closed,
        odds,
    )
