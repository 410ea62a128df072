"""Claims beside something that nobody knows: it changes the motion within recordings, and moves their modes as well."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fe_models.arrays import FloatArray
from hybrid.diagnosis.discrepancy.size import Discrepancy
from hybrid.diagnosis.modal.config import CONCLUSION
from hybrid.diagnosis.modal.evidence import ModalFit, fit_claim
from hybrid.diagnosis.modal.measured_modes import MeasuredModes
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modal.mode_values import FREQUENCY, RATIO
from hybrid.diagnosis.modal.search import ClaimSearch, less_one, probabilities


def ranked_with_unsure_modes(
    left: Discrepancy, measured: ModalData, search: ClaimSearch, fits: Sequence[ModalFit]
) -> tuple[list[ModalFit], FloatArray]:
    """Return the best of the ``fits``, and those less one of the first's causes, most probable first, and how probable
    each claim is (fit,) where modes are as sure as motions tell them with a discrepancy that is ``left``.
    """
    unsure = replace(measured, recordings=tuple(widened_by_straying(own, left.size) for own in measured.recordings))
    kept = search.ranked([*fits[: CONCLUSION.refitted], *less_one(measured, fits[0])])
    again = [fit_claim(unsure, item.start) for item in kept]
    both = [(item, new) for item, new in zip(kept, again, strict=True) if new is not None]
    if not both:
        return list(fits), probabilities(search, fits)
    both.sort(key=lambda pair: -search.score(pair[1]))
    return [item for item, _ in both], probabilities(search, [new for _, new in both])


def widened_by_straying(own: MeasuredModes, size: float) -> MeasuredModes:
    """Return modes as sure as they are known where their amplitudes stray by a ``size`` of themselves a radian.

    As in a random walk: from the 1 / ratio radians that a mode lives its frequency, of itself, and its damping ratio
    are known to within the size over their square root.
    """
    covariance, variance = own.covariance.copy(), size**2 * np.maximum(own.ratios, 0.0)
    for place in (FREQUENCY, RATIO):
        covariance[:, place, place] += variance
    return replace(own, covariance=covariance)


def moved_by_unknown(own: MeasuredModes, size: float) -> MeasuredModes:
    """Return modes as sure as they are known where something unknown, of a ``size`` of the motion a radian, may pull
    as steadily as a spring or a dashpot: frequencies, of themselves, damping ratios and entries of shapes, of their
    largest, are then off by about that size.
    """
    return replace(own, covariance=own.covariance + size**2 * np.eye(own.covariance.shape[-1]))
