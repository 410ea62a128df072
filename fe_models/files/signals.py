"""Everything that a recording file holds as channels, for a first look at it: no dataset says yet what they are."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fe_models.arrays import FloatArray
from fe_models.errors import InputError, printable, raise_faults
from fe_models.files.array_files import Arrays, pick_array
from fe_models.files.named_columns import NamedColumns
from fe_models.files.recording_checks import check_rates, size_faults
from fe_models.files.recording_files import STEP_NAME, named_columns_of
from fe_models.files.time_column import places_of_rows, time_faults

FEWEST = 4  # samples that have a spread and a course
RATE_NAMES = ("fs", "sampling_rate", "sample_rate", "rate")  # of single numbers beside arrays, in small letters


@dataclass(frozen=True)
class Signals:
    """Channels of one file: ``values`` (sample, channel), NaN where one is lost.

    ``units``: "" where the file says none. ``sampling_rate``: Hz, None where the file does not say it, with where it
    was found, ``rate_from``. ``key``: the array's name that a dataset asks for; None where columns have names.
    ``motions``: how many alike the array holds, of which these are the first. ``notes``: what was guessed or left out.
    """

    path: Path
    names: tuple[str, ...]
    units: tuple[str, ...]
    values: FloatArray
    sampling_rate: float | None
    rate_from: str = ""
    key: str | None = None
    motions: int = 1
    notes: tuple[str, ...] = ()


def read_signals(path: Path, key: str | None = None) -> Signals:
    """Return all channels of a file; ``key`` names one of several arrays. `InputError` where it cannot be read, or
    holds numbers that nobody measures.
    """
    found = named_columns_of(path, key)
    signals = _of_columns(found) if isinstance(found, NamedColumns) else _of_arrays(path, found, key)
    if len(signals.values) < FEWEST:
        raise InputError(f"{path}: {len(signals.values)} samples a channel; at least {FEWEST} can be looked at")
    names, units = (tuple(map(printable, texts)) for texts in (signals.names, signals.units))
    raise_faults(size_faults(signals.values, [f"{path}: {name}" for name in names]))
    rate = signals.sampling_rate
    known = rate if rate is not None and not check_rates(rate, None) else None
    return replace(signals, names=names, units=units, sampling_rate=known)


def _of_columns(table: NamedColumns) -> Signals:
    numeric = [column for column, is_number in enumerate(table.numeric or [True] * len(table.names)) if is_number]
    words = [name for column, name in enumerate(table.names) if column not in numeric]
    time = table.time([])
    channels = [column for column in numeric if column != time]
    if not channels:
        raise InputError(f"{table.path}: no column holds numbers; it has {table.listed()}")
    values = table.read([*channels, *([] if time is None else [time])])
    notes = [f"read as a file {table.form}"] if table.form else []
    notes += [f"no numbers: {', '.join(map(repr, words))}"] if words else []
    rate, source = table.sampling_rate, "stated in the file" if table.sampling_rate else ""
    if time is not None:
        seconds = values[:, -1] * table.seconds(time)
        places = places_of_rows(seconds)
        if places is not None:
            notes.append(f"rows are lost between its times, {int(places[-1]) + 1 - len(places)} in all")
        values, source = values[:, :-1], f"from its column {table.names[time]!r}"
        rate = _rate_of(seconds)
        notes += (
            []
            if places is not None
            else time_faults(seconds[np.isfinite(seconds)], None, f"column {table.names[time]!r}")
        )
    short = [name_of(table, column) for column in channels]
    units = tuple(table.units[column] for column in channels)
    return Signals(table.path, tuple(short), units, values, rate, source if rate else "", notes=tuple(notes))


def name_of(table: NamedColumns, column: int) -> str:
    """Return what a dataset would call a column: without the unit in brackets behind it."""
    others = table.others[column] if table.others else ()
    bracketed = [other for other in others if other and table.names[column].startswith(other)]
    return bracketed[0] if bracketed else table.names[column]


def _rate_of(seconds: FloatArray) -> float | None:
    known = seconds[np.isfinite(seconds)]
    if len(known) < 2 or known[-1] <= known[0]:
        return None
    step = float(np.median(np.diff(known)))
    mean = float((known[-1] - known[0]) / (len(known) - 1))
    exact = mean if abs(mean - step) < 0.5 * step else step  # with a gap the usual step is nearer
    return float(f"{1 / exact:.6g}") if exact > 0 else None


def _of_arrays(path: Path, arrays: Arrays, key: str | None) -> Signals:
    rate = _stated_rate(arrays)
    numeric: dict[str, NDArray[np.generic]] = {
        name: array for name, array in arrays.items() if array.dtype.kind in "iuf"
    }
    sizes = {name: array.size for name, array in numeric.items()}
    if key is None and not any(size > 1 for size in sizes.values()):
        pick_array(arrays, None if len(arrays) < 2 else "", str(path))  # says what there is instead
    largest = key or max(sizes, key=lambda name: sizes[name])
    chosen = pick_array(arrays, largest, str(path))
    single = _singles(numeric, chosen.size) if key is None and chosen.size == max(chosen.shape) else {}
    notes = [f"{name!r} is {what}, which is not read" for name, what in arrays.others.items()]
    source = "stated beside the array" if rate else ""
    if len(single) > 1:
        values = np.stack([pick_array(single, name, str(path)).ravel() for name in single], axis=1)
        return Signals(path, tuple(single), ("",) * len(single), values, rate, source, notes=tuple(notes))
    others = [name for name, array in numeric.items() if name != largest and array.size > 1]
    beside = [f"{name!r} {'x'.join(map(str, numeric[name].shape))}" for name in others]
    notes += [f"beside {largest!r} it holds {', '.join(beside)}; --key chooses"] if beside else []
    motions, values = _motion(chosen, path)
    if values.shape[0] < values.shape[1]:
        values = values.T
        notes.append("channels stand in rows: a dataset needs one a column, (time, sensor)")
    names = tuple(f"channel {number}" for number in range(1, values.shape[1] + 1))
    return Signals(path, names, ("",) * len(names), values, rate, source, largest, motions, tuple(notes))


def _motion(array: FloatArray, path: Path) -> tuple[int, FloatArray]:
    """Return how many motions an array holds, and the first, (sample, channel)."""
    if array.size == max(array.shape, default=0):
        return 1, array.reshape(-1, 1)
    if array.ndim == 3 and len(array):
        return len(array), array[0]
    if array.ndim != 2:
        raise InputError(f"{path}: shape {array.shape}; expected (time, sensor) or (recording, time, sensor)")
    return 1, array


def _singles(arrays: Mapping[str, NDArray[np.generic]], size: int) -> dict[str, NDArray[np.generic]]:
    return {name: array for name, array in arrays.items() if array.size == size == max(array.shape, default=0)}


def _stated_rate(arrays: Mapping[str, NDArray[np.generic]]) -> float | None:
    """Return the rate (Hz) that a single number beside the arrays states, as its step "dt" (s) or by its own name."""
    for name, array in arrays.items():
        if array.size == 1 and array.dtype.kind in "iuf" and float(array.ravel()[0]) > 0:
            value = float(array.ravel()[0])
            if name == STEP_NAME:
                return 1 / value
            if name.lower() in RATE_NAMES:
                return value
    return None
