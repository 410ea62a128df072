"""What a recording looks as if it had been moved by: a guess, for a user to confirm.

By names and units of its channels; else by its course (`identification.excitation`), and, where that cannot be told
from the modes that it shows, by its power.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.files.unit_words import known_unit
from hybrid.identification.excitation import Course, course_of, strongest_line

BLOCKS = 40  # of a recording, in each of which its power is taken
MIN_BLOCKS = 8  # of which there are fewer in recordings too short to tell anything
QUIET = 0.1  # of the largest RMS
STEADY = 0.5  # largest coefficient of variation of the blocks' RMS, of what goes on alike
RISE_BLOCKS = 2  # in which a decay that begins late has reached its largest RMS; an earthquake takes longer
MAX_KURTOSIS_OF_SINES = 2.0  # of a sine 1.5, of two 2.25, of what many forces drive 3
FORCE_WORDS = re.compile(r"force|hammer|shaker|load|kraft", re.IGNORECASE)
BASE_WORDS = re.compile(r"base|ground|table|boden|quake", re.IGNORECASE)


class Moved(Enum):
    """What a recording looks like."""

    FREE = "a free decay"
    DECAYS = "several free decays, one behind the other"
    MEASURED = "moved by a force that was measured"
    BASE = "moved at its base, in a way that was measured"
    EARTHQUAKE = "an earthquake: it rises, shakes and dies away"
    AMBIENT = "ambient vibration: it goes on alike, as under wind and traffic"
    STEADY = "one steady vibration: a free decay with hardly any damping, or a machine"
    UNCLEAR = "neither a decay nor steady"


@dataclass(frozen=True)
class Guess:
    """What a recording looks like, and the ``channels`` (by number) that hold the force or the motion of the base."""

    moved: Moved
    channels: tuple[int, ...] = ()


def likely_excitation(names: Sequence[str], units: Sequence[str], values: FloatArray) -> Guess:
    """Return a guess for channels of these ``names`` and ``units``, (sample, channel)."""
    forces = tuple(i for i, (name, unit) in enumerate(zip(names, units, strict=True)) if _is_force(name, unit))
    if forces and len(forces) < len(names):
        return Guess(Moved.MEASURED, forces)
    base = tuple(i for i, name in enumerate(names) if BASE_WORDS.search(name))
    if base and len(base) < len(names):
        return Guess(Moved.BASE, base)
    moved = _by_course(values)
    return Guess(Moved.STEADY if moved is Moved.AMBIENT and _kurtosis(values) < MAX_KURTOSIS_OF_SINES else moved)


def course_of_power(values: FloatArray) -> FloatArray:
    """Return the RMS of all channels together in each block (block,), every channel over its own standard deviation."""
    centred = np.nan_to_num(_centred(values))
    if not centred.size:
        return np.zeros(1)
    spread = centred.std(axis=0)
    alive = centred[:, spread > 0] / spread[spread > 0]
    blocks = np.array_split(alive, min(BLOCKS, max(len(alive) // 8, 1)))
    return np.array([np.sqrt(np.mean(block**2)) if block.size else 0.0 for block in blocks])


def _kurtosis(values: FloatArray) -> float:
    """Return the mean kurtosis of the channels: 3 of normal distributed values, 1.5 of a sine."""
    centred = _centred(values)
    if not centred.size:
        return 0.0
    variance = np.nanmean(centred**2, axis=0)
    alive = variance > 0
    return float(np.mean(np.nanmean(centred[:, alive] ** 4, axis=0) / variance[alive] ** 2)) if alive.any() else 0.0


def _centred(values: FloatArray) -> FloatArray:
    """Return the channels that have any sample, each less its mean; lost samples (NaN) stay."""
    alive = values[:, ~np.isnan(values).all(axis=0)]
    return np.asarray(alive - np.nanmean(alive, axis=0)) if alive.size else alive


def _by_course(values: FloatArray) -> Moved:
    power = course_of_power(values)
    largest = float(power.max(initial=0.0))
    if largest <= 0 or len(power) < MIN_BLOCKS:
        return Moved.UNCLEAR
    power = power / largest
    peak, begins = int(np.argmax(power)), int(np.flatnonzero(power > QUIET)[0])
    if peak - begins >= RISE_BLOCKS and _falls(power[peak:]) and power[-1] < QUIET:
        return Moved.EARTHQUAKE
    motion = np.nan_to_num(_centred(values))
    course = course_of([motion], 1.0, strongest_line(motion) / len(motion), 0.5)
    match course:
        case Course.STARTS_AGAIN:
            return Moved.DECAYS
        case Course.GOES_ON:
            return Moved.AMBIENT
        case Course.DIES_AWAY:
            return Moved.FREE
    if power.std() < STEADY * power.mean() and power.min() > QUIET:
        return Moved.AMBIENT if not _falls(power[peak:]) or peak > 1 else Moved.FREE
    return Moved.UNCLEAR


def _falls(course: FloatArray) -> bool:
    """Whether a course is mostly lower from one third to the next."""
    if len(course) < 3:
        return False
    first, middle, last = (float(part.mean()) for part in np.array_split(course, 3))
    return first > middle > last and last < 0.6 * first


def _is_force(name: str, unit: str) -> bool:
    known = known_unit(unit)
    if known is not None:
        return known.si in ("N", "N m")
    return bool(FORCE_WORDS.search(name))
