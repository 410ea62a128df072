"""Channels that do not swing about zero, as accelerometers that feel gravity: no cause of the list explains that."""

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from fe_models.arrays import ComplexArray, FloatArray
from fe_models.recordings import Dataset, Sensor
from hybrid.diagnosis.recorded.config import OFFSETS
from hybrid.diagnosis.recorded.motion_free_channels import motion_free_channels

NOTE_TAKEN_OFF = "sensors do not show zero at rest, which was taken off"
NOTE_HELD_OUT = "held-out sensors do not show zero at rest, which spoils their score (subtract it)"
NOTE_DISPLACED = "displacements do not swing about zero (subtract it if it is the sensor's and not the structure's)"
NOTE_DIFFERING = "sensors show another value at rest in each recording (subtract each recording's own)"


def without_offsets(dataset: Dataset, poles: ComplexArray) -> tuple[Dataset, list[str]]:
    """Return a dataset less what its accelerometers and velocity sensors show at rest, and notes on all sensors.

    The velocity of a structure that stays where it is returns to zero on average, and so does its acceleration, linear
    or not. ``poles``: of the nominal modes (rad/s). The training recordings determine it, and it is taken off all
    recordings where they agree; nothing is from held-out sensors, nor from displacements: a stop or friction moves
    their mean. Means say something of sensors of which that says nothing.
    """
    known, silent = np.zeros(len(dataset.sensors)), set(range(len(dataset.sensors)))
    by_message: dict[str, list[str]] = {
        what: [] for what in (NOTE_TAKEN_OFF, NOTE_HELD_OUT, NOTE_DISPLACED, NOTE_DIFFERING)
    }
    for column, channel in enumerate(motion_free_channels(dataset, poles)):
        sensor, size = dataset.sensors[column], _size(dataset, column)
        offset, differing = channel.offset(), channel.differing()
        if differing is not None and np.ptp(differing) > OFFSETS.max_relative_change * np.abs(differing).max():
            if np.ptp(differing) > OFFSETS.min_difference_share * size:
                by_message[NOTE_DIFFERING].append(
                    f"{sensor.name} {differing.min():.2g} to {_formatted(differing.max(), sensor, 2)}"
                )
                silent.discard(column)
        elif offset is not None and abs(offset) > OFFSETS.min_share_of_std * size:
            what = _kept(sensor) or NOTE_TAKEN_OFF
            known[column] = offset if what == NOTE_TAKEN_OFF else 0.0
            by_message[what].append(f"{sensor.name} {_formatted(offset, sensor)}")
            silent.discard(column)
    notes = [f"{what}: {', '.join(sensors)}" for what, sensors in by_message.items() if sensors]
    notes += offsets(dataset, silent)
    if known.any():
        dataset = replace(dataset, recordings=tuple(replace(r, data=r.data - known) for r in dataset.recordings))
    return dataset, notes


def offsets(dataset: Dataset, columns: Collection[int]) -> list[str]:
    """Return a note on each of some sensors whose recordings all show the same mean.

    Known loads may bend a structure so, and say nothing.
    """
    found = []
    for column in sorted(columns):
        sensor = dataset.sensors[column]
        channels = [part[:, column] for r in dataset.recordings if not r.is_driven for part in r.data]
        means = np.array([channel.mean() for channel in channels])
        if (
            len(means)
            and all(map(_is_offset, channels))
            and np.ptp(means) < OFFSETS.max_relative_change * np.abs(means).max()
        ):
            offset = _formatted(means.mean(), sensor)
            found.append(f"sensor {sensor.name} shows {offset} in the mean of its recordings: subtract it")
    return found


def _kept(sensor: Sensor) -> str:
    """Return why an offset of a sensor is not taken off; nothing where it is."""
    if sensor.role == "held_out":
        return NOTE_HELD_OUT
    return NOTE_DISPLACED if sensor.quantity == "displacement" else ""


def _size(dataset: Dataset, column: int) -> float:
    """Return the standard deviation of a channel in its training recordings."""
    return float(np.mean([part[:, column].std() for r in dataset.select("train") for part in r.data]))


def _formatted(offset: float, sensor: Sensor, digits: int = 3) -> str:
    return f"{offset:.{digits}g} {sensor.unit}" if sensor.unit != "1" else f"{offset:.{digits}g}"


def _is_offset(channel: FloatArray) -> bool:
    """Return whether a channel (time,) has a mean that it keeps."""
    time = np.linspace(-0.5, 0.5, len(channel))
    slope, mean = np.polyfit(time, channel, 1)
    return bool(
        abs(mean) > OFFSETS.min_mean_over_std * np.std(channel - slope * time)
        and abs(slope) < OFFSETS.max_relative_change * abs(mean)
    )
