"""The fit of the nominal structure with nothing wrong in it but values that may be far off."""

from dataclasses import dataclass, replace

import numpy as np

from hybrid.diagnosis.modal.config import FIT
from hybrid.diagnosis.modal.error_sizes import ErrorSizes
from hybrid.diagnosis.modal.evidence import ModalFit, Start, fit_claim
from hybrid.diagnosis.modal.inflation import likeliest_inflation
from hybrid.diagnosis.modal.modal_data import ModalData


@dataclass(frozen=True)
class NominalFit:
    """What was ``measured`` beside a nominal model, and the ``fit`` of nothing wrong with it."""

    measured: ModalData
    fit: ModalFit


def null_fit(measured: ModalData) -> ModalFit | None:
    """Return the fit of the nominal structure, its values as far off as the modes say.

    From values as they were drawn, and, where much is left, from others: far off, a measured mode is at first taken for
    another one, and errors for as large as that makes them, or for none. Until the best is found again and again.
    """
    rng, parts = np.random.default_rng(0), len(measured.nominal.parts)
    found = _with_doubts(measured)
    for number in range(1 + FIT.null_starts):
        theta = -measured.offset
        if number:
            theta[:parts] += FIT.start_spread * rng.standard_normal(parts)
        sizes = ErrorSizes(element_scale=FIT.element_scales[number % len(FIT.element_scales)])
        item = fit_claim(measured, Start(measured.null, theta, sizes), FIT.null_iterations)
        found += [] if item is None else [item]
        best = max(found, key=lambda own: own.evidence, default=None)
        if best is None or (best.sizes.are_usual and len(best.pairs) == measured.modes):
            break
        if sum(own.evidence > best.evidence - FIT.same_nats for own in found) >= FIT.null_agreeing:
            break
    return max(found, key=lambda own: own.evidence, default=None)


def _with_doubts(measured: ModalData) -> list[ModalFit]:
    """Return the fit that begins with doubts in frequencies that are far from those drawn, where some modes' shapes are
    not known: begun without, values are off by as much as a wrong frequency asks for.
    """
    start = Start(measured.null, -measured.offset, ErrorSizes())
    begun = None
    if not all(own.has_shape.all() for own in measured.recordings):
        begun = fit_claim(measured, start, 1, errors_too=False)
    if begun is None or not len(begun.pairs):
        return []
    doubts = likeliest_inflation(measured, begun.rows, begun.residual, begun.sizes, begun.pairs)
    item = fit_claim(measured, replace(start, inflation=doubts), FIT.null_iterations)
    return [] if item is None else [item]
