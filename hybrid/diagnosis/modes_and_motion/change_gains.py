"""What a change between recordings gains: those in which it acts, forecast with it and without.

Each goes on from its first fifth, by a structure fitted to all other recordings and to the modes of that fifth alone.
"""

from dataclasses import replace

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.errors import InputError
from fe_models.recordings import Dataset
from hybrid.diagnosis.discrepancy.expected_modes import MotionClaim, expectation_of
from hybrid.diagnosis.discrepancy.modal_space import ModalSpace
from hybrid.diagnosis.discrepancy.recorded_motions import as_identified
from hybrid.diagnosis.fitting.config import FORECAST
from hybrid.diagnosis.fitting.forecast_score import ForecastScore, shown_of
from hybrid.diagnosis.modal.claim import Claim
from hybrid.diagnosis.modal.evidence import ModalFit, fit_claim
from hybrid.diagnosis.modal.measured_modes import MeasuredModes
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modes_and_motion.forecasts import scored_by
from hybrid.diagnosis.modes_and_motion.motion_fit import kept_for_testing
from hybrid.diagnosis.outcome.forecasts import share
from hybrid.diagnosis.parallel import parallel_map
from hybrid.diagnosis.recorded.batches import measured_columns
from hybrid.identification.identification import identify


def gains_of(dataset: Dataset, measured: ModalData, best: ModalFit) -> dict[int, float]:
    """Return the share of what forecasts get wrong beyond noise that each change takes away, by the number of the
    candidate; changes of which no recording's first fifth shows modes are left out.
    """
    every = len(measured.recordings)
    changes = [number for number, acts in enumerate(best.claim.acts) if len(acts) < every]
    asked = sorted({recording for number in changes for recording in best.claim.acts[number]})
    known = dict(zip(asked, parallel_map(lambda own: _unseeing(dataset, measured, own), asked), strict=True))
    found = {}
    for number in changes:
        pairs = [_scores(dataset, known[own], best, number, own) for own in best.claim.acts[number]]
        both = [pair for pair in pairs if pair is not None]
        if both:
            without, with_change = (sum(score.excess for score in some) for some in zip(*both, strict=True))
            found[number] = 1 - share(with_change, without)
    return found


def _unseeing(dataset: Dataset, measured: ModalData, recording: int) -> ModalData | None:
    """Return what was measured, of one training recording the first fifth alone; None where that shows no modes."""
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


def _scores(
    dataset: Dataset, unseeing: ModalData | None, best: ModalFit, number: int, recording: int
) -> tuple[ForecastScore, ForecastScore] | None:
    """Return how well a recording is forecast without a change, and with it."""
    if unseeing is None:
        return None
    kept = best.claim.hypothesis.parameters_of((number,))
    both = [(best.claim.less(number), best.theta[kept]), (best.claim, best.theta)]
    spaces = [_spaces_of(dataset, unseeing, best, claim, theta, recording) for claim, theta in both]
    if not all(spaces):
        return None
    tested = kept_for_testing(dataset, [recording])
    without, with_change = (scored_by(own, unseeing, tested, state=0) for own in spaces)
    return without, with_change


def _spaces_of(
    dataset: Dataset, measured: ModalData, best: ModalFit, claim: Claim, theta: FloatArray, recording: int
) -> list[ModalSpace]:
    """Return the modes that a recording has by a claim that is fitted anew, and then those of the others that it says
    are of another state; none where the structure does not stand.
    """
    inflation = {place: own for place, own in best.inflation.items() if place[0] != recording}
    fit = fit_claim(measured, claim, theta, best.sizes, FORECAST.fold_iterations, errors_too=False, inflation=inflation)
    if fit is None:
        return []
    others = {claim.idle_in(own): own for own in range(len(measured.recordings))}
    others.pop(claim.idle_in(recording))
    expected = expectation_of(MotionClaim(measured, fit, 1 / dataset.sampling_rate, (recording, *others.values())))
    return [] if expected is None else [own.space for own in as_identified(measured, fit, expected).modes]
