"""Forecasts of the test recordings by the hybrid and the FE model, side by side, and their scores."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.linear import ModalModel
from fe_models.nominal import nominal_modes
from fe_models.recordings import Dataset, Recording, Sensor
from fe_models.structure import TRANSLATIONS
from hybrid.estimation.config import UNCERTAINTY
from hybrid.estimation.experts import Hybrid, fe_counterpart
from hybrid.estimation.forecast import Forecast, forecast_windows, solves_for_states
from hybrid.estimation.uncertainty import BandedForecast, banded_forecast, coverage, noise_std
from hybrid.estimation.windows import cut_all, cut_driving
from hybrid.known_loads.modal_input import modal_input
from hybrid.neural_modal_ode.driving import Driving
from hybrid.training.gradient_training import TrainingDivergedError


@dataclass(frozen=True)
class Comparison:
    """Test windows (window, time, sensor) and what the FE and the hybrid model forecast of them.

    ``whole_record``: the hybrid's motion given all samples of the windows; None where the model encodes its states.
    ``driving``: what is known to drive the windows, None of free motions.
    """

    windows: FloatArray
    fe: Forecast
    hybrid: BandedForecast
    whole_record: BandedForecast | None = None
    driving: Driving | None = None

    @property
    def by_name(self) -> dict[str, Forecast]:
        """The forecasts as they are named in ``metrics.json``."""
        found = {"fe": self.fe, "hybrid": self.hybrid.forecast}
        return found if self.whole_record is None else {**found, "whole_record": self.whole_record.forecast}


def forecast_recordings(dataset: Dataset) -> tuple[Recording, ...]:
    """Return the test recordings that can be forecast: all but those of unknown forces."""
    return tuple(recording for recording in dataset.select("test") if recording.excitation != "ambient")


def compare(model: Hybrid, dataset: Dataset, length: int, stride: int) -> Comparison | None:
    """Forecast the test recordings, None where there are none; `TrainingDivergedError` where numbers overflow."""
    recordings = forecast_recordings(dataset)
    if not recordings:
        return None
    windows = cut_all(recordings, length, stride)
    driving = None
    if any(recording.is_driven for recording in recordings):
        forces = modal_input(dataset, nominal_modes(dataset, model.config.modes), recordings)
        driving = cut_driving(forces, recordings, length, stride)
    fe = forecast_windows(model, windows, dynamics=fe_counterpart(model), driving=driving)
    hybrid = banded_forecast(model, windows, driving=driving)
    if not np.isfinite(hybrid.forecast.channels).all():
        raise TrainingDivergedError(
            "The trained model's forecasts of the test recordings grow beyond all bounds."
            " Train again with --fresh and a smaller --learning-rate, or more --epochs."
        )
    solves = solves_for_states(model)
    whole = banded_forecast(model, windows, whole=True, driving=driving) if solves else None
    return Comparison(windows, fe, hybrid, whole, driving)


def band_scores(model: Hybrid, comparison: Comparison, sensors: tuple[Sensor, ...]) -> dict[str, Any]:
    """Return how often the channels lie inside the bands that should hold 90 % of them, sensors' noise included."""
    noise = noise_std(model, sensors)
    scores: dict[str, Any] = {"level": UNCERTAINTY.level, "relative_error": float(model.relative_error)}
    for name, banded in (("hybrid", comparison.hybrid), ("whole_record", comparison.whole_record)):
        if banded is not None:
            inside = coverage(comparison.windows - banded.forecast.channels, np.hypot(banded.std, noise))
            scores[name] = {
                role: float(np.mean([inside[i] for i, sensor in enumerate(sensors) if sensor.role == role]))
                for role in sorted({sensor.role for sensor in sensors})
            }
    return scores


def field_scores(comparison: Comparison, modal: ModalModel, truth: FloatArray) -> dict[str, float]:
    """Return each model's error of the displacement field, relative to the field's size.

    RMS over all translations, times and windows of the error, over that of the truth (window, time, dof): the truth of
    the first windows compared.
    """
    rows = np.isin(modal.dofs.direction, TRANSLATIONS)
    known = truth[:, :, rows]
    size = np.sqrt(np.mean(known**2))
    coordinates = {"fe": comparison.fe.q, "hybrid": comparison.hybrid.forecast.q}
    return {
        name: float(np.sqrt(np.mean((q[: len(truth)] @ modal.shapes[rows].T - known) ** 2)) / size)
        for name, q in coordinates.items()
    }
