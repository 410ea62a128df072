"""The modes of recordings less what a force law does in them: they are known no better than that is."""

from dataclasses import replace

import numpy as np

from fe_models.arrays import IntArray
from fe_models.recordings import Dataset
from hybrid.diagnosis.discrepancy.config import LAW_FIT
from hybrid.diagnosis.discrepancy.law_search import LawSearch
from hybrid.diagnosis.discrepancy.laws_in_recordings import without_law
from hybrid.diagnosis.modal.measured_modes import MeasuredModes
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modal.mode_values import values_of_modes
from hybrid.diagnosis.modal.pairing import paired
from hybrid.diagnosis.modes_and_motion.measured_in_dataset import measured_in


def measured_less_law(dataset: Dataset, laws: LawSearch, under: ModalData) -> ModalData:
    """Return what was measured of the structure without the law that is named; ``under``: with it."""
    linear, _ = measured_in(without_law(dataset, laws), lambda _: None)
    known = {own.name: own for own in under.recordings}
    recordings = tuple(widened_by_law(own, known[own.name], linear.orders) for own in linear.recordings)
    return replace(linear, recordings=recordings)


def widened_by_law(left: MeasuredModes, under: MeasuredModes, orders: IntArray) -> MeasuredModes:
    """Return the modes that are ``left``, each value as uncertain as what the law makes of it, ``under``, is known."""
    numbers, covariance = paired(left, under.log_omega, under.shapes, orders), left.covariance.copy()
    for mode in np.flatnonzero(numbers >= 0):
        other, shape, own = numbers[mode], left.shapes[mode], under.shapes[numbers[mode]]
        bent = shape - own * (own.conj() @ shape) / (own.conj() @ own).real  # of the same size and phase
        moved = values_of_modes(
            left.log_omega[mode] - under.log_omega[other], left.ratios[mode] - under.ratios[other], bent
        )
        error = LAW_FIT.relative_error * moved
        covariance[mode] += np.diag(error**2)
    return replace(left, covariance=covariance)
