"""Measured modes whose identification errs by more than it says: Student's distribution in place of the normal one.

Of each mode of a recording, what is its own error (identification's, and what differs from one recording to the next)
is a normal one of kappa times that variance, 1 / kappa distributed as chi squared over its degrees of freedom, for
frequency, damping ratio and shape apart. The likeliest kappa of one or more is taken, given all other rows.
"""

from collections.abc import Sequence

import numpy as np

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
    parts = [block[rows.quantity[block] == kind] for block in each for kind in (0, 1)]
    parts += [block[rows.quantity[block] > 1] for block in each]
    factors = _factors(inverse, along, own, rows.inflation, parts)
    apart, shapes = factors[: 2 * len(each)].reshape(-1, 2).tolist(), factors[2 * len(each) :].tolist()
    places = zip(pairs.recording.tolist(), pairs.measured.tolist(), strict=True)
    return {place: (*two, one) for place, two, one in zip(places, apart, shapes, strict=True)}


def _factors(
    inverse: FloatArray, along: FloatArray, own: FloatArray, inflation: FloatArray, parts: Sequence[IntArray]
) -> FloatArray:
    """Return the likeliest square root of kappa (part,) of each of some ``parts`` of the rows, all others given."""
    sizes, found = np.array([len(part) for part in parts]), np.ones(len(parts))
    for size in sorted(set(sizes[sizes > 0].tolist())):
        chosen = np.flatnonzero(sizes == size)
        rows: IntArray = np.array([parts[number] for number in chosen.tolist()])
        square = rows[:, :, None], rows[:, None, :]
        given = np.linalg.inv(inverse[square])  # covariance of these rows, given all others
        others = given - inflation[rows[:, :1, None]] ** 2 * own[square]
        white = np.linalg.inv(np.linalg.cholesky(own[square]))
        back = white.swapaxes(1, 2)
        variances, vectors = np.linalg.eigh(white @ others @ back)  # own errors are independent and of variance 1
        left = (vectors.swapaxes(1, 2) @ white @ given @ along[rows][..., None])[..., 0]
        total = TRIED[:, None, None] + np.maximum(variances, 0.0)
        density = -0.5 * np.sum(np.log(total) + left**2 / total, axis=2) + log_prior_of(TRIED)[:, None]
        found[chosen] = np.sqrt(TRIED[np.argmax(density, axis=0)])
    return found
