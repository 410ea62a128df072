"""What a structure's motion has that no model of it does, in proportion to that motion.

Of two kinds: small forces on the modes, which let their phases drift, and what sensors show that is none of these
modes, as that of other ones or sums of frequencies.
"""

from dataclasses import dataclass

import numpy as np
from scipy.stats import norm

from hybrid.diagnosis.discrepancy.config import DISCREPANCY


def log_prior_of(size: float) -> float:
    """Return the log density, over its logarithm, of the discrepancy's size where a model is right: log-normal."""
    return float(norm.logpdf(np.log(size), np.log(DISCREPANCY.usual_size), DISCREPANCY.usual_spread))


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

    def times(self, size: float, share: float) -> "Discrepancy":
        """Return the discrepancy with either part so many times as large, not beyond what can be told apart."""
        least, most = DISCREPANCY.least, DISCREPANCY.most
        return Discrepancy(*(float(np.clip(part, least, most)) for part in (self.size * size, self.share * share)))


STARTED = Discrepancy(DISCREPANCY.usual_start, DISCREPANCY.usual_start)
"""From where the most probable one is sought."""
