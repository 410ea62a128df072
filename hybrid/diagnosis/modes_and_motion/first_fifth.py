"""A recording as a structure has it that was fitted to all others, and to the modes of its own first fifth alone.

So a change is forecast that acts in this recording and in no other.
"""

from dataclasses import replace

import numpy as np

from fe_models.errors import InputError
from fe_models.recordings import Dataset
from hybrid.diagnosis.discrepancy.expected_modes import MotionClaim, expectation_of
from hybrid.diagnosis.discrepancy.modal_space import ModalSpace
from hybrid.diagnosis.discrepancy.recorded_motions import as_identified
from hybrid.diagnosis.fitting.config import FORECAST
from hybrid.diagnosis.fitting.forecast_score import shown_of
from hybrid.diagnosis.modal.evidence import ModalFit, Start, fit_claim
from hybrid.diagnosis.modal.measured_modes import MeasuredModes
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.recorded.batches import measured_columns
from hybrid.identification.identification import identify


def with_first_fifth_of(dataset: Dataset, measured: ModalData, recording: int) -> ModalData | None:
    """Return what was ``measured``, with the modes of the first fifth of one training ``recording`` in place of all of
    its own; None where that shows none.
    """
    own = dataset.select("train")[recording]
    columns = list(measured_columns(dataset))
    slowest = float(measured.nominal.modes[0][0]) / (2 * np.pi)
    begun = [motion[: shown_of(len(motion)), columns] for motion in own.data]
    try:
        shown = identify(
            begun, measured.rate, slowest, dataset.lowpass or measured.rate / 2, measured.orders, own.excitation
        )
    except InputError:
        return None
    begin = MeasuredModes.of(own.name, shown.modes)
    if not len(begin.log_omega):
        return None
    every = (*measured.recordings[:recording], begin, *measured.recordings[recording + 1 :])
    return replace(measured, recordings=every)


def spaces_of(
    dataset: Dataset, measured: ModalData, best: ModalFit, recording: int, start: Start | None = None
) -> list[ModalSpace]:
    """Return the modes that a ``recording`` has by a claim that is fitted anew to what was ``measured``, and then those
    of the others that it says are of another state; none where the structure does not stand.

    ``start``: of the fit to the claim; None: the ``best`` fit.
    """
    start = start or best.start
    claim, inflation = start.claim, {place: own for place, own in start.inflation.items() if place[0] != recording}
    fit = fit_claim(measured, replace(start, inflation=inflation), FORECAST.fold_iterations, errors_too=False)
    if fit is None:
        return []
    others = {claim.idle_in(own): own for own in range(len(measured.recordings))}
    others.pop(claim.idle_in(recording))
    expected = expectation_of(MotionClaim(measured, fit, 1 / dataset.sampling_rate, (recording, *others.values())))
    return [] if expected is None else [own.space for own in as_identified(measured, fit, expected).modes]
