"""The scores of a trained model on the test recordings, as they go into ``metrics.json``."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.recordings import Sensor
from hybrid.training.scoring import nrmse, r2

FIRST_WINDOWS = 16  # the windows that Lai et al. 2022 score on the bridge


def score_table(forecasts: dict[str, FloatArray], measured: FloatArray, sensors: Sequence[Sensor]) -> dict[str, Any]:
    """Return NRMSE and R2 of each forecast (window, time, sensor) against ``measured``.

    For each forecast: averages over measured and held-out channels apart (None where there are none), over all windows
    and over the first 16 (of overlapping windows the ones with the largest motion); the worst window; each channel.
    """
    return {name: _scores(forecast, measured, sensors) for name, forecast in forecasts.items()}


def _scores(forecast: FloatArray, measured: FloatArray, sensors: Sequence[Sensor]) -> dict[str, Any]:
    errors, fits = nrmse(forecast, measured), r2(forecast, measured)  # (window, sensor) each
    table: dict[str, Any] = {}
    for role in ("measured", "held_out"):
        columns = [i for i, sensor in enumerate(sensors) if sensor.role == role]
        table[role] = _averages(errors[:, columns], fits[:, columns]) if columns else None
    table["channels"] = {
        sensor.name: {"role": sensor.role, **_averages(errors[:, [i]], fits[:, [i]])}
        for i, sensor in enumerate(sensors)
    }
    return table


def _averages(errors: FloatArray, fits: FloatArray) -> dict[str, float]:
    by_window = errors.mean(axis=1)
    worst = int(np.argmax(by_window))
    return {
        "nrmse": float(errors.mean()),
        "r2": float(fits.mean()),
        "nrmse_first_16_windows": float(errors[:FIRST_WINDOWS].mean()),
        "r2_first_16_windows": float(fits[:FIRST_WINDOWS].mean()),
        "nrmse_worst_window": float(by_window[worst]),
        "worst_window": worst + 1,
    }
