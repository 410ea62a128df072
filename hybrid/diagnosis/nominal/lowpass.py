"""Whether the low-pass of recordings cuts off sharply: told by what is left beyond it, noise and all."""

import numpy as np
from scipy.signal import welch

from fe_models.dofs import FloatArray
from fe_models.lowpass import LowPass
from fe_models.recordings import Dataset

SHARP = 64  # steepness of a filter that cuts off: half at the cutoff, a five-hundredth at a tenth above it
NOTHING = 1e-6  # of the power below the cutoff: a Butterworth filter of order 4, run both ways, leaves 1e-4 and more
WITHIN, BEYOND = (0.75, 0.9), (1.12, 1.3)  # of the cutoff: where power is compared
QUIET = 0.2  # quantile of the power in a band: of what lies between the lines of motions
LONGEST = 512  # samples of a spectrum


def lowpass_of(dataset: Dataset) -> LowPass | None:
    """Return the low-pass of a dataset's recordings, None where they have none.

    It cuts off sharply where recordings hold as good as nothing beyond it; else it is taken for the usual one.
    """
    if dataset.lowpass is None:
        return None
    shares = [_beyond(data, dataset.sampling_rate, dataset.lowpass) for r in dataset.recordings for data in r.data]
    known = [share for share in shares if np.isfinite(share)]
    sharp = bool(known) and float(np.median(known)) < NOTHING
    return LowPass(dataset.lowpass, SHARP) if sharp else LowPass(dataset.lowpass)


def _beyond(data: FloatArray, rate: float, cutoff: float) -> float:
    """Return the power beyond a cutoff over that below it, of ``data`` (time, sensor); NaN where none is sampled."""
    size = data.std(axis=0)
    alive = data[:, size > 0] / size[size > 0]
    if not alive.size or not np.isfinite(alive).all():
        return float("nan")
    frequency, power = welch(alive, rate, nperseg=min(len(data), LONGEST), axis=0)
    bands = [(frequency > low * cutoff) & (frequency < high * cutoff) for low, high in (WITHIN, BEYOND)]
    if not all(band.any() for band in bands):
        return float("nan")
    below, beyond = (float(np.quantile(power[band], QUIET)) for band in bands)
    return beyond / below if below > 0 else float("nan")
