"""Forecasts of the recordings that were kept for testing, or left out one fold after the other, by any fit."""

from dataclasses import dataclass, field, replace

import numpy as np

from fe_models.arrays import FloatArray
from hybrid.diagnosis.contest.evidence import Evidence
from hybrid.diagnosis.contest.setting import Setting
from hybrid.diagnosis.fitting.calibration_deviation import within
from hybrid.diagnosis.fitting.crossvalidation import Folds, folds_of
from hybrid.diagnosis.fitting.forecast_score import (
    ForecastModel,
    ForecastScore,
    forecast,
    idle_by_order,
    is_bent,
    model_of,
    switched_in,
)
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.outcome.config import VERDICT
from hybrid.diagnosis.recorded.batches import Batch
from hybrid.diagnosis.recorded.noise_model import NoiseModel, SensorRoles
from hybrid.diagnosis.response.hypothesis import Hypothesis


@dataclass(frozen=True)
class Scorer:
    """``test``: batches with all sensors; ``folds``: where there are none, the training recordings in turn.

    ``known``: forecasts that were made, by their fit and where nominal values are, or how far they may go;
    ``unseeing``: fits without each fold's recordings. One beside force laws takes seconds.
    """

    setting: Setting
    noise_model: NoiseModel
    test: tuple[Batch, ...]
    folds: Folds | None
    known: dict[tuple[Fit, float | bytes], ForecastScore] = field(init=False, repr=False, default_factory=dict)
    unseeing: dict[Fit, tuple[Fit, ...]] = field(init=False, repr=False, default_factory=dict)

    @classmethod
    def of(cls, setting: Setting, evidence: Evidence) -> "Scorer":
        """Return the scorer of a dataset, its noise as the evidence has it."""
        dataset = setting.dataset
        folds = folds_of(dataset, setting.measured, evidence.searched)
        if folds is not None:
            folds = replace(folds, tests=tuple(setting.with_noise(tests) for tests in folds.tests))
        return cls(setting, evidence.noise_model, setting.test_recordings(), folds)

    @property
    def roles(self) -> SensorRoles:
        """What the test recordings show."""
        return SensorRoles(self.setting.dataset.sensors, self.setting.measured, self.noise_model)

    def forecast(self, item: Fit, most: float = np.inf) -> ForecastScore:
        """Return the scores of a fit, nominal values calibrated by no more than ``most`` standard deviations."""
        key = item, most if self.folds is not None else within(item, most).tobytes()
        if key not in self.known:
            self.known[key] = self._forecast(item, most)
        return self.known[key]

    def _forecast(self, item: Fit, most: float) -> ForecastScore:
        if self.folds is None:
            return forecast(self.model(item, within(item, most)), self.test, self.roles)
        models = [self._model_of_others(item, one, within(one, most)) for one in self._unseeing(item)]
        return self.folds.forecast(models, self.noise_model)

    def _unseeing(self, item: Fit) -> tuple[Fit, ...]:
        """Return the fits without the recordings of each fold."""
        assert self.folds is not None
        if item not in self.unseeing:
            self.unseeing[item] = self.folds.unseeing(item)
        return self.unseeing[item]

    def _model_of_others(self, item: Fit, one: Fit, theta: FloatArray | None) -> ForecastModel:
        """Return the model of ``one`` fit without some recordings of those of a fit.

        What acts in some recordings only may act in none or all of the others; it is still asked whether it does.
        """
        return replace(self.model(one, theta), switched=switched_in(item))

    def model(self, item: Fit, theta: FloatArray | None = None) -> ForecastModel:
        """Return a fit's model, at its own theta or at another; where causes act follows the order of recordings."""
        order = [recording.name for recording in self.setting.dataset.recordings]
        return replace(model_of(item, self.noise_model, theta), idle=idle_by_order(item, order), bent=self._bent(item))

    def _bent(self, item: Fit) -> tuple[Hypothesis, ...]:
        """Return a fit's hypothesis with what geometry may add, where the recordings for training do not show it.

        Where there are no others, all have been for training.
        """
        nominal = item.hypothesis.nominal
        if self.folds is not None or nominal.geometry is not None:
            return ()
        models = (replace(nominal, geometry=geometry) for geometry in self.setting.geometries)
        return tuple(replace(item.hypothesis, nominal=own) for own in models)

    def error(self, found: ForecastScore) -> float:
        """Return the NRMSE, mean over the measured channels."""
        return float(found.nrmse[:, list(self.setting.measured)].mean())

    def held_out_error(self, found: ForecastScore) -> float | None:
        """Return the NRMSE of the sensors that were held out, None where there are none."""
        apart = [i for i, sensor in enumerate(self.setting.dataset.sensors) if sensor.role == "held_out"]
        return float(found.nrmse[:, apart].mean()) if apart else None

    def floor(self, found: ForecastScore) -> float:
        """Return the NRMSE that noise alone makes, mean over the measured channels."""
        return float(found.floor[:, list(self.setting.measured)].mean())

    def bent_in(self, item: Fit) -> tuple[str, ...]:
        """Return the names of the test recordings that show what geometry adds, where those for training do not."""
        model = self.model(item)
        if not model.bent:
            return ()
        found = dict.fromkeys(
            name
            for batch in self.test
            for name, is_so in zip(batch.names, is_bent(model, batch, self.roles), strict=True)
            if is_so
        )
        return tuple(found)

    def wrong_in(self, found: ForecastScore) -> tuple[str, ...]:
        """Return the names of the recordings kept for testing that are forecast worse than is near the noise floor."""
        if self.folds is not None:
            return ()
        names = [name for batch in self.test for name in batch.names]
        error, floor = (of[:, list(self.setting.measured)].mean(axis=1) for of in (found.nrmse, found.floor))
        return tuple(
            dict.fromkeys(
                name for name, wrong in zip(names, error > VERDICT.max_near_ratio * floor, strict=True) if wrong
            )
        )

    def example_model(self, item: Fit, theta: FloatArray | None = None) -> ForecastModel:
        """Return the `model` by which the recording that is `shown` is forecast: of a fit that did not see it."""
        if self.folds is None:
            return self.model(item, theta)
        return self._model_of_others(item, self._unseeing(item)[0], theta)

    @property
    def shown(self) -> Batch:
        """The batch whose first recording is forecast as an example."""
        return (self.test if self.folds is None else self.folds.tests[0])[0]
