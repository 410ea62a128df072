"""A load behind the low-pass of the recordings, which it may have passed, or not."""

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.measurement import lowpassed
from fe_models.spectra import line_frequencies, power_spectrum
from hybrid.known_loads.config import BEHIND_LOWPASS, POWER_BEYOND
from hybrid.known_loads.power_beyond import beyond


def behind(values: FloatArray, rate: float, lowpass: float | None) -> FloatArray:
    """Return a load's ``values`` (time,) behind the ``lowpass`` (Hz) of the recordings, which it may have passed."""
    if lowpass is None:
        return values
    power = np.abs(np.fft.rfft(values)) ** 2
    above = np.fft.rfftfreq(len(values), 1 / rate) > lowpass
    passes_by = (
        power[above].sum() > BEHIND_LOWPASS.max_share_above_lowpass * power.sum()
        or beyond(values[:, None], rate, lowpass) > POWER_BEYOND.min_power_of_white
        or _fall(values, rate, lowpass) > BEHIND_LOWPASS.max_density_ratio_beyond
    )
    return lowpassed(values, rate, lowpass) if passes_by else values


def _fall(values: FloatArray, rate: float, lowpass: float) -> float:
    """Return the mean power of a load's ``values`` (time,) in a band beyond a low-pass over that in one below it.

    Mean, as the spectrum of a knock has zeros, which a quantile takes for what a filter left.
    """
    power = power_spectrum(values[:, None] - values.mean())[:, 0]
    frequency = line_frequencies(len(values), rate)
    bands = [(frequency > low * lowpass) & (frequency < high * lowpass) for low, high in BEHIND_LOWPASS.bands]
    if not all(band.any() for band in bands):
        return 0.0
    below, above = (float(power[band].mean()) for band in bands)
    return above / below if below > 0 else 0.0
