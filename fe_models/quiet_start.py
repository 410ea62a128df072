"""How long nothing moves before a structure is let go or hit: what a trigger records before its event.

The scatter of each channel is taken in short blocks, so that a sensor's offset, or the deflection under a pull, does
not count. A free decay has its largest motion where it begins; what grows over several periods is none.
"""

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.spectra import power_spectrum

BLOCKS = 100  # of a recording, in each of which the scatter is taken
MIN_BLOCK = 8  # samples
CLEAR_SIGMA = 5.0  # of the scatter before it, by which a sensor has left its rest
QUIET = 0.15  # of the largest scatter: 10 % of noise and a little more
MIN_PERIODS = 1.0  # of the strongest vibration, that a quiet beginning lasts at least
MAX_RISE_PERIODS = 3.0  # of it, in which the motion has become largest


def quiet_start(motion: FloatArray) -> int:
    """Return how many samples of a ``motion`` (time, sensor) pass before it begins; 0 where it begins at once."""
    length = max(len(motion) // BLOCKS, MIN_BLOCK)
    count = len(motion) // length
    if count < 2 or not np.isfinite(motion).all():
        return 0
    scatter = motion[: count * length].reshape(count, length, -1).std(axis=1)  # (block, sensor)
    alive = scatter.max(axis=0) > 0
    if not alive.any():
        return 0
    power = np.sqrt(np.mean((scatter[:, alive] / scatter[:, alive].max(axis=0)) ** 2, axis=1))
    loud = np.flatnonzero(power > QUIET * power.max())
    begin, rise = int(loud[0]) * length, int(np.argmax(power) - loud[0]) * length
    moving = motion[begin:, alive]
    centred = (moving - moving.mean(axis=0)) / scatter[:, alive].max(axis=0)
    period = len(moving) / max(int(np.argmax(power_spectrum(centred).sum(axis=1))), 1)
    if begin < MIN_PERIODS * period or rise > MAX_RISE_PERIODS * period:
        return 0
    rest, last = motion[:begin, alive], motion[begin : begin + length, alive]
    left = np.abs(last - rest.mean(axis=0)) > CLEAR_SIGMA * rest.std(axis=0)
    return begin + int(np.argmax(left.any(axis=1)))


def quiet_words(lasts: float, unit: str = "s") -> str:
    """Return what to do about a beginning in which nothing moves, which ``lasts`` so long."""
    return (
        f"nothing moves in its first {lasts:.3g} {unit}: leave these out, as a free decay begins where the structure is"
        " let go or hit"
    )
