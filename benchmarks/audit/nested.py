"""Evidence by nested sampling (Skilling, Bayesian Analysis 1, 833, 2006) with dynesty (Speagle, MNRAS 493, 3132, 2020).

Sampled are not draws of the prior, of which fits leave next to nothing, but of a normal distribution q about the fit,
far wider than it; the likelihood is weighed with the prior over q, so that the integral is the same (posterior
repartitioning: Chen et al., Statistics and Computing 29, 835, 2019):

    Z = integral L(theta) p(theta) dtheta = integral (L p / q) q dtheta.

What has another optimum altogether, many standard deviations off, is not found so.
"""

import warnings
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_triangular
from scipy.special import ndtri

from fe_models.arrays import FloatArray

WIDER = 3.0  # times the fit's standard deviations
LIVE = 100  # points: errors of some tenths of log Z
ENLARGED = 3.0  # times its volume: the least ellipsoid about all live points, so that it holds what they are drawn of;
# bootstraps make it so large in seven dimensions that one of 25 draws is inside
ENOUGH = 0.05  # of log Z, that is left where sampling ends
LEAST = 1e-15  # of a side of the unit cube: a normal value of 8
NOTHING = -1e100  # log density beyond a bound, or where a structure does not stand


@dataclass(frozen=True, eq=False)
class Target:
    """What is integrated over theta (parameter,): ``log_density`` of likelihood times prior; None where it is nothing.

    ``lower`` and ``upper`` bounds; ``mean`` (parameter,) and ``covariance`` of the fit; ``closed``:
    the log evidence in closed form; ``odds``: the log probability of what is claimed beforehand.
    """

    name: str
    log_density: Callable[[FloatArray], float | None]
    lower: FloatArray
    upper: FloatArray
    mean: FloatArray
    covariance: FloatArray
    closed: float
    odds: float


@dataclass(frozen=True)
class Sampled:
    """A log ``evidence`` by nested sampling, the standard ``error`` of that, and how many ``calls`` it took."""

    evidence: float
    error: float
    calls: int


def sampled(target: Target, seed: int, live: int = LIVE) -> Sampled:
    """Return the evidence of a target by nested sampling."""
    from dynesty import NestedSampler

    size = len(target.mean)
    lower = WIDER * np.linalg.cholesky(target.covariance)
    log_volume = float(np.log(np.diag(lower)).sum() + 0.5 * size * np.log(2 * np.pi))

    def place(cube: FloatArray) -> FloatArray:
        """Return theta of a point of the unit cube."""
        return np.asarray(target.mean + lower @ ndtri(np.clip(cube, LEAST, 1 - LEAST)))

    def log_weighed(theta: FloatArray) -> float:
        inside = (theta > target.lower) & (theta < target.upper)
        own = target.log_density(theta) if inside.all() else None
        if own is None:
            return NOTHING
        near = solve_triangular(lower, theta - target.mean, lower=True)
        return own + float(0.5 * near @ near) + log_volume

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of the sampler's own arithmetic, where next to nothing weighs
        rng = np.random.default_rng(seed)
        bounded = {"bound": "single", "sample": "unif", "bootstrap": 0, "enlarge": ENLARGED}
        sampler = NestedSampler(log_weighed, place, size, nlive=live, rstate=rng, **bounded)
        sampler.run_nested(dlogz=ENOUGH, print_progress=False)
    found = sampler.results
    return Sampled(float(found.logz[-1]), float(found.logzerr[-1]), int(np.sum(found.ncall)))
