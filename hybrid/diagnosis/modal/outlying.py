"""Measured modes whose identification errs by more than it says: Student's distribution in place of the normal one.

Of each mode of a recording, what is its own error (identification's, and what differs from one recording to the next)
is a normal one of kappa times that variance, 1 / kappa distributed as chi squared over its degrees of freedom, for
frequency, damping ratio and shape apart. The likeliest kappa of one or more is taken, given all other rows.
"""

import numpy as np
from scipy.linalg import eigh

from fe_models.arrays import FloatArray, IntArray
from hybrid.diagnosis.modal.config import OUTLYING
from hybrid.diagnosis.modal.errors import ErrorSizes, Rows
from hybrid.diagnosis.modal.paired_rows import Inflation, Pairs

TRIED = np.geomspace(1.0, OUTLYING.most, OUTLYING.steps)  # kappa


def log_prior_of(kappa: FloatArray) -> FloatArray:
    """Return the log density of kappa, over that of 1."""
    half = OUTLYING.degrees / 2
    return np.asarray(-(half + 1) * np.log(kappa) - half * (1 / kappa - 1))


def log_prior_in(inflation: Inflation) -> float:
    """Return the log prior of all that is inflated."""
    return float(sum(log_prior_of(np.square(own)).sum() for own in inflation.values()))


def likeliest_inflation(rows: Rows, residual: FloatArray, sizes: ErrorSizes, pairs: Pairs) -> Inflation:
    """Return how much larger the errors of measured modes are than they say, as a ``residual`` (row,) has it."""
    inverse = np.asarray(np.linalg.inv(rows.covariance(sizes)), dtype=np.float64)
    along = inverse @ residual
    varies = rows.by_row(sizes, "_varies") / rows.inflation
    own = rows.noise + np.diag(varies**2)
    each = np.split(np.arange(len(residual)), len(pairs))
    found = {}
    for block, recording, mode in zip(each, pairs.recording.tolist(), pairs.measured.tolist(), strict=True):
        parts = [block[rows.quantity[block] == 0], block[rows.quantity[block] == 1], block[rows.quantity[block] > 1]]
        factors = [_factor(inverse, along, own, rows.inflation, part) for part in parts]
        found[recording, mode] = (factors[0], factors[1], factors[2])
    return found


def _factor(inverse: FloatArray, along: FloatArray, own: FloatArray, inflation: FloatArray, part: IntArray) -> float:
    """Return the likeliest square root of kappa of some rows, all others given."""
    if not len(part):
        return 1.0
    square = np.ix_(part, part)
    given = np.asarray(np.linalg.inv(inverse[square]), dtype=np.float64)  # covariance of these rows, given all others
    others = given - inflation[part[0]] ** 2 * own[square]
    variances, vectors = eigh(others, own[square])  # in which own errors are independent and of variance 1
    left = vectors.T @ (given @ along[part])
    total = TRIED[:, None] + np.maximum(variances, 0.0)
    density = -0.5 * np.sum(np.log(total) + left**2 / total, axis=1) + log_prior_of(TRIED)
    return float(np.sqrt(TRIED[np.argmax(density)]))
