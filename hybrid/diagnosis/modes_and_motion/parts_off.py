"""Which nominal parts are off by more than is normal, by their own uncertainty, and beside something unknown."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import norm

from fe_models.arrays import TINY, FloatArray
from hybrid.diagnosis.modal.config import CONCLUSION
from hybrid.diagnosis.modal.error_sizes import NOMINAL_KINDS, SCALE_OF
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
    return _parts(measured, _probability_off(measured, fit), {})


def parts_found_off(measured: ModalData, fit: ModalFit, unknown: Unknown | None) -> dict[int, float]:
    """Return which of the nominal parts are found to be off, by number, and how probable it is that each is off by more
    than is normal: by its own uncertainty, and by that of modes which something ``unknown`` may move.

    Where values of a quantity are off as a whole by what is worth a note, that each of them is more probable than not
    is enough: what they have in common may be unsure, and yet one or the other is off.
    """
    surely = _probability_off(measured, fit)
    if unknown is not None and unknown.probability > 0:
        unsure = replace(measured, recordings=tuple(moved_by_unknown(own, unknown.size) for own in measured.recordings))
        again = fit_claim(unsure, fit.claim, fit.theta, fit.sizes, inflation=fit.inflation)
        beside = np.zeros_like(surely) if again is None else _probability_off(unsure, again)
        surely = surely + unknown.probability * np.minimum(beside - surely, 0.0)
    noted = [kind for kind in NOMINAL_KINDS if getattr(fit.sizes, SCALE_OF[kind]) > CONCLUSION.worth_a_note]
    return _parts(measured, surely, dict.fromkeys(noted, CONCLUSION.even))


def _parts(measured: ModalData, surely: FloatArray, least: Mapping[str, float]) -> dict[int, float]:
    """Return the probability of each nominal part that is off with at least that of its quantity, by number."""
    return {
        number: float(surely[number])
        for number, part in enumerate(measured.nominal.parts)
        if surely[number] >= least.get(part.quantity, CONCLUSION.min_probability) and (part.elements or part.group)
    }


def _probability_off(measured: ModalData, fit: ModalFit) -> FloatArray:
    """Return how probable it is that each nominal part (part,) is off by more than is normal."""
    nominal = measured.nominal
    own = slice(len(nominal.parts))
    errors, total = np.sqrt(np.diag(fit.covariance))[own], (fit.theta[: fit.nuisances] + measured.offset)[own]
    beyond = np.abs(total) - CONCLUSION.normal_sigma * nominal.spread[own]
    return np.asarray(norm.cdf(beyond / np.maximum(errors, TINY)))
