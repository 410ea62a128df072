"""Samples that a recording has lost, which stand in files as NaN.

A few are bridged by the cubic through two samples on either side, where this serves: where the same cubic finds the
samples that are there. Longer gaps cut a recording into stretches, each of which begins from a state of its own.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fe_models.arrays import BoolArray, FloatArray
from fe_models.errors import InputError
from fe_models.files.recording_checks import MIN_SAMPLES
from fe_models.recordings import Recording

MAX_BRIDGED = 3  # samples in a row
MAX_BRIDGED_SHARE = 0.01  # of a channel's samples: with the error below, 1e-4 of its energy is made up
MAX_BRIDGE_ERROR = 0.1  # RMS of the cubic's error over the channel's standard deviation
SIDE = 2  # samples on either side, which a cubic goes through
MIN_STRETCH_SHARE = 0.1  # of the longest stretch: shorter ones say little beside it
MAX_PLACES_NAMED = 3


@dataclass(frozen=True)
class Mended:
    """The ``stretches`` of a recording without lost samples, and what was done to it, in sentences."""

    stretches: tuple[Recording, ...]
    notes: tuple[str, ...] = ()


def mended(recording: Recording, channels: Sequence[str]) -> Mended:
    """Return a recording without lost samples, as it is where it has none. A channel without any sample is zero: dead.

    `InputError` where no stretch is long enough.
    """
    if _is_whole(recording):
        return Mended((recording,))
    dead = np.all(np.isnan(recording.data), axis=1)  # (realisation, sensor)
    data = np.where(dead[:, None, :], 0.0, recording.data)
    lost = [name for name, missing in zip(channels, np.any(np.isnan(data), axis=(0, 1)), strict=True) if missing]
    data, bridged = _bridged(data)
    loads = tuple(replace(load, values=_bridged(load.values[None, :, None])[0].ravel()) for load in recording.loads)
    base = tuple(replace(move, values=_bridged(move.values[None, :, None])[0].ravel()) for move in recording.base)
    recording = replace(recording, data=data, loads=loads, base=base)
    notes = [f"{recording.name}: {bridged} lost samples of {', '.join(lost)} are bridged by cubics"] if bridged else []
    missing: BoolArray = np.any(np.isnan(data), axis=2)  # (realisation, time)
    for values in recording.driving:
        missing |= np.isnan(values)
    whole = tuple(replace(move, values=np.nan_to_num(move.values)) for move in base)  # its velocity is an integral
    recording = replace(recording, base=whole)
    if not missing.any():
        return Mended((recording,), tuple(notes))
    return _cut(recording, missing, ", ".join(lost) or "its load or base motion", notes)


def _is_whole(recording: Recording) -> bool:
    return not any(np.isnan(values).any() for values in (recording.data, *recording.driving))


def _bridged(data: FloatArray) -> tuple[FloatArray, int]:
    """Return data (realisation, time, sensor) with its short gaps filled where that serves, and how many samples."""
    data, count = data.copy(), 0
    for motion in data:
        for channel in motion.T:  # a view: what is written to it is written to the data
            missing = np.isnan(channel)
            if not missing.any() or missing.mean() > MAX_BRIDGED_SHARE:
                continue
            for begin, end in _runs(missing):
                sides = [*range(begin - SIDE, begin), *range(end, end + SIDE)]
                inside = sides[0] >= 0 and sides[-1] < len(channel)
                if end - begin > MAX_BRIDGED or not inside or missing[sides].any():
                    continue
                if _bridge_error(channel, end - begin) <= MAX_BRIDGE_ERROR:
                    channel[begin:end] = _weights(end - begin) @ channel[sides]
                    count += end - begin
    return data, count


def _weights(length: int) -> FloatArray:
    """Return the weights (gap, side) with which a cubic finds a gap of that ``length`` from its sides."""
    sides = np.array([*range(-SIDE, 0), *range(length, length + SIDE)], dtype=float)
    return np.asarray(np.vander(np.arange(length, dtype=float), 2 * SIDE) @ np.linalg.inv(np.vander(sides)))


def _bridge_error(channel: FloatArray, length: int) -> float:
    """Return the RMS of what bridging would do to samples that are there, over the channel's standard deviation."""
    windows = np.lib.stride_tricks.sliding_window_view(channel, length + 2 * SIDE)
    windows = windows[np.isfinite(windows).all(axis=1)]
    if not len(windows):
        return np.inf
    sides = np.concatenate([windows[:, :SIDE], windows[:, -SIDE:]], axis=1)  # (window, side)
    error = windows[:, SIDE:-SIDE] - sides @ _weights(length).T
    spread = float(np.std(channel[np.isfinite(channel)]))
    return float(np.sqrt(np.mean(error**2)) / spread) if spread > 0 else 0.0


def _runs(flags: BoolArray) -> list[tuple[int, int]]:
    """Return where each run of set ``flags`` begins and ends (the first that is not of it)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(int), [0]])))
    return [(int(begin), int(end)) for begin, end in zip(edges[::2], edges[1::2], strict=True)]


def _cut(recording: Recording, missing: BoolArray, lost: str, notes: list[str]) -> Mended:
    """Return the stretches between gaps; motions without one stay together. ``missing``: (realisation, time)."""
    whole: BoolArray = ~np.any(missing, axis=1)
    stretches = [replace(recording, data=recording.data[whole])] if whole.any() else []
    for number in np.flatnonzero(~whole):
        name = recording.name if len(whole) == 1 else f"{recording.name} [{number + 1}]"
        motion = replace(recording, name=name, data=recording.data[number : number + 1])
        found = _runs(~missing[number])
        longest = max((end - begin for begin, end in found), default=0)
        if longest < MIN_SAMPLES:
            raise InputError(
                f"{name}: no {MIN_SAMPLES} samples in a row are whole, {longest} at most; samples of {lost} are lost"
                ": leave that sensor out, or the recording"
            )
        kept = [(begin, end) for begin, end in found if end - begin >= max(MIN_SAMPLES, MIN_STRETCH_SHARE * longest)]
        parts = [motion.part(begin, end) for begin, end in kept]
        if len(parts) > 1:
            parts = [replace(part, name=f"{name} ({place})") for place, part in enumerate(parts, start=1)]
        stretches += parts
        notes.append(f"{name}: {_said(missing[number], lost)}; {_kept(kept, found)}")
    return Mended(tuple(stretches), tuple(notes))


def _said(missing: BoolArray, lost: str) -> str:
    gaps = _runs(missing)
    places = ", ".join(f"{begin + 1} to {end}" for begin, end in gaps[:MAX_PLACES_NAMED])
    more = f" and {len(gaps) - MAX_PLACES_NAMED} more gaps" if len(gaps) > MAX_PLACES_NAMED else ""
    return f"samples {places}{more} are lost ({lost})"


def _kept(kept: list[tuple[int, int]], found: list[tuple[int, int]]) -> str:
    left = len(found) - len(kept)
    rest = f", {left} short {'one is' if left == 1 else 'ones are'} left out" if left else ""
    many = "stretch between is a recording of its own" if len(kept) > 1 else "stretch is taken"
    return f"{'each' if len(kept) > 1 else 'the longest'} {many}{rest}"
