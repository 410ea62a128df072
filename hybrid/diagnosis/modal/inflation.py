"""Measured modes whose identification errs by more than it says: Student's distribution in place of the normal one.

Of each mode of a recording, what is its own error (identification's, and what differs from one recording to the next)
is a normal one of kappa times that variance, 1 / kappa distributed as chi squared over its degrees of freedom, for
frequency, damping ratio and shape apart. The likeliest kappa of one or more is taken, given all other rows.

A mode whose shape is not known is taken for the structure's by its frequency alone: as probably as any measured mode is
none of the structure's, it is another, and its kappa any up to the largest.
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from fe_models.arrays import FloatArray, IntArray
from hybrid.diagnosis.modal.config import INFLATION, UNPAIRED
from hybrid.diagnosis.modal.error_sizes import ErrorSizes
from hybrid.diagnosis.modal.modal_data import ModalData
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


def log_prior_without_shape(kappa: FloatArray) -> FloatArray:
    """Return the log density of kappa, over that of 1, of the frequency of a mode whose shape is not known."""
    another = np.log(UNPAIRED.probability / np.log(INFLATION.max_variance_factor))  # that it is of any other mode
    return np.asarray(np.logaddexp(log_prior_of(kappa), another) - np.logaddexp(0.0, another))


def log_prior_in(inflation: Inflation, measured: ModalData) -> float:
    """Return the log prior of all that is inflated."""
    total = 0.0
    for (recording, mode), own in inflation.items():
        of_frequency = log_prior_of if measured.recordings[recording].has_shape[mode] else log_prior_without_shape
        kappa = np.square(own)
        total += float(of_frequency(kappa[:1]).sum() + log_prior_of(kappa[1:]).sum())
    return total


def without_doubts_in_frequencies(measured: ModalData, inflation: Inflation) -> Inflation:
    """Return how errors are inflated, but for those of modes whose shapes are not known."""
    return {
        (recording, mode): own if measured.recordings[recording].has_shape[mode] else NOT_INFLATED
        for (recording, mode), own in inflation.items()
    }


def likeliest_inflation(
    measured: ModalData, rows: Rows, residual: FloatArray, sizes: ErrorSizes, pairs: Pairs
) -> Inflation:
    """Return how much larger the errors of measured modes are than they say, as a ``residual`` (row,) has it."""
    inverse = np.asarray(np.linalg.inv(rows.covariance(sizes)), dtype=np.float64)
    along = inverse @ residual
    varying = rows.varying(sizes) / rows.inflation
    own = rows.noise + np.diag(varying**2)
    each = np.split(np.arange(len(residual)), len(pairs))
    parts = [block[rows.quantity[block] == quantity] for block in each for quantity in (FREQUENCY, RATIO)]
    parts += [block[rows.quantity[block] > RATIO] for block in each]  # of shapes
    usual = log_prior_of(KAPPAS)
    by_frequency = {True: usual, False: log_prior_without_shape(KAPPAS)}
    have_shapes = [bool(measured.recordings[recording].has_shape[mode]) for recording, mode in pairs.places]
    priors = [prior for has_shape in have_shapes for prior in (by_frequency[has_shape], usual)] + [usual] * len(each)
    factors = _factors(inverse, along, own, rows.inflation, parts, np.array(priors))
    apart, shapes = factors[: 2 * len(each)].reshape(-1, 2).tolist(), factors[2 * len(each) :].tolist()
    each_pair = zip(pairs.places, apart, shapes, strict=True)
    return {place: ErrorFactors(frequency, ratio, shape) for place, (frequency, ratio), shape in each_pair}


def _factors(
    inverse: FloatArray,
    along: FloatArray,
    own: FloatArray,
    inflation: FloatArray,
    parts: Sequence[IntArray],
    priors: FloatArray,
) -> FloatArray:
    """Return the likeliest square root of kappa (part,) of each of some ``parts`` of the rows, all others given;
    ``priors`` (part, kappa): log densities of its kappas.
    """
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
        density = -0.5 * np.sum(np.log(total) + left**2 / total, axis=2) + priors[chosen].T
        found[chosen] = np.sqrt(KAPPAS[np.argmax(density, axis=0)])
    return found
