"""What the low-pass of recordings lets through: whether it cuts off sharply, and up to where motions show."""

import numpy as np
from scipy.signal import welch

from fe_models.arrays import FloatArray
from fe_models.lowpass import LowPass
from fe_models.recordings import Dataset

SHARP = 64  # steepness of a filter that cuts off: half at the cutoff, a five-hundredth at a tenth above it
NOTHING = 1e-6  # of the power below the cutoff: a Butterworth filter of order 4, run both ways, leaves 1e-4 and more
WHITE = 0.3  # of that power: a filter of order 4, run both ways, leaves 0.08 at most, and noise that came after it all
WITHIN, BEYOND = (0.75, 0.9), (1.12, 1.3)  # of the cutoff: where power is compared
QUIET = 0.2  # quantile of the power in a band: of what lies between the lines of motions
LONGEST = 512  # samples of a spectrum
LEAKS = 3  # lines of a spectrum with a Hann window: how far a wave shows beyond its own
PASSED = 0.2  # of a motion: what a low-pass leaves of it where motions end, unless recordings hold more than
FAINT = 1e-3  # of a channel's energy: less is there of noise that was low-passed, too, or is white and under 5 %
PARTS, CALM = 10, 3  # of a recording: in one may ring what a release has shaken, and in the last there is least motion
RINGING = 0.2  # of the noise in a part: releases of a mast leave 0.4 to 1.8 of it, most causes less than 0.1
LOUDER = 4  # times the usual part: noise alone, after the low-pass, differs by half of that


def lowpass_of(dataset: Dataset) -> LowPass | None:
    """Return the low-pass of a dataset's recordings, None where they have none.

    It cuts off sharply where recordings hold as good as nothing beyond it; else it is taken for the usual one.
    """
    if dataset.lowpass is None:
        return None
    sharp = _power_beyond(dataset, dataset.lowpass) < NOTHING
    return LowPass(dataset.lowpass, SHARP) if sharp else LowPass(dataset.lowpass)


def noise_is_lowpassed(dataset: Dataset) -> bool:
    """Return whether the noise, too, is as good as gone above the recordings' low-pass: it did not come after it."""
    half = dataset.sampling_rate / 2
    return (
        dataset.lowpass is not None and dataset.lowpass < half and not _power_beyond(dataset, dataset.lowpass) > WHITE
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
    if lowpass is None or lowpass.reach(PASSED) >= half or dataset.is_loaded:
        return half
    end = lowpass.reach(PASSED)
    fitted = (data[:, data.std(axis=0) > 0] for r in dataset.select("train") for data in r.data)
    fast = any(
        _share_above(data, dataset.sampling_rate, end) > FAINT
        or _rings_above(data, dataset.sampling_rate, lowpass.cutoff, end)
        for data in fitted
        if data.size
    )
    return half if fast else end


def _share_above(data: FloatArray, rate: float, lower: float) -> float:
    """Return the largest share of a channel's energy above ``lower`` (Hz), of ``data`` (time, sensor), noise apart."""
    frequency, power = welch(data, rate, nperseg=min(len(data), LONGEST), axis=0)
    above = frequency > lower + LEAKS * frequency[1]
    if not above.any():
        return 0.0
    lines = power[above] - np.median(power[above], axis=0)
    return float(np.max(lines.sum(axis=0) / power.sum(axis=0)))


def _rings_above(data: FloatArray, rate: float, cutoff: float, lower: float) -> bool:
    """Return whether some channel of ``data`` (time, sensor) has motion above ``lower`` (Hz) in one part of it only.

    In a moment it holds too little energy to be seen among that of the whole, and more than the noise then: what the
    last parts have where the low-pass still lets all through.
    """
    samples = len(data) // PARTS
    frequency = np.fft.rfftfreq(max(samples, 1), 1 / rate)
    passed, above = (frequency > cutoff / 2) & (frequency < WITHIN[1] * cutoff), frequency > lower
    if not (passed.any() and above.any()):
        return False
    parts = data[: samples * PARTS].reshape(PARTS, samples, -1)
    spectra = np.fft.rfft((parts - parts.mean(axis=1, keepdims=True)) * np.hanning(samples)[:, None], axis=1)
    power = np.abs(spectra) ** 2  # (part, frequency, sensor)
    fast = power[:, above].sum(axis=1)
    density = np.median(power[-CALM:, passed], axis=(0, 1)) / np.log(2)  # of a mean power the median is log 2
    noise = density * np.sum(frequency < cutoff)
    most, usual = fast.max(axis=0), np.median(fast, axis=0)
    return bool(np.any((most > LOUDER * usual) & (most - usual > RINGING * noise)))


def spectrum(data: FloatArray, rate: float) -> tuple[FloatArray, FloatArray]:
    """Return frequencies (Hz) and power (frequency, sensor) of ``data`` (time, sensor), each of the sensors that move
    over its own energy; not of those with a value that is not finite.
    """
    size = data.std(axis=0)
    alive = data[:, size > 0] / size[size > 0]
    return welch(alive, rate, nperseg=min(len(data), LONGEST), axis=0)


def beyond(data: FloatArray, rate: float, cutoff: float) -> float:
    """Return the power beyond a cutoff over that below it, of ``data`` (time, sensor); NaN where none is sampled."""
    frequency, power = spectrum(data, rate)
    bands = [(frequency > low * cutoff) & (frequency < high * cutoff) for low, high in (WITHIN, BEYOND)]
    if not (power.size and all(band.any() for band in bands)):
        return float("nan")
    below, beyond = (float(np.quantile(power[band], QUIET)) for band in bands)
    return beyond / below if below > 0 else float("nan")
