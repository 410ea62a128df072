"""Recordings that end as behind a low-pass which the dataset does not state."""

import numpy as np
from scipy.signal import welch

from fe_models.dofs import FloatArray
from fe_models.recordings import Dataset
from hybrid.diagnosis.nominal.lowpass import LONGEST, QUIET, WITHIN

FAR_BEYOND = (1.5, 1.8)  # of an end: where nothing is
LOWEST = 3  # line of a spectrum that has nothing of the mean, which is taken away
LEVEL, GONE = 10.0, 5e-3  # ratios of power: that near is level, and this little nothing; the usual filter leaves 2e-3
NOISELESS = 1e-7  # of a channel's energy: motions without noise fall as steeply
AT_CUTOFF = 0.25  # of the power: what the usual filter leaves at its cutoff
STATED = 0.75  # of the low-pass that is stated: an end below is another one
FEW = 4  # lines of a spectrum in a band that tell its level


def unstated_lowpass(dataset: Dataset) -> list[str]:
    """Return a note where recordings end far below half their rate, or below the low-pass that the dataset states.

    What a filter takes away of noise is then taken for a quiet sensor, and of motions for a fault of the model.
    """
    half, rate = dataset.sampling_rate / 2, dataset.sampling_rate
    found = [_end(data, rate) for recording in dataset.recordings for data in recording.data]
    ends = [end for end in found if end is not None]
    highest = min(dataset.lowpass or half, half)
    if 2 * len(ends) <= len(found) or float(np.median(ends)) > STATED * highest:
        return []
    stated = "which the dataset does not state" if dataset.lowpass is None else f"not {dataset.lowpass:g} Hz as stated"
    end = float(np.median(ends))
    return [f"the recordings end at about {end:.2g} Hz, as behind a low-pass, {stated}: set lowpass = {end:.2g}"]


def _end(data: FloatArray, rate: float) -> float | None:
    """Return where the spectra of ``data`` (time, sensor) fall steeply (Hz) and are level before; None if nowhere."""
    size = data.std(axis=0)
    alive = data[:, size > 0] / size[size > 0]
    if not alive.size or not np.isfinite(alive).all():
        return None
    frequency, power = welch(alive, rate, nperseg=min(len(data), LONGEST), axis=0)

    def quiet(lower: float, upper: float) -> FloatArray | None:
        inside = (frequency > lower) & (frequency < upper)
        return np.quantile(power[inside], QUIET, axis=0) if inside.sum() >= FEW else None

    for cutoff in frequency[LOWEST:]:
        far, edge = (quiet(band[0] * cutoff, band[1] * cutoff) for band in (FAR_BEYOND, WITHIN))
        before = quiet(frequency[LOWEST - 1], WITHIN[0] * cutoff)
        if far is None or before is None or edge is None:
            continue
        level = (edge > before / LEVEL) & (edge < LEVEL * before) & (edge * rate / 2 > NOISELESS)
        if np.all(level & (far < GONE * edge)):
            above = np.flatnonzero(np.median(power / edge, axis=1) > AT_CUTOFF)
            return float(frequency[above[-1]])
    return None
