"""Channels that do not swing about zero, as accelerometers that feel gravity: no cause of the list explains that."""

import numpy as np

from fe_models.dofs import FloatArray
from fe_models.recordings import Dataset

LARGE = 0.25  # times the standard deviation about it: a mean that no oscillation of two periods or more leaves
STEADY = 0.3  # of the mean: how far it may differ between recordings, and move within one; a drift does


def offsets(dataset: Dataset) -> list[str]:
    """Return a note on each sensor whose recordings all show the same mean. Known loads may bend a structure so."""
    found = []
    for column, sensor in enumerate(dataset.sensors):
        channels = [part[:, column] for r in dataset.recordings if not r.loads for part in r.data]
        means = np.array([channel.mean() for channel in channels])
        if len(means) and all(map(_is_offset, channels)) and np.ptp(means) < STEADY * np.abs(means).max():
            size = f"{means.mean():.3g} {sensor.unit}" if sensor.unit != "1" else f"{means.mean():.3g}"
            found.append(f"sensor {sensor.name} shows {size} in the mean of its recordings: subtract it")
    return found


def _is_offset(channel: FloatArray) -> bool:
    """Return whether a channel (time,) has a mean that it keeps."""
    time = np.linspace(-0.5, 0.5, len(channel))
    slope, mean = np.polyfit(time, channel, 1)
    return bool(abs(mean) > LARGE * np.std(channel - slope * time) and abs(slope) < STEADY * abs(mean))
