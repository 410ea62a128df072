"""Channels that are dead, stuck or saturated: what of a dataset can be used all the same.

A motion may begin at any sample, so that a recording whose channel is stuck or saturated is used from behind the last
such sample on; or the channel is left out everywhere, whichever loses fewer values. A dead channel spoils its recording
whole, and recordings in which most channels are dead are left out before any channel is, where that loses fewer.
"""

from collections import Counter
from dataclasses import dataclass, replace

import numpy as np

from fe_models.arrays import BoolArray, FloatArray, IntArray
from fe_models.errors import InputError
from fe_models.files.recording_checks import FLAT_TOLERANCE, MIN_SAMPLES
from fe_models.recordings import Dataset, Recording
from hybrid.diagnosis.recorded.config import CHANNEL_FAULTS
from hybrid.diagnosis.recorded.motions import in_words, motions_of


@dataclass(frozen=True)
class _Fault:
    """What is wrong with one channel: ``word``, and of each recording how many samples are ``bad`` and how many come no
    later than the ``last`` of these.
    """

    word: str
    bad: tuple[int, ...]
    last: tuple[int, ...]


def usable(dataset: Dataset) -> tuple[Dataset, list[str]]:
    """Return the dataset without dead, stuck and saturated samples, and a note on each sensor that has some.

    A motion in which no sensor changes says nothing of the sensors. `InputError` where no measured channel or no
    training recording is left.
    """
    single = [replace(r, data=part[None]) for r in dataset.recordings for part in r.data]
    measured = [i for i, sensor in enumerate(dataset.sensors) if sensor.role == "measured"]
    still, hardly = _quiet(single, measured)
    moving = tuple(r for r, left_out in zip(single, still | hardly, strict=True) if not left_out)
    if len(moving) < len(single) and any(recording.role == "train" for recording in moving):
        rest, notes = usable(replace(dataset, recordings=moving))
        every = motions_of(dataset)
        for word, chosen in (("no sensor changes", still), ("most sensors never change", hardly)):
            some = Counter(r.name for r, is_one in zip(single, chosen, strict=True) if is_one)
            notes = [f"{word} in {in_words(some, every)}: left out", *notes] if some else notes
        return rest, notes
    faults = {column: fault for column in range(len(dataset.sensors)) if (fault := _fault(single, column))}
    if not faults:
        return dataset, []
    sizes = np.array([recording.data.shape[1] for recording in single])
    dropped = set[int]()
    first = np.zeros(len(single), dtype=int)
    for column, fault in faults.items():
        begin = np.array(fault.last)
        cut = np.maximum(begin, first)
        by_cutting = int((cut - first).sum()) * len(dataset.sensors)
        spared = dataset.sensors[column].role != "measured" or len(set(measured) - dropped) > 1
        trained = any(
            size - b >= MIN_SAMPLES and r.role == "train" for r, size, b in zip(single, sizes, cut, strict=True)
        )
        leave_out = (spared and by_cutting >= sizes.sum()) or not trained
        if leave_out:
            dropped.add(column)
        else:
            first = cut
    notes = [
        _note(dataset.sensors[column].name, fault, single, None if column in dropped else first)
        for column, fault in faults.items()
    ]
    if dropped >= set(measured):
        raise InputError(["no measured sensor is left to fit: give at least one channel that is alive", *notes])
    kept = [i for i in range(len(dataset.sensors)) if i not in dropped]
    recordings = tuple(
        _from(recording, int(begin), kept)
        for recording, begin, size in zip(single, first, sizes, strict=True)
        if size - begin >= MIN_SAMPLES
    )
    return replace(dataset, sensors=tuple(dataset.sensors[i] for i in kept), recordings=recordings), notes


def _fault(recordings: list[Recording], column: int) -> _Fault | None:
    channels = [recording.data[0, :, column] for recording in recordings]
    sizes = np.array([0.0 if is_dead(channel) else channel.std() for channel in channels])
    usual = float(np.median(sizes[sizes > 0])) if sizes.any() else 0.0
    dead = (sizes <= CHANNEL_FAULTS.silent_share * usual).tolist()
    alive = [channel for channel, off in zip(channels, dead, strict=True) if not off]
    levels = sorted({level for channel in alive for level in saturation_levels(channel)})
    stuck = [stuck_samples(channel) for channel in channels]
    bad = [
        np.full(len(c), True) if off else _at(c, levels) | still
        for c, off, still in zip(channels, dead, stuck, strict=True)
    ]
    if not any(part.any() for part in bad):
        return None
    last = tuple(int(np.flatnonzero(part)[-1]) + 1 if part.any() else 0 for part in bad)
    words = ["never changes" if not sizes[dead].any() else "hardly changes"] * any(dead)
    words += [f"is saturated at {_levels_in_words(levels)}"] * bool(levels)
    words += ["stands still"] * any(
        (still & ~_at(c, levels)).any() for c, off, still in zip(channels, dead, stuck, strict=True) if not off
    )
    return _Fault(" or ".join(words), tuple(int(part.sum()) for part in bad), last)


def is_dead(channel: FloatArray) -> bool:
    """Return whether a channel (time,) never changes."""
    return bool(np.ptp(channel) <= FLAT_TOLERANCE * np.abs(channel).max())


