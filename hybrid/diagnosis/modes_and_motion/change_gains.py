"""What a change between recordings gains: those in which it acts, forecast with it and without (`first_fifth`)."""

from fe_models.recordings import Dataset
from hybrid.diagnosis.fitting.forecast_score import ForecastScore
from hybrid.diagnosis.modal.evidence import ModalFit
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modes_and_motion.first_fifth import spaces_of, with_first_fifth_of
from hybrid.diagnosis.modes_and_motion.forecasts import scored_by
from hybrid.diagnosis.modes_and_motion.motion_fit import kept_for_testing
from hybrid.diagnosis.outcome.forecasts import share
from hybrid.diagnosis.parallel import parallel_map


def gains_of(dataset: Dataset, measured: ModalData, best: ModalFit) -> dict[int, float]:
    """Return the share of what forecasts get wrong beyond noise that each change takes away, by the number of the
    candidate; changes of which no recording's first fifth shows modes are left out.
    """
    every = len(measured.recordings)
    changes = [number for number, acts in enumerate(best.claim.acts) if len(acts) < every]
    asked = sorted({recording for number in changes for recording in best.claim.acts[number]})
    shown = parallel_map(lambda own: with_first_fifth_of(dataset, measured, own), asked)
    known = dict(zip(asked, shown, strict=True))
    found = {}
    for number in changes:
        pairs = [_scores(dataset, known[own], best, number, own) for own in best.claim.acts[number]]
        both = [pair for pair in pairs if pair is not None]
        if both:
            without, with_change = (sum(score.excess for score in some) for some in zip(*both, strict=True))
            found[number] = 1 - share(with_change, without)
    return found


def _scores(
    dataset: Dataset, measured: ModalData | None, best: ModalFit, number: int, recording: int
) -> tuple[ForecastScore, ForecastScore] | None:
    """Return how well a recording is forecast without a change, and with it."""
    if measured is None:
        return None
    both = (best.start.less(number), best.start)
    spaces = [spaces_of(dataset, measured, best, recording, start) for start in both]
    if not all(spaces):
        return None
    tested = kept_for_testing(dataset, [recording])
    without, with_change = (scored_by(own, measured, tested, state=0) for own in spaces)
    return without, with_change
