"""How much of very long recordings, or of very many motions, a diagnosis goes by.

Its fits hold a slope for each sample, sensor and parameter. Beyond some hundred thousand values more of the same motion
only narrow deviations that are small already, while memory and time go on growing with them. Recordings of wind and
traffic are used whole: their correlations take next to no memory, and get better with every sample.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from fe_models.arrays import IntArray
from fe_models.recordings import Dataset, Recording
from hybrid.diagnosis.nominal.any_model import any_nominal_model_of
from hybrid.diagnosis.recorded.batches import measured_columns
from hybrid.diagnosis.recorded.config import AMOUNT
from hybrid.identification.unstated_excitation import unstated_course

ROLES: tuple[Literal["train", "test"], ...] = ("train", "test")


def limited(dataset: Dataset) -> tuple[Dataset, tuple[str, ...]]:
    """Return the dataset with no more samples than a diagnosis goes by, and notes on what is not used.

    Of long recordings the first part stays, of many motions in one recording some at even distances; each recording
    has one at least.
    """
    most = most_samples(len(measured_columns(dataset)))
    if all(sum(map(_size, dataset.select(role))) <= most for role in ROLES):
        return dataset, ()
    ambient = _ambient(dataset)
    made = dict[str, Recording]()
    for role in ROLES:
        own = [recording for recording in dataset.select(role) if recording.name not in ambient]
        made |= {recording.name: recording for recording in _enough(own, most)}
    after = replace(dataset, recordings=tuple(made.get(recording.name, recording) for recording in dataset.recordings))
    pairs = zip(dataset.recordings, after.recordings, strict=True)
    notes = [note for before, now in pairs for note in _left_out(before, now)]
    return after, tuple(notes)


def before_it_begins(dataset: Dataset) -> tuple[str, ...]:
    """Return what a user should know before a diagnosis begins: what it does not use, and memory that is no trifle."""
    after, notes = limited(dataset)
    needed = memory_gb(after)
    return (*notes, f"takes up to {needed:.1f} GB of memory") if needed >= AMOUNT.trifle_gb else notes


def memory_gb(dataset: Dataset) -> float:
    """Return about how much memory (GB) a diagnosis takes at most."""
    known = [recording for recording in dataset.select("train") if recording.excitation != "ambient"]
    samples = sum(map(_size, known))  # modes of ambient ones come from correlations, which take no more for being long
    values = samples * len(measured_columns(dataset))
    return AMOUNT.program_gb + max(AMOUNT.sample_gb * samples, AMOUNT.value_gb * values)


def most_samples(sensors: int) -> int:
    """Return how many samples of so many measured ``sensors`` a diagnosis goes by, of each role."""
    return max(AMOUNT.least_samples, AMOUNT.most_values // sensors)


def _enough(recordings: Sequence[Recording], most: int) -> list[Recording]:
    """Return recordings cut to ``most`` samples in all, as far as each then still tells something."""
    if sum(map(_size, recordings)) <= most:
        return list(recordings)
    lengths = np.array([recording.data.shape[1] for recording in recordings])
    counts = np.array([len(recording.data) for recording in recordings])
    length = max(_shared(lengths, counts, most), AMOUNT.shortest)
    share = most / float(np.sum(counts * np.minimum(lengths, length)))
    found = []
    for recording, count in zip(recordings, counts.tolist(), strict=True):
        kept = count if share >= 1 else max(int(share * count), 1)
        which = np.linspace(0, count - 1, kept).round().astype(int)
        some = recording if kept == count else replace(recording, data=recording.data[which])
        found.append(some if recording.data.shape[1] <= length else some.part(0, length))
    return found


def _shared(lengths: IntArray, counts: IntArray, most: int) -> int:
    """Return the length that the longest motions are cut to, so that all have ``most`` samples together."""
    low, high = 0, int(lengths.max())
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (middle, high) if np.sum(counts * np.minimum(lengths, middle)) <= most else (low, middle)
    return low


def _ambient(dataset: Dataset) -> set[str]:
    """Return the names of recordings that unknown forces drove, as is said, or as they go on."""
    slowest = float(any_nominal_model_of(dataset).modes[0][0]) / (2 * np.pi)
    return {
        each.name
        for each in dataset.recordings
        if each.excitation == "ambient"
        or unstated_course(each, dataset.sensors, dataset.rate_of(each), dataset.lowpass, slowest)
    }


def _left_out(before: Recording, now: Recording) -> list[str]:
    """Return a note on what a recording was cut by."""
    motions, samples, _ = before.data.shape
    kept, length, _ = now.data.shape
    parts = [f"{kept:,} of the {motions:,} motions"] * (kept < motions)
    parts += [f"the first {length:,} of {samples:,} samples"] * (length < samples)
    if not parts:
        return []
    return [f"of {before.name} {' and '.join(parts)} are used: more of the same tell little more, and take memory"]


def _size(recording: Recording) -> int:
    """Return how many samples a recording has, of all motions together."""
    return recording.data.shape[0] * recording.data.shape[1]
