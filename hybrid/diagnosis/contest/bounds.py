"""How far a fit may be behind the best of its rivals for its rank to matter."""

import numpy as np

from hybrid.diagnosis.contest.posterior import temper_of
from hybrid.diagnosis.fitting.least_squares import Fit

BEHIND = 20.0  # in half the tempered sum of squares: a fit that far behind another of the same recordings is given up
LEFT = 0.3  # of what the best leaves beyond noise: by how much another may be behind and still go on


def bound_of(fits: list[Fit]) -> float:
    """Return the cost, as `Fit.charged`, beyond which a fit is too far behind the best for its rank to matter.

    Where the best leaves more than noise there may be a second cause, and the one of the two that matters more need
    not be the best yet.
    """
    if not fits:
        return np.inf
    best = min(fits, key=lambda item: item.charged)
    return best.charged + max(2 * BEHIND * temper_of(best), LEFT * best.misfit)
