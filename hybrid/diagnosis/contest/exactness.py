"""How exact nominal values are: the recordings tell where they are nearer to the drawing than was stated.

Stated uncertainties are what is normal, and a structure may be as drawn. While every nominal value may move as far as
is normal, it takes up what tells one cause from the next. So all stated deviations count times a common scale, whose
values are equally probable beforehand, and evidence is averaged over them (a hierarchical prior: Gelman et al.,
Bayesian Data Analysis, chapter 5). To second order about each fit nothing is fitted anew.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.special import logsumexp, softmax

from fe_models.arrays import FloatArray
from hybrid.diagnosis.fitting.least_squares import Fit

SCALES = (1.0, 1 / 2, 1 / 4, 1 / 8, 1 / 16)  # of the stated standard deviations: 1 % becomes 0.06 % at the least


@dataclass(frozen=True)
class Tightened:
    """What becomes of a fit where nominal values are uncertain by less than was stated.

    ``rise`` of the cost; ``narrowed``: log of what is left of the candidates' parameters' posterior volume; ``volume``:
    log of the share of the nominal values' prior volume that fits, all but for what all scales have in common.
    """

    rise: float
    narrowed: float
    volume: float

    @property
    def gained(self) -> float:
        """What the log evidence gains, all but for the nominal values' volume."""
        return self.narrowed - 0.5 * self.rise


def tightened(item: Fit, scale: float) -> Tightened:
    """Return what becomes of a fit where nominal values are uncertain by ``scale`` times what was stated.

    More precision X of the values moves them towards their centre against the fit's covariance C: the cost rises by
    d (1/X + C)^-1 d of their deviation d, and C becomes (1/C + X)^-1.
    """
    hypothesis, C = item.hypothesis, item.covariance
    values, first = hypothesis.nominal.values, hypothesis.nuisances
    root = np.sqrt(hypothesis.precision[:values] * (1 / scale**2 - 1))
    inner = np.eye(values) + root[:, None] * C[:values, :values] * root
    factor = cho_factor(inner, lower=True)
    deviation = root * (item.theta - hypothesis.centre)[:values]
    shared = root[:, None] * C[:values, first:]
    own = C[first:, first:] - shared.T @ cho_solve(factor, shared)
    narrowed = 0.5 * float(np.linalg.slogdet(own)[1] - np.linalg.slogdet(C[first:, first:])[1])
    whole = -values * np.log(scale) - float(np.log(np.diag(factor[0])).sum())
    return Tightened(float(deviation @ cho_solve(factor, deviation)), narrowed, whole - narrowed)


def log_evidences(fits: Sequence[Fit], best: Fit, temper: float) -> FloatArray:
    """Return the log evidence of each fit (fit,) over the ``temper``, averaged over how exact nominal values may be.

    How much of the nominal values' prior volume fits is that of the ``best`` fit for all, as in `Fit.log_evidence`.
    """
    volumes = [tightened(best, scale).volume for scale in SCALES]
    scaled = [[tightened(item, scale) for scale in SCALES] for item in fits]
    changes = np.array([[change.gained for change in row] for row in scaled])
    evidence = np.array([item.log_evidence for item in fits])[:, None] + changes
    return np.asarray(logsumexp(evidence / temper + volumes, axis=1, b=1 / len(SCALES)))


def expected_square(best: Fit, temper: float) -> float:
    """Return the square of the scale to be expected after the recordings, by what the ``best`` fit makes of them."""
    scaled = [tightened(best, scale) for scale in SCALES]
    weights = softmax([change.gained / temper + change.volume for change in scaled])
    return float(weights @ np.square(SCALES))
