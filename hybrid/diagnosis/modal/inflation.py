"""Measured modes whose identification errs by more than it says: Student's distribution in place of the normal one.

Of each mode of a recording, what is its own error (identification's, and what differs from one recording to the next)
is a normal one of kappa times that variance, 1 / kappa distributed as chi squared over its degrees of freedom, for
frequency, damping ratio and shape apart. The likeliest kappa of one or more is taken, given all other rows.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from fe_models.arrays import FloatArray, IntArray
from hybrid.diagnosis.modal.config import INFLATION
from hybrid.diagnosis.modal.error_sizes import ErrorSizes
from hybrid.diagnosis.modal.mode_values import FREQUENCY, RATIO
from hybrid.diagnosis.modal.pairs import Pairs
from hybrid.diagnosis.modal.rows import Rows


class ErrorFactors(NamedTuple):
    """How many times larger than it says the error of a measured mode is: of its frequency, damping ratio and shape."""

    frequency: float
    ratio: float
    shape: float


Inflation = Mapping[tuple[int, int], ErrorFactors]
"""The factors of measured modes, by recording and number of the mode; of all others one."""

NOT_INFLATED = ErrorFactors(1.0, 1.0, 1.0)
KAPPAS = np.geomspace(1.0, INFLATION.max_variance_factor, INFLATION.steps)  # that are compared


def log_prior_of(kappa: FloatArray) -> FloatArray:
    """Return the log density of kappa, over that of 1."""
    half = INFLATION.degrees / 2
    return np.asarray(-(half + 1) * np.log(kappa) - half * (1 / kappa - 1))


def log_prior_in(inflation: Inflation) -> float:
    """Return the log prior of all that is inflated."""
    return float(sum(log_prior_of(np.square(own)).sum() for own in inflation.values()))


def likeliest_inflation(rows: Rows, residual: FloatArray, sizes: ErrorSizes, pairs: Pairs) -> Inflation:
    """Return how much larger the errors of measured modes are than they say, as a ``residual`` (row,) has it."""
    inverse = np.asarray(np.linalg.inv(rows.covariance(sizes)), dtype=np.float64)
    along = inverse @ residual
    varying = rows.varying(sizes) / rows.inflation
    own = rows.noise + np.diag(varying**2)
    each = np.split(np.arange(len(residual)), len(pairs))
    parts = [block[rows.quantity[block] == quantity] for block in each for quantity in (FREQUENCY, RATIO)]
    parts += [block[rows.quantity[block] > RATIO] for block in each]  # of shapes
    factors = _factors(inverse, along, own, rows.inflation, parts)
    apart, shapes = factors[: 2 * len(each)].reshape(-1, 2).tolist(), factors[2 * len(each) :].tolist()
    each_pair = zip(pairs.places, apart, shapes, strict=True)
    return {place: ErrorFactors(frequency, ratio, shape) for place, (frequency, ratio), shape in each_pair}


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
        total = KAPPAS[:, None, None] + np.maximum(variances, 0.0)
        density = -0.5 * np.sum(np.log(total) + left**2 / total, axis=2) + log_prior_of(KAPPAS)[:, None]
        found[chosen] = np.sqrt(KAPPAS[np.argmax(density, axis=0)])
    return found
