"""Scores of a forecast against a recording: NRMSE and R2 about the mean, a window and a channel at a time."""

import numpy as np

from fe_models.arrays import FloatArray


def nrmse(prediction: FloatArray, measured: FloatArray) -> FloatArray:
    """Return RMSE / (max - min) of each window and channel, (window, sensor); arguments (window, time, sensor)."""
    return np.sqrt(np.mean((prediction - measured) ** 2, axis=1)) / np.ptp(measured, axis=1)


def r2(prediction: FloatArray, measured: FloatArray) -> FloatArray:
    """Return 1 - SSE / SST about the window's mean, (window, sensor); 1 is perfect, 0 no better than the mean."""
    error = np.sum((prediction - measured) ** 2, axis=1)
    return 1 - error / np.sum((measured - measured.mean(axis=1, keepdims=True)) ** 2, axis=1)
