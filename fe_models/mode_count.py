"""How many natural modes a linear model has: as many as M has rank, not one for each degree of freedom."""

import numpy as np
from scipy.linalg import eigvalsh

from fe_models.linear import LinearModel

LARGEST_DENSE_SOLVE = 400
"""Free degrees of freedom up to which all modes at once take no longer than a few by shift and invert (0.1 s)."""
RANK_TOLERANCE = 1e-12
"""Eigenvalue of M scaled to a unit diagonal below which a motion has no mass; consistent beams have 1e-2, rounding
leaves 1e-16."""


def mode_count(model: LinearModel) -> int:
    """Return how many natural modes a model has.

    A degree of freedom without mass adds none, nor do several that share one mass, as a node and the rotation that
    carries a mass on a rigid link; of models of more than `LARGEST_DENSE_SOLVE` only the former is looked at.
    """
    diagonal = model.mass.diagonal()
    weighty = np.flatnonzero(diagonal > 0)
    if not 0 < len(weighty) <= LARGEST_DENSE_SOLVE:
        return len(weighty)
    scale = 1 / np.sqrt(diagonal[weighty])
    values = eigvalsh(model.mass[weighty][:, weighty].toarray() * np.outer(scale, scale))
    return int(np.sum(values > RANK_TOLERANCE))
