"""Recordings whose motions, in all channels, are far larger or smaller than the others': in another unit, perhaps."""

import numpy as np

from fe_models.recordings import Dataset

FAR = 100.0  # times what is usual: of m/s^2, mm/s^2 are a thousand, and motions of one campaign hardly differ so much
FEWEST = 3  # recordings: of two nobody knows which is the usual one


def other_sizes(dataset: Dataset) -> list[str]:
    """Return a note on each recording that is far from the usual size."""
    if len(dataset.recordings) < FEWEST:
        return []
    sizes = np.array([recording.data.std(axis=1).mean(axis=0) for recording in dataset.recordings])
    relative = np.median(sizes / np.maximum(np.median(sizes, axis=0), 1e-300), axis=1)
    return [
        f"motions of {recording.name} are {size:.3g} times as large as usual in the other recordings: check its unit"
        for recording, size in zip(dataset.recordings, relative, strict=True)
        if not 1 / FAR < size < FAR
    ]
