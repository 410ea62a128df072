"""What a structure's motion has that no model of it does, in proportion to that motion, and whether that is usual.

Of two kinds: small forces on the modes, which let their phases drift, and what sensors show that is none of these
modes, as that of other ones or sums of frequencies.
"""

from dataclasses import dataclass
from math import exp

import numpy as np
from scipy.stats import norm

from hybrid.diagnosis.discrepancy.config import DISCREPANCY

EVEN = 0.5  # of two probabilities


def log_prior_of(size: float) -> float:
    """Return the log density, over its logarithm, of the discrepancy's size where a model is right: log-normal."""
    return float(norm.logpdf(np.log(size), np.log(DISCREPANCY.usual_size), DISCREPANCY.usual_spread))


def usual_probability(size: float) -> float:
    """Return how probable it is that a discrepancy is that of a right model, rather than of something unknown: that has
    any size beyond the usual one, up to the whole motion.
    """
    if size <= DISCREPANCY.usual_size:
        return 1.0
    unknown = DISCREPANCY.odds_unknown / -float(np.log(DISCREPANCY.usual_size))
    usual = exp(log_prior_of(size))
    return usual / (usual + unknown)


def right_law_probability(before: float, after: float) -> float:
    """Return how probable it is that a law is the right one, as it changes the discrepancy's size from ``before`` to
    ``after``, rather than one that resembles another.

    That of a right model has a log-normal distribution; a law like another leaves any share of the energy: a share
    (after / before)^2 that is uniform has the density 2 (after / before)^2 over the logarithm of the size.
    """
    alike = DISCREPANCY.odds_off_list * 2 * min(after / before, 1.0) ** 2
    right = exp(log_prior_of(after))
    return right / (right + alike)


@dataclass(frozen=True)
class Discrepancy:
    """What differs from the motion of a model: forces on modes, of a ``size`` over the motion and a radian, and what
    sensors show besides, of a ``share`` of what they show.
    """

    size: float
    share: float

    @property
    def whole(self) -> float:
        """Both together."""
        return float(np.hypot(self.size, self.share))

    @property
    def log_prior(self) -> float:
        """The log density, over the logarithms of both."""
        return log_prior_of(self.size) + log_prior_of(self.share)

    @property
    def usual_probability(self) -> float:
        """The probability that it is what any right model leaves."""
        return usual_probability(self.whole)

    @property
    def is_usual(self) -> bool:
        """Whether it is that of a right model rather than of something unknown."""
        return self.usual_probability >= EVEN

    @property
    def is_small(self) -> bool:
        """Whether it is no larger than that of a right model usually is: there is nothing to explain."""
        return self.whole <= DISCREPANCY.usual_size

    def times(self, size: float, share: float) -> "Discrepancy":
        """Return the discrepancy with either part so many times as large, not beyond what can be told apart."""
        least, most = DISCREPANCY.min_size, DISCREPANCY.max_size
        return Discrepancy(*(float(np.clip(part, least, most)) for part in (self.size * size, self.share * share)))


START = Discrepancy(DISCREPANCY.usual_start, DISCREPANCY.usual_start)
"""From where the most probable one is sought."""


@dataclass(frozen=True)
class RemainingDiscrepancy:
    """The discrepancy ``before`` anything in the motion is explained, and ``after``."""

    before: Discrepancy
    after: Discrepancy

    @property
    def share(self) -> float:
        """The share of the discrepancy's energy that is left."""
        return float(np.clip((self.after.whole / self.before.whole) ** 2, 0.0, 1.0))
