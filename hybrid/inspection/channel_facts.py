"""What one channel of a recording shows by itself: its range, lost samples, and how its sensor may have failed."""

from dataclasses import dataclass

import numpy as np
from scipy.signal import find_peaks, welch

from fe_models.arrays import FloatArray
from hybrid.identification.clipped_channels import clipped_samples, run_lengths

MIN_STUCK = 32  # samples that do not change at all ...
MIN_STUCK_SHARE = 0.02  # ... and share of the recording, for a sensor that was stuck
DRIFT_BLOCKS = 10
MIN_DRIFT = 0.5  # of the standard deviation about it
MIN_DRIFT_CORRELATION = 0.95  # of the blocks' means with a straight line: chance exceeds it once in 10^4
SPECTRUM_SHARE = 8  # segments in a recording, of each of which a spectrum is taken
MAX_PEAKS = 3
MIN_PEAK = 10.0  # times the median of the spectrum
TINY = 1e-300


@dataclass(frozen=True)
class ChannelFacts:
    """``lost``: samples, in so many ``gaps``, the longest of ``longest_gap``; ``lowest``, ``highest``, ``mean`` and
    ``deviation`` (standard) in the channel's unit; ``clipped``: samples at the end of its range; ``stuck``: longest
    stretch without change, samples, 0 where it is short; ``drift``: what its mean moves by from begin to end, 0 where
    that is not clear; ``peaks``: frequencies of the strongest peaks of its spectrum, Hz, or 1/sample without a rate.
    """

    name: str
    unit: str
    samples: int
    lost: int
    gaps: int
    longest_gap: int
    lowest: float
    highest: float
    mean: float
    deviation: float
    clipped: int
    stuck: int
    drift: float
    peaks: tuple[float, ...]

    @property
    def is_dead(self) -> bool:
        """Whether the channel never changes, or has no sample at all."""
        return not self.deviation > 0


def channel_facts(name: str, unit: str, values: FloatArray, rate: float | None) -> ChannelFacts:
    """Return what a channel (sample,) shows; ``rate``: its sampling rate, Hz."""
    known = np.isfinite(values)
    lengths = run_lengths(~known)
    there = values[known]
    if not len(there):
        return ChannelFacts(
            name, unit, len(values), len(values), 1, len(values), np.nan, np.nan, np.nan, 0.0, 0, len(values), 0.0, ()
        )
    stuck = int(run_lengths(np.diff(there) == 0).max(initial=0)) + 1
    is_dead = stuck == len(there)
    stuck = stuck if stuck >= max(MIN_STUCK, MIN_STUCK_SHARE * len(there)) else 0
    return ChannelFacts(
        name,
        unit,
        len(values),
        int((~known).sum()),
        len(lengths),
        int(lengths.max(initial=0)),
        float(there.min()),
        float(there.max()),
        float(there.mean()),
        0.0 if is_dead else float(there.std()),
        0 if is_dead else clipped_samples(there),
        stuck,
        0.0 if is_dead else _drift(there),
        () if is_dead else strongest_peaks(*spectrum(values, rate)),
    )


def spectrum(values: FloatArray, rate: float | None) -> tuple[FloatArray, FloatArray]:
    """Return frequencies (line,) in Hz, or 1/sample without a ``rate``, and the power spectral density (line,).

    Of Welch's method; lost samples are zero about the mean.
    """
    there = np.nan_to_num(values - np.nanmean(values)) if np.isfinite(values).any() else np.zeros(len(values))
    segment = min(len(there), max(256, 2 ** int(np.log2(max(2 * len(there) / SPECTRUM_SHARE, 2)))))
    frequencies, power = welch(there, rate or 1.0, nperseg=segment, detrend="linear")
    return np.asarray(frequencies), np.asarray(power)


def strongest_peaks(frequencies: FloatArray, power: FloatArray) -> tuple[float, ...]:
    """Return the frequencies of the strongest peaks that stand out of a spectrum, from the lowest."""
    if len(power) < 3:
        return ()
    places, _ = find_peaks(np.log(np.maximum(power, TINY)), prominence=np.log(MIN_PEAK))
    places = places[power[places] > MIN_PEAK * np.median(power)]
    strongest = places[np.argsort(power[places])[::-1][:MAX_PEAKS]]
    return tuple(_between_lines(frequencies, power, int(place)) for place in np.sort(strongest))


def _between_lines(frequencies: FloatArray, power: FloatArray, place: int) -> float:
    """Return where the parabola through the logarithms of a peak's line and its neighbours is highest."""
    before, here, after = np.log(np.maximum(power[place - 1 : place + 2], TINY))
    beside = 0.5 * (before - after) / min(before - 2 * here + after, -TINY)
    return float(frequencies[place] + beside * (frequencies[1] - frequencies[0]))


def _drift(there: FloatArray) -> float:
    """Return what the mean moves by from the beginning to the end, 0 where blocks do not lie on a straight line."""
    if len(there) < 2 * DRIFT_BLOCKS:
        return 0.0
    means = np.array([block.mean() for block in np.array_split(there, DRIFT_BLOCKS)])
    place = (np.arange(DRIFT_BLOCKS) + 0.5) / DRIFT_BLOCKS - 0.5
    slope = float(place @ means / (place @ place))
    scatter = float(np.std(means))
    correlation = abs(slope) * float(np.std(place)) / scatter if scatter > 0 else 0.0
    rest = float(np.std(there - slope * (np.arange(len(there)) / len(there) - 0.5)))
    return slope if correlation > MIN_DRIFT_CORRELATION and abs(slope) > MIN_DRIFT * rest else 0.0
