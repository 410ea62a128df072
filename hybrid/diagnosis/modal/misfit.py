"""The misfit of a claim: what it leaves of the measured modes, in units of what these differ by in any case."""

import numpy as np

from fe_models.arrays import FloatArray
from hybrid.diagnosis.modal.evidence import ModalFit
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modal.mode_values import free_values
from hybrid.diagnosis.modal.paired_rows import residual_of, rows_of, unpaired_widths, values_of
from hybrid.diagnosis.modal.pairs import predicted_of
from hybrid.diagnosis.modal.rows import Rows


def misfit_of(measured: ModalData, item: ModalFit, known: ModalFit) -> float:
    """Return the sum of squares of what a fit's theta leaves of the modes that a fit that is ``known`` pairs, in units
    of its errors: of what modes vary by from one recording to the next and what their identification leaves open. Modes
    that the theta itself no longer pairs are off by as much as modes that are none of the structure's.
    """
    predicted, every = predicted_of(measured, item.claim, item.theta)
    pairs = every.among(known.pairs)
    free = free_values(known.pairs.reference, len(measured.sensors))
    alone = ~known.pairs.are_among(pairs)[np.nonzero(free)[0]]
    total = float(np.sum((unpaired_widths(known.rows.quantity) ** 2 / _variance(known.rows, known))[alone]))
    if not len(pairs):
        return total
    seen = values_of(measured, pairs)
    residual, slopes = residual_of(measured, item.claim, pairs, seen.values, predicted)
    rows = rows_of(measured, item.claim, pairs, seen.covariance, slopes[:, : item.nuisances], known.inflation)
    return total + float(np.sum(residual**2 / _variance(rows, known)))


def _variance(rows: Rows, known: ModalFit) -> FloatArray:
    """Return the variance (row,) of what is a recording's own, by the errors of a fit that is ``known``."""
    return np.asarray(np.diag(rows.own_noise) + rows.varying(known.sizes) ** 2)