def _quiet(single: list[Recording], measured: list[int]) -> tuple[BoolArray, BoolArray]:
    """Return in which recordings (recording,), a motion each, no sensor changes, and in which others most of the
    ``measured`` ones do not, if it loses fewer values to leave these out than the sensors that are dead there.
    """
    sizes = np.array([recording.data.shape[1] for recording in single])
    dead = np.array([[is_dead(channel) for channel in recording.data[0].T] for recording in single])
    still, own = np.asarray(dead.all(axis=1)), dead[:, measured]
    own = own[:, ~own.all(axis=0)]
    hardly = (own.sum(axis=1) > CHANNEL_FAULTS.max_dead_share * own.shape[1]) & ~still
    of_recordings = int(sizes[hardly] @ (~own[hardly]).sum(axis=1))
    rest = ~(hardly | still)
    of_sensors = int(sizes[rest] @ (~own[rest][:, own[hardly].any(axis=0)]).sum(axis=1))
    return still, hardly & (of_recordings < of_sensors)


def _levels_in_words(levels: list[float]) -> str:
    if len(levels) > CHANNEL_FAULTS.max_levels_listed:
        return f"{len(levels)} levels from {levels[0]:.4g} to {levels[-1]:.4g}"
    return " and ".join(f"{level:.4g}" for level in levels)


def saturation_levels(channel: FloatArray) -> list[float]:
    """Return the least or largest value of a channel (time,), or both, where the sensor cannot show more."""
    tolerance = CHANNEL_FAULTS.rounding * float(np.ptp(channel))
    low, high = float(channel.min()), float(channel.max())
    between = (channel > low + tolerance) & (channel < high - tolerance)
    still = np.abs(np.diff(channel)) <= tolerance
    elsewhere = 1 + _longest(still & between[1:] & between[:-1])
    unrounded = len(np.unique(channel[between])) > CHANNEL_FAULTS.min_distinct_share * between.sum()

    def is_reached(level: float) -> bool:
        at = np.abs(channel - level) <= tolerance
        return _longest(at) >= max(
            CHANNEL_FAULTS.min_equal_extremes, CHANNEL_FAULTS.min_run_ratio * elsewhere + 1
        ) or bool(unrounded and at.sum() >= CHANNEL_FAULTS.min_extreme_count)

    return [level for level in (low, high) if is_reached(level)]


def stuck_samples(channel: FloatArray) -> BoolArray:
    """Return which samples of a channel (time,) repeat the same value amid motion, where nearly all others differ."""
    found = np.zeros(len(channel), dtype=bool)
    for first, last in zip(*_runs(np.diff(channel) == 0), strict=True):
        near = channel[max(first - CHANNEL_FAULTS.min_equal_values, 0) : last + 1 + CHANNEL_FAULTS.min_equal_values]
        # what has died away repeats a rounded zero
        moves = np.ptp(near) > CHANNEL_FAULTS.min_range_share * np.ptp(channel)
        found[first : last + 1] = moves and last + 1 - first >= CHANNEL_FAULTS.min_equal_values
    rest = channel[~found]
    return found & (len(np.unique(rest)) > CHANNEL_FAULTS.min_distinct_share * len(rest))


def _at(channel: FloatArray, levels: list[float]) -> BoolArray:
    tolerance = CHANNEL_FAULTS.rounding * float(np.ptp(channel))
    found = np.zeros(len(channel), dtype=bool)
    for level in levels:
        found |= np.abs(channel - level) <= tolerance
    return found


def _longest(marks: BoolArray) -> int:
    """Return the length of the longest run of marks."""
    first, behind = _runs(marks)
    return int((behind - first).max(initial=0))


def _runs(marks: BoolArray) -> tuple[IntArray, IntArray]:
    """Return where each run of marks begins, and the place behind its last one."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], marks, [False]]).astype(int)))
    return edges[::2], edges[1::2]


def _from(recording: Recording, begin: int, columns: list[int]) -> Recording:
    later = recording.part(begin)
    return replace(later, data=later.data[..., columns])


def _note(sensor: str, fault: _Fault, recordings: list[Recording], first: IntArray | None) -> str:
    """Return what is wrong with a ``sensor``, and what becomes of its recordings, which are used from their ``first``
    (recording,) samples on; None where the sensor is left out.
    """
    begins = fault.last if first is None else first
    spoilt = [part for part in zip(recordings, fault.bad, begins, strict=True) if part[1]]
    whole = dict.fromkeys(r.name for r, count, _ in spoilt if count == r.data.shape[1])
    parts = [f"{count} samples of {r.name}" for r, count, _ in spoilt if count < r.data.shape[1]]
    where = ", ".join([f"all of {', '.join(whole)}"] * bool(whole) + parts)
    if first is None:
        return f"sensor {sensor} {fault.word} ({where}): it is left out"
    gone, cut = dict[str, None](), dict[str, None]()  # several motions in one file share its name
    for recording, _, begin in spoilt:
        (gone if recording.data.shape[1] - begin < MIN_SAMPLES else cut)[recording.name] = None
    ends = [f"{', '.join(gone)} left out"] * bool(gone) + [f"{', '.join(cut)} used from there on"] * bool(cut)
    return f"sensor {sensor} {fault.word} ({where}): {'; '.join(ends)}"
