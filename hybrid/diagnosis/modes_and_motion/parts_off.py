"""Which nominal parts are off by more than is normal, by their own uncertainty, and beside something unknown."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import norm

from fe_models.arrays import TINY, FloatArray
from hybrid.diagnosis.modal.config import CONCLUSION
from hybrid.diagnosis.modal.evidence import ModalFit, fit_claim
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modes_and_motion.unsure_modes import moved_by_unknown


@dataclass(frozen=True)
class Unknown:
    """Something that may act in all recordings, with a ``probability``, and is not known: forces on the modes of a
    ``size`` over the motion and a radian.
    """

    probability: float
    size: float


def parts_surely_off(measured: ModalData, fit: ModalFit) -> dict[int, float]:
    """Return which of the nominal parts are surely off by more than is normal, by number, and how probable that is of
    each by its own uncertainty.
    """
    surely = _probability_off(measured, fit)
    return {
        number: float(surely[number])
        for number, part in enumerate(measured.nominal.parts)
        if surely[number] >= CONCLUSION.min_probability and (part.elements or part.group)
    }


def parts_off_beside(measured: ModalData, fit: ModalFit, unknown: Unknown | None) -> dict[int, float]:
    """Return which of the parts that are surely off are so more probably than not beside something ``unknown`` that may
    move the same modes, by number, with that probability.
    """
    surely = parts_surely_off(measured, fit)
    if unknown is None or not surely:
        return surely
    unsure = replace(measured, recordings=tuple(moved_by_unknown(own, unknown.size) for own in measured.recordings))
    again = fit_claim(unsure, fit.start)
    beside = np.zeros(len(measured.nominal.parts)) if again is None else _probability_off(unsure, again)
    found = {
        number: own + unknown.probability * min(float(beside[number]) - own, 0.0) for number, own in surely.items()
    }
    return {number: own for number, own in found.items() if own >= CONCLUSION.even}


def is_off_throughout(measured: ModalData, fit: ModalFit) -> bool:
    """Return whether most of the stiffnesses fit best where they are off by more than is normal: what they have in
    common may be unsure, and with it each of them, but one cause at one place moves few.
    """
    nominal = measured.nominal
    own = [number for number, part in enumerate(nominal.parts) if part.quantity == "stiffness"]
    total = (fit.theta[: fit.nuisances] + measured.offset)[own]
    return bool(np.median(np.abs(total) / nominal.spread[own]) > CONCLUSION.normal_sigma) if own else False


def _probability_off(measured: ModalData, fit: ModalFit) -> FloatArray:
    """Return how probable it is that each nominal part (part,) is off by more than is normal."""
    nominal = measured.nominal
    own = slice(len(nominal.parts))
    errors, total = np.sqrt(np.diag(fit.covariance))[own], (fit.theta[: fit.nuisances] + measured.offset)[own]
    beyond = np.abs(total) - CONCLUSION.normal_sigma * nominal.spread[own]
    return np.asarray(norm.cdf(beyond / np.maximum(errors, TINY)))
