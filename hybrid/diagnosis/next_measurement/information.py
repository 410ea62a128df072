"""How much a measurement is expected to tell about which of several hypotheses is right.

Hypothesis h, of probability w_h, expects data y ~ N(m_h, 1 + L_h L_h^T): what its best fit predicts, what its
parameters leave open, and noise of unit size. What y tells of h is their mutual information,

    I = H(w) - E_y[H(p(h | y))],

0 bits where all expect the same, and log2 of their number where each of them, as probable as any other, expects what
none of the others does.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular
from scipy.special import logsumexp

from fe_models.arrays import FloatArray
from hybrid.diagnosis.next_measurement.config import HYPOTHESES


@dataclass(frozen=True, eq=False)
class Prediction:
    """What a hypothesis expects to be measured, in units of the noise: its ``mean`` (value,), and how that moves by a
    standard deviation of each independent combination of what it leaves open, ``spread`` (value, combination).
    """

    mean: FloatArray
    spread: FloatArray

    @property
    def excess(self) -> FloatArray:
        """The covariance (value, value) beyond that of the noise."""
        return np.asarray(self.spread @ self.spread.T)

    @property
    def lower(self) -> FloatArray:
        """The Cholesky factor (value, value) of the covariance."""
        return _cholesky(self.excess)

    def log_density(self, data: FloatArray) -> FloatArray:
        """Return the log density (draw,) of ``data`` (draw, value), but for a constant that all predictions share."""
        lower = self.lower
        white = solve_triangular(lower, (data - self.mean).T, lower=True)
        return np.asarray(-0.5 * np.sum(white**2, axis=0) - _half_log_det(lower))

    def draw(self, rng: np.random.Generator, count: int) -> FloatArray:
        """Return data (draw, value) as the hypothesis expects them."""
        values, combinations = self.spread.shape
        return np.asarray(
            self.mean
            + rng.standard_normal((count, combinations)) @ self.spread.T
            + rng.standard_normal((count, values))
        )


@dataclass(frozen=True)
class Outcome:
    """What to expect of a measurement: the ``information``, bits, and the ``probability`` that what is likeliest with
    it is right.
    """

    information: float
    probability: float


def distances(predictions: Sequence[Prediction]) -> FloatArray:
    """Return Bhattacharyya's distance B between any two predictions, (hypothesis, hypothesis).

    B = d^T S^-1 d / 8 + log(det S / sqrt(det S_1 det S_2)) / 2,  S = (S_1 + S_2) / 2,  d = m_1 - m_2.
    """
    found = np.zeros((len(predictions), len(predictions)))
    excess = [own.excess for own in predictions]
    volume = [_half_log_det(_cholesky(own)) for own in excess]
    for i, one in enumerate(predictions):
        for j, two in enumerate(predictions[:i]):
            lower = _cholesky(0.5 * (excess[i] + excess[j]))
            white = solve_triangular(lower, one.mean - two.mean, lower=True)
            wider = _half_log_det(lower) - 0.5 * (volume[i] + volume[j])
            found[i, j] = found[j, i] = float(white @ white) / 8 + wider
    return found


def least_information(weights: FloatArray, apart: FloatArray) -> float:
    """Return a lower bound (bits) of the information about hypotheses with these ``weights`` (hypothesis,).

        I >= - sum over i of w_i log sum over j of w_j exp(-B_ij)

    with the `distances` B of what they predict (Kolchinsky and Tracey, Entropy 19, 361, 2017).
    """
    return float(-weights @ logsumexp(-apart, b=weights, axis=1)) / float(np.log(2))


def outcome(
    weights: FloatArray, predictions: Sequence[Prediction], rng: np.random.Generator, alike: FloatArray | float = 1.0
) -> Outcome:
    """Return what to expect of a measurement, the mean over data that are drawn from each prediction in turn.

    ``alike`` (hypothesis,): how many places each stands for that no data tell apart, and one of which is right.
    """
    information, probability = 0.0, 0.0
    for own, prediction in zip(weights, predictions, strict=True):
        data = prediction.draw(rng, HYPOTHESES.draws)
        logs = np.log(weights)[:, None] + np.array([other.log_density(data) for other in predictions])
        logs -= logsumexp(logs, axis=0)
        surprise = -np.sum(np.exp(logs) * logs, axis=0)  # of which is right, once the data are known
        information -= float(own * surprise.mean())
        probability += float(own * (np.exp(logs).T / alike).max(axis=1).mean())
    whole = -float(weights @ np.log(weights))
    return Outcome(max(whole + information, 0.0) / float(np.log(2)), probability)


def _cholesky(excess: FloatArray) -> FloatArray:
    """Return the Cholesky factor of 1 + ``excess``, with what rounding makes of its largest values on top."""
    rounding = len(excess) * np.finfo(float).eps * float(np.diag(excess).max(initial=0.0))
    return np.asarray(np.linalg.cholesky((1 + rounding) * np.eye(len(excess)) + excess))


def _half_log_det(lower: FloatArray) -> float:
    return float(np.log(np.diag(lower)).sum())
