"""Recordings that end as behind a low-pass which the dataset does not state."""

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.recordings import Dataset
from hybrid.diagnosis.nominal.config import UNSTATED_LOWPASS
from hybrid.known_loads.config import POWER_BEYOND
from hybrid.known_loads.power_beyond import spectrum


def unstated_lowpass(dataset: Dataset) -> list[str]:
    """Return a note where recordings end far below half their rate, or below the low-pass that the dataset states.

    What a filter takes away of noise is then taken for a quiet sensor, and of motions for a fault of the model. What is
    driven ends above its highest resonance by itself, and says nothing.
    """
    rate = dataset.sampling_rate
    found = [_end(data, rate) for recording in dataset.recordings if not recording.is_driven for data in recording.data]
    ends = [end for end in found if end is not None]
    if 2 * len(ends) <= len(found):
        return []
    end, half = float(np.median(ends)), rate / 2
    if end > UNSTATED_LOWPASS.max_share_of_stated * min(dataset.lowpass or half, half):
        return []
    stated = "which the dataset does not state" if dataset.lowpass is None else f"not {dataset.lowpass:g} Hz as stated"
    return [f"the recordings end at about {end:.3g} Hz, as behind a low-pass, {stated}: set lowpass = {end:.3g}"]


def _end(data: FloatArray, rate: float) -> float | None:
    """Return where the spectra of ``data`` (time, sensor) fall steeply (Hz) and are level before; None if nowhere."""
    frequency, power = spectrum(data, rate)
    if not power.size:
        return None
    for cutoff in frequency[UNSTATED_LOWPASS.first_line :]:
        far, edge = (
            _quiet(frequency, power, band[0] * cutoff, band[1] * cutoff)
            for band in (UNSTATED_LOWPASS.band_far_beyond, POWER_BEYOND.band_within)
        )
        if far is None or edge is None or not np.all(far < UNSTATED_LOWPASS.max_power_ratio_beyond * edge):
            continue
        before = _quiet(
            frequency, power, frequency[UNSTATED_LOWPASS.first_line - 1], POWER_BEYOND.band_within[0] * cutoff
        )
        if before is None:
            continue
        level = (
            (edge > before / UNSTATED_LOWPASS.max_level_ratio)
            & (edge < UNSTATED_LOWPASS.max_level_ratio * before)
            & (edge * rate / 2 > UNSTATED_LOWPASS.min_noise_share)
        )
        if np.all(level) and _lasts(data, rate, cutoff):
            above = np.flatnonzero(np.median(power / edge, axis=1) > UNSTATED_LOWPASS.power_share_at_cutoff)
            return float(frequency[above[-1]])
    return None


def _quiet(frequency: FloatArray, power: FloatArray, lower: float, upper: float) -> FloatArray | None:
    """Return the power (sensor,) of what lies between the lines of motions in a band, None of too few lines."""
    inside = slice(np.searchsorted(frequency, lower, "right"), np.searchsorted(frequency, upper, "left"))
    if inside.stop - inside.start < UNSTATED_LOWPASS.min_lines:
        return None
    return np.asarray(np.quantile(power[inside], POWER_BEYOND.quiet_quantile, axis=0))


def _lasts(data: FloatArray, rate: float, cutoff: float) -> bool:
    """Return whether what is below a cutoff is as strong late in a recording as early, as noise is."""
    middle, levels = len(data) // 2, list[float]()
    for part in (data[:middle], data[middle:]):
        moving = part[:, part.std(axis=0) > 0]
        frequency, power = spectrum(moving, rate)
        level = _quiet(
            frequency,
            power * moving.var(axis=0),
            POWER_BEYOND.band_within[0] * cutoff,
            POWER_BEYOND.band_within[1] * cutoff,
        )
        if level is None:
            return False
        levels.append(float(np.median(level)))
    early, late = levels
    return early < UNSTATED_LOWPASS.max_decay_ratio * late
