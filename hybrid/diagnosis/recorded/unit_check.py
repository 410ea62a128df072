"""Recordings whose motions, in all channels, are far larger or smaller than the others': in another unit, perhaps."""

import numpy as np

from fe_models.arrays import TINY
from fe_models.recordings import Dataset
from hybrid.diagnosis.recorded.config import UNIT_CHECK


def other_sizes(dataset: Dataset) -> list[str]:
    """Return a note where motions fall into two groups of sizes that are far apart, on the smaller group."""
    motions = [(recording.name, data) for recording in dataset.recordings for data in recording.data]
    if len(motions) < UNIT_CHECK.min_motions:
        return []
    sizes = np.log(np.maximum([data.std(axis=0) for _, data in motions], TINY))  # (motion, sensor)
    size = np.median(sizes - np.median(sizes, axis=0), axis=1)
    order = np.argsort(size)
    gaps = np.diff(size[order])
    if gaps.max() < np.log(UNIT_CHECK.min_size_ratio):
        return []
    first = int(gaps.argmax()) + 1
    low, high = order[:first], order[first:]
    few, others = (low, high) if len(low) < len(high) else (high, low)
    times = float(np.exp(np.median(size[few]) - np.median(size[others])))
    names = ", ".join(dict.fromkeys(motions[i][0] for i in sorted(few)))
    return [f"motions of {names} are {times:.3g} times as large as the others: check their unit"]
