"""The data of recordings and loads, read from any file of the list and brought to the shapes of `recordings`."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from fe_models.arrays import FloatArray
from fe_models.errors import InputError, noting, raise_faults
from fe_models.files.array_files import (
    LOADERS,
    TDMS_SUFFIXES,
    TEXT_SUFFIXES,
    UNIVERSAL_SUFFIXES,
    Arrays,
    check_exists,
    load_arrays,
    pick_array,
)
from fe_models.files.named_columns import NamedColumns, converting_factor, required
from fe_models.files.size_limit import check_values
from fe_models.files.text_table import open_table
from fe_models.files.time_column import places_of_rows, time_faults, usual_rate_faults

STEP_TOLERANCE = 0.01  # relative: a stored time step is often rounded to three digits ...
ROUNDED_TOLERANCE = 0.02  # ... or to two, as 0.033 s at 29.97 Hz
STEP_NAME = "dt"


@dataclass(frozen=True)
class RecordingFile:
    """``data`` (realisation, time, sensor), and the names of the file's columns that were ``skipped``.

    ``form``: in words, what was guessed of the layout of a text file. ``notes``: what else a user should know.
    """

    data: FloatArray
    skipped: tuple[str, ...] = ()
    form: str = ""
    notes: tuple[str, ...] = ()


@np.errstate(invalid="ignore", over="ignore")  # what is not finite is found and named, whatever its units
def load_recording(
    path: Path,
    key: str | None,
    sensors: Sequence[str],
    sampling_rate: float | None,
    loads: Collection[str] = (),
    units: Sequence[str] | None = None,
) -> RecordingFile:
    """Return a recording, its channels in the order of ``sensors`` and in their ``units``; `InputError` with all.

    Where a file names its columns, they may have any order, and one may hold
    times (s); ``loads`` names those that hold known forces, and what nobody asks for is skipped. So are arrays of one
    channel each, where no ``key`` names one for all. A time step "dt" (s) beside an array, that column, or the rate
    that a file states must agree with ``sampling_rate`` (Hz).
    """
    columns = named_columns_of(path, key, sensors)
    if isinstance(columns, NamedColumns):
        return _from_columns(columns, sensors, units or ["1"] * len(sensors), sampling_rate, loads)
    arrays = columns
    step = arrays.pop(STEP_NAME, None) if key != STEP_NAME else None
    data = pick_array(arrays, key, str(path))
    faults = []
    if step is not None and step.size == 1 and step.dtype.kind in "iuf":
        faults = _step_faults(float(step.ravel()[0]), sampling_rate, f"{path}: its {STEP_NAME}")
    if len(sensors) == 1 and data.size == max(data.shape, default=0):
        data = data.reshape(-1, 1)
    if data.ndim not in (2, 3):
        faults.append(f"{path}: shape {data.shape}; expected (time, sensor) or (recording, time, sensor)")
    elif data.shape[-1] != len(sensors):
        turned = "; it looks transposed" if data.shape[-2] == len(sensors) else ""
        faults.append(f"{path}: {data.shape[-1]} columns for {len(sensors)} sensors; one column a sensor{turned}")
    raise_faults(faults)
    return RecordingFile(data if data.ndim == 3 else data[None])


def named_columns_of(path: Path, key: str | None = None, asked: Collection[str] = ()) -> NamedColumns | Arrays:
    """Return the columns of a file that names them; else its arrays.

    Arrays of one channel each are columns where there is no ``key`` and all that are ``asked`` for are among them.
    """
    check_exists(path)
    suffix = path.suffix.lower()
    if suffix in TEXT_SUFFIXES:
        return open_table(path).columns()
    if suffix in UNIVERSAL_SUFFIXES:
        from fe_models.files.universal_file import universal_columns

        return universal_columns(path)
    if suffix in TDMS_SUFFIXES:
        from fe_models.files.tdms_file import tdms_columns

        return tdms_columns(path)
    assert suffix in LOADERS  # else `check_exists` has refused it
    arrays = load_arrays(path)
    single = {name: array for name, array in arrays.items() if array.size == max(array.shape, default=0) > 1}
    lengths = {array.size for name, array in single.items() if name in asked}
    if key is None and len(asked) > 1 and set(asked) <= single.keys() and len(lengths) == 1:
        return _as_columns(path, {name: array for name, array in single.items() if array.size in lengths}, arrays)
    return arrays


def skipped_note(columns: Collection[str], files: Collection[str]) -> str:
    """Return the sentence on ``columns`` of ``files`` that hold no sensor's data."""
    names = ", ".join(repr(name) if name else "one without a name" for name in columns)
    which = f"column {names} belongs" if len(columns) == 1 else f"columns {names} belong"
    return f"{', '.join(files)}: {which} to no sensor and no load and {'is' if len(columns) == 1 else 'are'} skipped"


def load_force(path: Path, key: str | None, unit: str = "N") -> FloatArray:
    """Return a load's values (time,) in ``unit``; where a file names several columns beside times, ``key`` is one."""
    columns = named_columns_of(path, key)
    if isinstance(columns, NamedColumns):
        return _force_column(columns, key, unit)
    force = pick_array(columns, key, str(path))
    if force.size != max(force.shape, default=0):
        raise InputError(f"{path}: shape {force.shape}; expected (time,), one value a sample")
    return force.ravel()


