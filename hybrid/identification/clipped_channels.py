"""Channels whose motion went beyond the range of their sensor or converter, which cut it off."""

import numpy as np

from fe_models.arrays import BoolArray, FloatArray
from fe_models.recordings import Dataset

MIN_CLIPPED = 3  # samples in a row at the largest or smallest value: a smooth motion has one or two there
MIN_CLIPPED_RUNS = 2
MIN_LEVELS = 64  # different values, below which any channel rests at its largest one


def clipped_samples(values: FloatArray) -> int:
    """Return how many of the ``values`` (sample,) rest at an end of their range, 0 where that is no more than a smooth
    motion does.
    """
    if len(np.unique(values)) < MIN_LEVELS:
        return 0
    count = 0
    for end in (values.min(), values.max()):
        lengths = run_lengths(values == end)
        lengths = lengths[lengths >= MIN_CLIPPED]
        count += int(lengths.sum()) if len(lengths) >= MIN_CLIPPED_RUNS else 0
    return count


def run_lengths(flags: BoolArray) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """Return the length of each run of set ``flags``."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(int), [0]])))
    return np.asarray(edges[1::2] - edges[::2], dtype=np.int64)


def clipped_notes(dataset: Dataset) -> tuple[str, ...]:
    """Return a note on each sensor of a dataset that is clipped in recordings."""
    notes = []
    for column, sensor in enumerate(dataset.sensors):
        counts = {r.name: sum(clipped_samples(data[:, column]) for data in r.data) for r in dataset.recordings}
        some = [f"{name} ({count} samples)" for name, count in counts.items() if count]
        if some:
            notes.append(
                f"{sensor.name} is clipped in {', '.join(some)}: its motion went beyond the range, so that shapes are"
                " too small there, and multiples of frequencies may be the cutting's"
            )
    return tuple(notes)
