"""Spectra of channels: X_k = sum over samples n of w_n x_n exp(-2 pi i k n / N), with a window w."""

import numpy as np

from fe_models.arrays import ComplexArray, FloatArray


def line_frequencies(samples: int, rate: float) -> FloatArray:
    """Return the frequencies (line,) in Hz of a spectrum of so many ``samples`` at a sampling ``rate`` (Hz)."""
    return np.asarray(np.fft.rfftfreq(samples, 1 / rate))


def windowed_spectrum(channels: FloatArray, window: FloatArray | None = None) -> ComplexArray:
    """Return X (..., line, sensor) of ``channels`` (..., time, sensor); ``window`` (time,), without one Hann's.

    Hann's lets a decay that the recording cuts off leak into its neighbours alone.
    """
    weights = np.hanning(channels.shape[-2]) if window is None else window
    return np.asarray(np.fft.rfft(channels * weights[:, None], axis=-2))


def power_spectrum(channels: FloatArray, window: FloatArray | None = None) -> FloatArray:
    """Return |X|^2 (..., line, sensor), as `windowed_spectrum`; of white noise its variance times the sum of w^2."""
    return np.asarray(np.abs(windowed_spectrum(channels, window)) ** 2)
