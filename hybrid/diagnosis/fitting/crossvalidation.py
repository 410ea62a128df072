"""Forecasts without test recordings: of each recording by what was fitted to the others, and to its first fifth."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.files.recording_checks import MIN_SAMPLES
from fe_models.recordings import Dataset, Recording, Sensor
from hybrid.diagnosis.fitting.config import FORECAST
from hybrid.diagnosis.fitting.forecast_score import ForecastModel, ForecastScore, forecast, joined, shown_of
from hybrid.diagnosis.fitting.least_squares import Fit, fit
from hybrid.diagnosis.recorded.batches import Batch, batches_of
from hybrid.diagnosis.recorded.noise_model import NoiseModel, SensorRoles


@dataclass(frozen=True)
class Folds:
    """``tests``: of each fold the batches (recording, time, sensor) that are forecast, of all ``sensors``.

    ``measured``: columns of those that are fitted; ``searched``: with what counts as noise in a fit.
    """

    tests: tuple[tuple[Batch, ...], ...]
    sensors: tuple[Sensor, ...]
    measured: tuple[int, ...]
    searched: NoiseModel

    def forecast(self, models: Sequence[ForecastModel], noise_model: NoiseModel) -> ForecastScore:
        """Return the scores of all recordings, those of each fold by its own of the ``models`` (fold,)."""
        roles = SensorRoles(self.sensors, self.measured, noise_model)
        return joined([forecast(model, tests, roles) for model, tests in zip(models, self.tests, strict=True)])

    def unseeing(self, item: Fit) -> tuple[Fit, ...]:
        """Return the fits of what a fit is of, each without the recordings of one fold but for their first fifth."""
        own = list(self.measured)
        left_out = [[data[..., own] for batch in tests for data in batch.data] for tests in self.tests]
        return tuple(_without(item, recordings, self.searched) for recordings in left_out)


def as_recordings(dataset: Dataset) -> tuple[Dataset, list[str]]:
    """Return a dataset without test recordings ready to be cross-validated, and a note that says so.

    Several motions in one file become recordings of their own; a single one is cut into two, where it is long enough.
    Copies of one count once: else what is forecast would have been fitted.
    """
    if dataset.select("test"):
        return dataset, []
    single: list[Recording] = [replace(r, data=part[None]) for r in dataset.recordings for part in r.data]
    once = [r for i, r in enumerate(single) if not any(np.array_equal(r.data, other.data) for other in single[:i])]
    copies, single = len(single) - len(once), once
    twice = [f"{copies} of the recordings are copies of others and left out"] * bool(copies)
    note = "no recording is for testing: each is forecast by a fit to the others and its own first fifth"
    if len(single) == 1:
        (only,) = single
        half = only.data.shape[1] // 2
        if half < MIN_SAMPLES:
            note = "one short recording and none for testing: the forecasts are scored on what was fitted"
            return replace(dataset, recordings=(only, replace(only, role="test"))), [*twice, note]
        single = [only.part(begin, begin + half, dataset.load_course) for begin in (0, half)]
        note = "one recording and none for testing: each half is forecast by a fit to the other and its own first fifth"
    return replace(dataset, recordings=tuple(single)), [*twice, note]


def folds_of(dataset: Dataset, measured: tuple[int, ...], searched: NoiseModel) -> Folds | None:
    """Return how the training recordings are left out one after the other, None where there are test recordings.

    ``searched``: with what counts as noise in a fit.
    """
    recordings = dataset.select("train")
    if dataset.select("test"):
        return None
    count = min(FORECAST.max_folds, len(recordings))
    tests = [batches_of(dataset, "train", recordings[number::count]) for number in range(count)]
    return Folds(tuple(tests), dataset.sensors, measured, searched)


def _without(item: Fit, left_out: list[FloatArray], noise_model: NoiseModel) -> Fit:
    """Return the fit to the recordings that are not ``left_out`` (time, sensor), and to the first fifth of those, from
    which forecasts go on: it may tell of a cause what no other recording does.
    """
    batches, states = [], []
    for batch, own in zip(item.batches, item.states, strict=True):
        is_left = np.array([any(np.array_equal(data, one) for one in left_out) for data in batch.recorded])
        for chosen, part in ((~is_left, batch), (is_left, batch.first(shown_of(batch.samples)))):
            if chosen.any():
                batches.append(part.take(np.flatnonzero(chosen).tolist()))
                states.append(own[chosen])
    fewer = fit(item.hypothesis, item.theta, tuple(batches), noise_model, tuple(states), FORECAST.fold_iterations)
    assert fewer is not None  # it begins with motions that have been followed
    return fewer
