"""How far a fit may be behind the best of its rivals for its rank to matter."""

import numpy as np

from hybrid.diagnosis.contest.config import SEGMENTS
from hybrid.diagnosis.contest.posterior import temper_of
from hybrid.diagnosis.fitting.least_squares import Fit


def bound_of(fits: list[Fit]) -> float:
    """Return the cost, as `Fit.charged`, beyond which a fit is too far behind the best for its rank to matter.

    Where the best leaves more than noise there may be a second cause, and the one of the two that matters more need
    not be the best yet.
    """
    if not fits:
        return np.inf
    best = min(fits, key=lambda item: item.charged)
    return best.charged + max(2 * SEGMENTS.given_up_behind * temper_of(best), SEGMENTS.max_behind_share * best.misfit)
