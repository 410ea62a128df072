"""What moved the structure, where nobody says: whether a recording dies away, as a free decay does.

In a free decay the power of a mode falls as exp(-2 d t), d the decay rate by which its correlations fall, too. Under
forces that go on, or come again, correlations fall alike, and the power does not. So the fall of each mode's power from
the first third of a recording to the last, log P_1 / P_3, is held against the 2 d (2 T / 3) of a decay of length T.
What starts again has died away to a small part, and is large again within a few periods; two modes that beat take more.
"""

from collections.abc import Sequence
from enum import Enum

import numpy as np

from fe_models.arrays import FloatArray, IntArray
from fe_models.spectra import power_spectrum
from hybrid.identification.ambient_modes import identify_ambient_modes
from hybrid.identification.config import EXCITATION
from hybrid.identification.identified_modes import IdentifiedModes
from hybrid.identification.narrow_band import amplitude_of


class Course(Enum):
    """How a recording goes on."""

    DIES_AWAY = "dies away, as a free decay does"
    GOES_ON = "does not die away, so something drives it"
    STARTS_AGAIN = "starts again after it has died away, so something drives it"
    UNTOLD = "is too short to tell whether it dies away, or shows no mode"

    @property
    def may_be_free(self) -> bool:
        """Whether nothing contradicts a free decay, which users state by stating nothing."""
        return self in (Course.DIES_AWAY, Course.UNTOLD)


def course_of(
    motions: Sequence[FloatArray], rate: float, first: float, highest: float, orders: IntArray | None = None
) -> Course:
    """Return how ``motions`` (time, sensor), sampled at ``rate`` Hz, go on.

    ``first`` and ``highest``: the structure's lowest natural frequency, and up to where recordings go, Hz.
    ``orders`` (sensor,): of the derivatives of displacements that sensors show; left out, all show one quantity.
    """
    parts = [np.asarray(part, dtype=float) - np.mean(part, axis=0) for part in motions]
    scale = np.sqrt(np.mean(np.concatenate(parts) ** 2, axis=0))
    parts = [part / np.where(scale > 0, scale, 1.0) for part in parts]
    if any(_starts_again(part) for part in parts):
        return Course.STARTS_AGAIN
    if _fall(parts) > EXCITATION.largest_fall * EXCITATION.most_decay:
        return Course.DIES_AWAY  # without any work
    return _course_of_modes(parts, rate, first, highest, orders)


def _starts_again(part: FloatArray) -> bool:
    """Return whether the power of a motion (time, sensor) has fallen, and comes back from one span to the next."""
    span = round(EXCITATION.span_periods * len(part) / strongest_line(part))
    if len(part) < EXCITATION.min_spans * span:
        return False
    total = np.concatenate([[0.0], np.cumsum(np.sum(part**2, axis=1))])
    course = (total[span:] - total[:-span])[:: max(span // EXCITATION.span_steps, 1)]
    step = -(-span // max(span // EXCITATION.span_steps, 1))  # from a span to the next without a sample in common
    low, high, most = course[:-step], course[step:], np.maximum.accumulate(course)[:-step]
    down = low < np.exp(-EXCITATION.least_decay) * most
    up = (high > np.exp(EXCITATION.least_decay) * low) & (high > EXCITATION.min_return * most)
    return bool(np.any(down & up))


def strongest_line(part: FloatArray) -> int:
    """Return the number of cycles in a motion (time, sensor) of its strongest vibration, at least one."""
    return max(int(np.argmax(power_spectrum(part).sum(axis=1))), 1)


def _course_of_modes(
    motions: Sequence[FloatArray], rate: float, first: float, highest: float, orders: IntArray | None
) -> Course:
    """Return whether the power of the modes falls far less than free decays would let it."""
    modes = identify_ambient_modes(motions, rate, first, highest, orders, np.ones(motions[0].shape[1])).modes
    expected = -2 * modes.roots.real * float(np.mean([len(part) for part in motions])) / rate * 2 / 3
    tested = np.flatnonzero(expected > EXCITATION.least_decay)
    energy = modes.energy[tested]
    if energy.sum() <= EXCITATION.min_energy_share * modes.energy.sum():
        return Course.UNTOLD
    found = np.array([_fall(_of_mode(motions, rate, modes, int(mode))) for mode in tested])
    most = EXCITATION.largest_fall * float(np.minimum(expected[tested], EXCITATION.most_decay) @ energy)
    goes_on = found @ energy < most and _fall(motions) * energy.sum() < most
    return Course.GOES_ON if goes_on else Course.DIES_AWAY


def _of_mode(motions: Sequence[FloatArray], rate: float, modes: IdentifiedModes, mode: int) -> list[FloatArray]:
    """Return how large one mode is, (time, sensor) of each motion, where its shape is large."""
    decay, shape = -modes.roots[mode].real, np.abs(modes.shapes[:, mode])
    found = []
    for part in motions:
        width = max(EXCITATION.band_decays * decay / np.pi, EXCITATION.band_lines * rate / len(part))
        found.append(np.abs(amplitude_of(part, rate, float(modes.frequencies[mode]), width)) * shape)
    return found


def _fall(motions: Sequence[FloatArray]) -> float:
    """Return the logarithm of the power (time, sensor) of the first third over that of the last."""
    first = float(np.mean([np.mean(part[: max(len(part) // 3, 1)] ** 2) for part in motions]))
    last = float(np.mean([np.mean(part[-max(len(part) // 3, 1) :] ** 2) for part in motions]))
    tiny = np.finfo(float).tiny
    return float(np.log(max(first, tiny) / max(last, tiny)))
