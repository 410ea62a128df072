"""Claims beside something that nobody knows: it changes the motion within recordings, and moves their modes as well."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hybrid.diagnosis.discrepancy.size import Discrepancy
from hybrid.diagnosis.modal.claim import Measured
from hybrid.diagnosis.modal.config import CONCLUSION
from hybrid.diagnosis.modal.evidence import ModalFit, fit_claim
from hybrid.diagnosis.modal.measured_modes import MeasuredModes
from hybrid.diagnosis.modal.search import Search


def refitted_beside(
    left: Discrepancy, measured: Measured, search: Search, fits: Sequence[ModalFit]
) -> tuple[Measured, list[ModalFit]]:
    """Return what was measured, as sure as motions with a discrepancy that is ``left`` tell it, and the best of the
    ``fits`` anew, with those less one of the first's causes, most probable first.
    """
    unsure = replace(measured, recordings=tuple(strayed(own, left.size) for own in measured.recordings))
    best = fits[0]
    less = [
        (best.claim.less(number), best.theta[best.claim.hypothesis.parameters_of((number,))], best)
        for number in range(len(best.claim.acts))
    ]
    tried = [(item.claim, item.theta, item) for item in fits[: CONCLUSION.refitted]] + less
    found = [
        fit_claim(unsure, claim, theta, item.sizes, inflation=item.inflation)
        for claim, theta, item in {claim.key: (claim, theta, item) for claim, theta, item in reversed(tried)}.values()
    ]
    return unsure, search.ranked([item for item in found if item is not None]) or list(fits)


def strayed(own: MeasuredModes, size: float) -> MeasuredModes:
    """Return modes as sure as they are known where their amplitudes stray by a ``size`` of themselves a radian.

    As in a random walk: from the 1 / ratio radians that a mode lives its frequency, of itself, and its damping ratio
    are known to within the size over their square root.
    """
    covariance, variance = own.covariance.copy(), size**2 * np.maximum(own.ratios, 0.0)
    for place in range(2):  # log frequency, ratio
        covariance[:, place, place] += variance
    return replace(own, covariance=covariance)
