"""What a recording looks as if it had been moved by: a guess from its course, for a user to confirm."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.files.unit_words import known_unit

BLOCKS = 40  # of a recording, in each of which its power is taken
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
    moved = _course(course_of_power(values))
    return Guess(Moved.STEADY if moved is Moved.AMBIENT and _kurtosis(values) < MAX_KURTOSIS_OF_SINES else moved)


def course_of_power(values: FloatArray) -> FloatArray:
    """Return the RMS of all channels together in each block (block,), every channel over its own standard deviation."""
    centred = np.nan_to_num(values - np.nanmean(values, axis=0)) if len(values) else values
    spread = centred.std(axis=0)
    alive = centred[:, spread > 0] / spread[spread > 0]
    blocks = np.array_split(alive, min(BLOCKS, max(len(alive) // 8, 1)))
    return np.array([np.sqrt(np.mean(block**2)) if block.size else 0.0 for block in blocks])


def _kurtosis(values: FloatArray) -> float:
    """Return the mean kurtosis of the channels: 3 of normal distributed values, 1.5 of a sine."""
    centred = values - np.nanmean(values, axis=0)
    variance = np.nanmean(centred**2, axis=0)
    alive = variance > 0
    return float(np.mean(np.nanmean(centred[:, alive] ** 4, axis=0) / variance[alive] ** 2)) if alive.any() else 0.0


def _course(power: FloatArray) -> Moved:
    largest = float(power.max(initial=0.0))
    if largest <= 0 or len(power) < 8:
        return Moved.UNCLEAR
    course = power / largest
    peak = int(np.argmax(course))
    if course.std() < STEADY * course.mean() and course.min() > QUIET:
        return Moved.AMBIENT if not _falls(course[peak:]) or peak > 1 else Moved.FREE
    begins = int(np.flatnonzero(course > QUIET)[0])
    if _starts(course) > 1:
        return Moved.DECAYS
    if _falls(course[peak:]) and course[-1] < 0.5:
        return Moved.FREE if peak - begins < RISE_BLOCKS else Moved.EARTHQUAKE
    return Moved.UNCLEAR


def _falls(course: FloatArray) -> bool:
    """Whether a course is mostly lower from one third to the next."""
    if len(course) < 3:
        return False
    first, middle, last = (float(part.mean()) for part in np.array_split(course, 3))
    return first > middle > last and last < 0.6 * first


def _starts(course: FloatArray) -> int:
    """Return how often a course jumps to half of its largest value or more within a block or two."""
    before = np.concatenate([[0.0, 0.0], course[:-2]])
    jumps = (course > 0.5) & (course > 2.5 * np.maximum(before, QUIET))
    return int((np.diff(np.concatenate([[0], jumps.astype(int)])) == 1).sum())


def _is_force(name: str, unit: str) -> bool:
    known = known_unit(unit)
    if known is not None:
        return known.si in ("N", "N m")
    return bool(FORCE_WORDS.search(name))
