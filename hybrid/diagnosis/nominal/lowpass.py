"""What the low-pass of recordings lets through: whether it cuts off sharply, and up to where motions show."""

import numpy as np
from scipy.signal import welch

from fe_models.arrays import FloatArray
from fe_models.lowpass import LowPass
from fe_models.recordings import Dataset
from fe_models.spectra import line_frequencies, power_spectrum
from hybrid.diagnosis.nominal.config import LOWPASS
from hybrid.known_loads.config import POWER_BEYOND
from hybrid.known_loads.power_beyond import beyond


def lowpass_of(dataset: Dataset) -> LowPass | None:
    """Return the low-pass of a dataset's recordings, None where they have none.

    It cuts off sharply where recordings hold as good as nothing beyond it; else it is taken for the usual one.
    """
    if dataset.lowpass is None:
        return None
    sharp = _power_beyond(dataset, dataset.lowpass) < LOWPASS.max_power_of_sharp
    return LowPass(dataset.lowpass, LOWPASS.sharp_steepness) if sharp else LowPass(dataset.lowpass)


def noise_is_lowpassed(dataset: Dataset) -> bool:
    """Return whether the noise, too, is as good as gone above the recordings' low-pass: it did not come after it."""
    half = dataset.sampling_rate / 2
    return (
        dataset.lowpass is not None
        and dataset.lowpass < half
        and not _power_beyond(dataset, dataset.lowpass) > POWER_BEYOND.min_power_of_white
    )


def _power_beyond(dataset: Dataset, cutoff: float) -> float:
    """Return the power beyond a cutoff over that below it, median of the recordings; NaN where none is sampled."""
    shares = [beyond(data, dataset.sampling_rate, cutoff) for r in dataset.recordings for data in r.data]
    known = [share for share in shares if np.isfinite(share)]
    return float(np.median(known)) if known else float("nan")


def highest_shown(dataset: Dataset, lowpass: LowPass | None) -> float:
    """Return up to which frequency (Hz) recordings show motions: at most half their rate.

    A low-pass leaves little of what is faster than it, which is more than noise all the same where a stiff stop or
    spring sets high modes going, at a sensor that feels little else, where a release lets them ring for a moment, or
    where a load keeps them ringing.
    """
    half = dataset.sampling_rate / 2
    if lowpass is None or lowpass.reach(LOWPASS.passed_share) >= half or dataset.is_loaded:
        return half
    end = lowpass.reach(LOWPASS.passed_share)
    fitted = (data[:, data.std(axis=0) > 0] for r in dataset.select("train") for data in r.data)
    fast = any(
        _share_above(data, dataset.sampling_rate, end) > LOWPASS.min_energy_share
        or _rings_above(data, dataset.sampling_rate, lowpass.cutoff, end)
        for data in fitted
        if data.size
    )
    return half if fast else end


def _share_above(data: FloatArray, rate: float, lower: float) -> float:
    """Return the largest share of a channel's energy above ``lower`` (Hz), of ``data`` (time, sensor), noise apart."""
    frequency, power = welch(data, rate, nperseg=min(len(data), POWER_BEYOND.max_spectrum_samples), axis=0)
    above = frequency > lower + LOWPASS.leakage_lines * frequency[1]
    if not above.any():
        return 0.0
    lines = power[above] - np.median(power[above], axis=0)
    return float(np.max(lines.sum(axis=0) / power.sum(axis=0)))


def _rings_above(data: FloatArray, rate: float, cutoff: float, lower: float) -> bool:
    """Return whether some channel of ``data`` (time, sensor) has motion above ``lower`` (Hz) in one part of it only.

    In a moment it holds too little energy to be seen among that of the whole, and more than the noise then: what the
    last parts have where the low-pass still lets all through.
    """
    samples = len(data) // LOWPASS.parts
    frequency = line_frequencies(max(samples, 1), rate)
    passed, above = (frequency > cutoff / 2) & (frequency < POWER_BEYOND.band_within[1] * cutoff), frequency > lower
    if not (passed.any() and above.any()):
        return False
    parts = data[: samples * LOWPASS.parts].reshape(LOWPASS.parts, samples, -1)
    power = power_spectrum(parts - parts.mean(axis=1, keepdims=True))  # (part, frequency, sensor)
    fast = power[:, above].sum(axis=1)
    density = np.median(power[-LOWPASS.calm_parts :, passed], axis=(0, 1)) / np.log(2)  # median of power
    noise = density * np.sum(frequency < cutoff)
    most, usual = fast.max(axis=0), np.median(fast, axis=0)
    return bool(
        np.any((most > LOWPASS.min_loudness_ratio * usual) & (most - usual > LOWPASS.min_ringing_share * noise))
    )
