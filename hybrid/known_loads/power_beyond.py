"""How much power recordings, or loads, hold beyond the cutoff of a low-pass."""

import numpy as np
from scipy.signal import welch

from fe_models.arrays import FloatArray
from hybrid.known_loads.config import POWER_BEYOND


def spectrum(data: FloatArray, rate: float) -> tuple[FloatArray, FloatArray]:
    """Return frequencies (Hz) and power (frequency, sensor) of ``data`` (time, sensor), each of the sensors that move
    over its own energy; not of those with a value that is not finite.
    """
    size = data.std(axis=0)
    alive = data[:, size > 0] / size[size > 0]
    return welch(alive, rate, nperseg=min(len(data), POWER_BEYOND.max_spectrum_samples), axis=0)


def beyond(data: FloatArray, rate: float, cutoff: float) -> float:
    """Return the power beyond a cutoff over that below it, of ``data`` (time, sensor); NaN where none is sampled."""
    frequency, power = spectrum(data, rate)
    bands = [
        (frequency > low * cutoff) & (frequency < high * cutoff)
        for low, high in (POWER_BEYOND.band_within, POWER_BEYOND.band_beyond)
    ]
    if not (power.size and all(band.any() for band in bands)):
        return float("nan")
    below, beyond = (float(np.quantile(power[band], POWER_BEYOND.quiet_quantile)) for band in bands)
    return beyond / below if below > 0 else float("nan")
