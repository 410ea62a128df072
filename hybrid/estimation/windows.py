"""Windows: the stretches of a recording that are forecast from their first samples."""

from collections.abc import Sequence
from typing import Literal

import numpy as np
import torch

from fe_models.arrays import BoolArray, FloatArray, IntArray
from fe_models.errors import InputError
from fe_models.recordings import Dataset, Recording
from hybrid.config import Config
from hybrid.estimation.config import WINDOWS
from hybrid.known_loads.modal_input import ModalInput
from hybrid.neural_modal_ode.driving import Driving


def cut(recording: Recording, length: int, stride: int) -> FloatArray:
    """Return the windows (window, time, sensor) of ``length`` samples that start every ``stride`` samples.

    Windows in which a channel is constant (silence before a trigger, say) say nothing and are passed over;
    `InputError` where none remains.
    """
    windows = _stretches(recording.data, length, stride)
    alive = _alive(windows)
    if not alive.any():
        raise InputError(
            f"recording {recording.name!r}: in every window of {length} samples some channel is constant;"
            " leave the recording or the channel out"
        )
    return windows[alive]


def cut_field(field: FloatArray, recording: Recording, length: int, stride: int) -> FloatArray:
    """Return the windows (window, time, dof) of a field (time, dof) where `cut` has those of the recording.

    The field is that of the recording's first realisation, whose windows come first.
    """
    return _stretches(field[None], length, stride)[0, _alive(_stretches(recording.data[:1], length, stride))[0]]


def _stretches(data: FloatArray, length: int, stride: int) -> FloatArray:
    """Return a view (realisation, window, time, column) of data (realisation, time, column)."""
    views = np.lib.stride_tricks.sliding_window_view(data, length, axis=1)
    return views[:, ::stride].swapaxes(2, 3)


def _alive(stretches: FloatArray) -> BoolArray:
    """Return whether no channel is constant in a window (realisation, window)."""
    return np.asarray(np.ptp(stretches, axis=2).all(axis=-1))


def cut_all(recordings: Sequence[Recording], length: int, stride: int) -> FloatArray:
    """Return the windows of several recordings, one after the other."""
    return np.concatenate([cut(recording, length, stride) for recording in recordings])


def cut_driving(forces: ModalInput | None, recordings: Sequence[Recording], length: int, stride: int) -> Driving | None:
    """Return what drives the windows that `cut_all` has of the recordings; None where ``forces`` are none."""
    if forces is None:
        return None
    courses, shown = list[FloatArray](), list[FloatArray]()
    for recording in recordings:
        own = forces.courses(recording)  # (time, order, force)
        seen = forces.shown_at_once(recording, own)
        for motion in _alive(_stretches(recording.data, length, stride)):  # (window,) of each realisation
            courses.append(_stretches(own.reshape(1, len(own), -1), length, stride)[0, motion])
            shown.append(_stretches(seen[None], length, stride)[0, motion])
    return _driving(np.concatenate(courses), np.concatenate(shown), forces)


def driving_of(forces: ModalInput | None, recording: Recording) -> Driving | None:
    """Return what drives whole motions of a recording, one window each; None where ``forces`` are none."""
    if forces is None:
        return None
    courses = forces.courses(recording)
    shown = forces.shown_at_once(recording, courses)
    return _driving(courses[None], shown[None], forces).repeated(len(recording.data))


def _driving(courses: FloatArray, shown: FloatArray, forces: ModalInput) -> Driving:
    """Return ``courses`` (window, time, ...) and what is ``shown`` (window, time, sensor) as tensors."""
    known = courses.reshape(*courses.shape[:2], -1, len(forces.participation))
    return Driving(*(torch.tensor(part) for part in (known, forces.participation, shown)))


def evenly(windows: FloatArray, most: int) -> FloatArray:
    """Return ``most`` of the windows, evenly chosen; all, where they are fewer."""
    return np.ascontiguousarray(windows[evenly_chosen(len(windows), most)])


def evenly_chosen(count: int, most: int) -> IntArray:
    """Return the numbers of ``most`` windows of ``count``, evenly chosen; of all, where they are fewer."""
    return np.linspace(0, count - 1, min(most, count)).round().astype(int)


def window_length(dataset: Dataset, config: Config) -> int:
    """Return the samples of a window: those of ``config``, or fewer where a recording is shorter.

    Where ``config`` leaves them open and recordings are so short that they would give only a few windows, these are
    shorter: `min_windows` of all training recordings (of each one, for experts), if they keep `min_recording_share`
    of the shortest recording. `InputError` where windows would be too short for the encoder.
    """
    seen = config.model.encoder_samples
    wanted = WINDOWS.default_samples if config.training.window is None else config.training.window
    if wanted < 4 * seen:
        raise InputError(
            f"a window of {wanted} samples is too short: at least {4 * seen} are needed, four times the"
            f" {seen} that the encoder sees"
        )
    shortest = min(dataset.recordings, key=lambda recording: recording.data.shape[1])
    available = shortest.data.shape[1]
    if available < 4 * seen:
        raise InputError(
            f"recording {shortest.name!r} has {available} samples: a window needs at least {4 * seen},"
            f" four times the {seen} that the encoder sees"
        )
    longest = min(wanted, available)
    if config.training.window is not None:
        return longest
    floor = max(4 * seen, round(WINDOWS.min_recording_share * available))
    learners = [[each] for each in dataset.select("train")] if config.model.experts else [dataset.select("train")]
    return next(
        (
            length
            for length in range(longest, floor, -1)
            if min(_count(recordings, length, config.training.stride) for recordings in learners) >= WINDOWS.min_windows
        ),
        min(floor, longest),
    )


def _count(recordings: Sequence[Recording], length: int, stride: int) -> int:
    """Return how many windows recordings have, silent ones included."""
    return sum(len(each.data) * ((each.data.shape[1] - length) // stride + 1) for each in recordings)


def columns(dataset: Dataset, role: Literal["measured", "held_out"]) -> list[int]:
    """Return the column numbers of the sensors with that role."""
    return [i for i, sensor in enumerate(dataset.sensors) if sensor.role == role]