def _from_columns(
    table: NamedColumns,
    sensors: Sequence[str],
    units: Sequence[str],
    sampling_rate: float | None,
    loads: Collection[str],
) -> RecordingFile:
    path, faults = table.path, list[str]()
    found = noting(faults, "", required, table, sensors, "for sensor ")
    times = noting(faults, "", table.time, [*sensors, *loads])
    if found is None:
        if times is not None:  # what is wrong with it is said as well
            faults += _time_faults(table, table.read([times])[:, 0], times, sampling_rate)
        raise InputError(faults)
    factors = [
        noting(faults, str(path), converting_factor, table.names[column], table.units[column], unit)
        for column, unit in zip(found, units, strict=True)
    ]
    values = noting(faults, "", table.read, found if times is None else [*found, times])
    if values is not None and times is not None:
        faults += _time_faults(table, values[:, -1], times, sampling_rate)
        values = _with_lost_rows(table, values, times)
    if table.sampling_rate is not None:
        faults += _step_faults(1 / table.sampling_rate, sampling_rate, f"{path}: its time step")
    raise_faults(faults)
    assert values is not None  # else there were faults
    asked = {*found, times, *(table.find(name) for name in loads)}
    skipped = tuple(dict.fromkeys(name for column, name in enumerate(table.names) if column not in asked))
    data = values[None, :, : len(found)] * [1.0 if factor is None else factor for factor in factors]
    return RecordingFile(data, skipped, table.form, _conversions(table, found, sensors, units))


def _conversions(
    table: NamedColumns, found: Sequence[int], sensors: Sequence[str], units: Sequence[str]
) -> tuple[str, ...]:
    """Return a sentence for each pair of units, one of the file and one of the dataset, that differ."""
    pairs: dict[tuple[str, str], list[str]] = {}
    for column, name, unit in zip(found, sensors, units, strict=True):
        if converting_factor(table.names[column], table.units[column], unit) != 1.0:
            pairs.setdefault((table.units[column], unit), []).append(name)
    return tuple(
        f"{', '.join(names)}: converted from {own}, which the file states, to {unit}"
        for (own, unit), names in pairs.items()
    )


def _time_faults(table: NamedColumns, values: FloatArray, column: int, sampling_rate: float | None) -> list[str]:
    what = f"{table.path}: its column {table.names[column]!r}"
    seconds = _filled_times(values) * table.seconds(column)
    check = time_faults if places_of_rows(seconds) is None else usual_rate_faults
    return check(seconds, sampling_rate, what)


def _force_column(table: NamedColumns, key: str | None, unit: str) -> FloatArray:
    if key is None:
        times = table.time([])
        names = [name for column, name in enumerate(table.names) if column != times]
        if len(names) != 1:
            listed = ", ".join(repr(name) for name in names)
            raise InputError(f"{table.path}: has the columns {listed}; say which with key")
        key = names[0]
    (column,) = required(table, [key], "")
    factor = converting_factor(table.names[column], table.units[column], unit)
    times = table.time([key])
    if times is None:
        return factor * table.read([column])[:, 0]
    return factor * _with_lost_rows(table, table.read([column, times]), times)[:, 0]


def _with_lost_rows(table: NamedColumns, values: FloatArray, times: int) -> FloatArray:
    """Return values (row, column), the last of them times, with NaN in place of the rows that those say were lost."""
    places = places_of_rows(_filled_times(values[:, -1]) * table.seconds(times))
    if places is None:
        return values
    check_values(int(places[-1]) * values.shape[1], table.path)
    whole = np.full((int(places[-1]) + 1, values.shape[1]), np.nan)
    whole[places] = values
    return whole


def _filled_times(values: FloatArray) -> FloatArray:
    """Return times (row,) with those of lost samples, which are lost with them, from their neighbours."""
    known, rows = np.isfinite(values), np.arange(len(values))
    return np.interp(rows, rows[known], values[known]) if known.any() else values


def _as_columns(path: Path, single: dict[str, NDArray[np.generic]], arrays: Arrays) -> NamedColumns:
    """Return arrays of one channel each as columns; a step "dt" beside them is their sampling rate."""
    names = tuple(name for name in single if name != STEP_NAME)

    def read(columns: Sequence[int]) -> FloatArray:
        return np.stack([pick_array(single, names[column], str(path)).ravel() for column in columns], axis=1)

    step, rate = arrays.get(STEP_NAME), None
    if step is not None and step.size == 1 and step.dtype.kind in "iuf":
        seconds = float(step.ravel()[0])
        if not 0 < seconds < np.inf:
            raise InputError(f"{path}: its {STEP_NAME} is {seconds:g} s; expected the time step, above 0 s, or none")
        rate = 1 / seconds
    return NamedColumns(path, names, ("",) * len(names), read, sampling_rate=rate)


def _step_faults(step: float, sampling_rate: float | None, what: str) -> list[str]:
    """Return a fault where the time step (s) stored in a file contradicts the stated sampling rate (Hz)."""
    if sampling_rate is None:
        return []
    rounded = step == float(f"{1 / sampling_rate:.2g}")
    if abs(step * sampling_rate - 1) <= (ROUNDED_TOLERANCE if rounded else STEP_TOLERANCE):
        return []
    rate = f" ({1 / step:g} Hz)" if step > 0 else ""
    return [f"{what} is {step:g} s{rate}, but sampling_rate says {sampling_rate:g} Hz"]
