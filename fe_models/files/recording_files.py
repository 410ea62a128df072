"""The arrays of recordings and loads, read from .npz, .mat or .csv and brought to the shapes of `recordings`."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

from fe_models.arrays import FloatArray
from fe_models.errors import InputError, noting, raise_faults
from fe_models.files.array_files import load_arrays, load_csv, pick_array
from fe_models.files.time_column import time_column, time_faults

STEP_TOLERANCE = 0.01  # relative: a stored time step is often rounded to three digits ...
ROUNDED_TOLERANCE = 0.02  # ... or to two, as 0.033 s at 29.97 Hz
STEP_NAME = "dt"


@dataclass(frozen=True)
class RecordingFile:
    """``data`` (realisation, time, sensor), and the names of the file's columns that were ``skipped``.

    ``form``: in words, how a .csv file is not one of commas and decimal points alone.
    """

    data: FloatArray
    skipped: tuple[str, ...] = ()
    form: str = ""


def load_recording(
    path: Path, key: str | None, sensors: Sequence[str], sampling_rate: float | None, loads: Collection[str] = ()
) -> RecordingFile:
    """Return a recording, its channels in the order of ``sensors``; `InputError` carries all faults.

    A .csv file has the sensors' names as its header, in any order, and may have a column of times (s); ``loads`` names
    its columns that hold known forces, and what nobody asks for is skipped. A time step "dt" (s) beside an array, or
    that column, must agree with ``sampling_rate`` (Hz).
    """
    if path.suffix == ".csv":
        return _load_recording_csv(path, sensors, sampling_rate, loads)
    arrays = load_arrays(path)
    step = arrays.pop(STEP_NAME, None) if key != STEP_NAME else None
    data = pick_array(arrays, key, str(path))
    faults = []
    if step is not None and step.size == 1 and step.dtype.kind in "iuf":
        faults = _step_faults(float(step.ravel()[0]), sampling_rate, f"{path}: its {STEP_NAME}")
    if data.ndim == 1 and len(sensors) == 1:
        data = data[:, None]
    if data.ndim not in (2, 3):
        faults.append(f"{path}: shape {data.shape}; expected (time, sensor) or (recording, time, sensor)")
    elif data.shape[-1] != len(sensors):
        turned = "; it looks transposed" if data.shape[-2] == len(sensors) else ""
        faults.append(f"{path}: {data.shape[-1]} columns for {len(sensors)} sensors; one column a sensor{turned}")
    raise_faults(faults)
    return RecordingFile(data if data.ndim == 3 else data[None])


def skipped_note(columns: Collection[str], files: Collection[str]) -> str:
    """Return the sentence on ``columns`` of ``files`` that hold no sensor's data."""
    names = ", ".join(map(_quoted, columns))
    which = f"column {names} belongs" if len(columns) == 1 else f"columns {names} belong"
    return f"{', '.join(files)}: {which} to no sensor and no load and {'is' if len(columns) == 1 else 'are'} skipped"


def load_force(path: Path, key: str | None) -> FloatArray:
    """Return a load's values (time,); in a .csv file ``key`` names the column where there are several beside times."""
    if path.suffix == ".csv":
        return _load_force_csv(path, key)
    force = pick_array(load_arrays(path), key, str(path))
    if force.size != max(force.shape, default=0):
        raise InputError(f"{path}: shape {force.shape}; expected (time,), one value a sample")
    return force.ravel()


def _load_recording_csv(
    path: Path, sensors: Sequence[str], sampling_rate: float | None, loads: Collection[str]
) -> RecordingFile:
    table = load_csv(path)
    header = table.header
    times = time_column(header, [*sensors, *loads])
    asked = [*sensors, *loads, *([] if times is None else [header[times]])]
    has = ", ".join(map(_quoted, header))
    faults = [f"{path}: there is no column for sensor {name!r}; it has {has}" for name in sensors if name not in header]
    faults += _repeated(path, header, asked)
    columns = [header.index(name) for name in sensors if name in header]
    values = noting(faults, "", table.numbers, columns if times is None else [*columns, times])
    if values is not None and times is not None:
        faults += time_faults(values[:, -1], sampling_rate, f"{path}: its column {header[times]!r}")
    raise_faults(faults)
    assert values is not None  # else there were faults
    skipped = tuple(dict.fromkeys(name for name in header if name not in asked))
    return RecordingFile(values[None, :, : len(sensors)], skipped, table.form)


def _load_force_csv(path: Path, key: str | None) -> FloatArray:
    table = load_csv(path)
    header = table.header
    times = time_column(header, [] if key is None else [key])
    names = [name for column, name in enumerate(header) if column != times]
    if key is None and len(names) != 1:
        raise InputError(f"{path}: has the columns {', '.join(map(_quoted, names))}; say which with key")
    name = names[0] if key is None else key
    if name not in header:
        raise InputError(f"{path}: there is no column {name!r}; it has {', '.join(map(_quoted, header))}")
    raise_faults(_repeated(path, header, [name]))
    return table.numbers([header.index(name)])[:, 0]


def _repeated(path: Path, header: list[str], asked: Collection[str]) -> list[str]:
    """Return a fault for each column of ``asked`` that the ``header`` names twice."""
    twice = sorted({name for name in header if name in asked and header.count(name) > 1})
    return [f"{path}: column {name!r} appears twice" for name in twice]


def _quoted(name: str) -> str:
    return repr(name) if name else "one without a name"


def _step_faults(step: float, sampling_rate: float | None, what: str) -> list[str]:
    """Return a fault where the time step (s) stored in a file contradicts the stated sampling rate (Hz)."""
    if sampling_rate is None:
        return []
    rounded = step == float(f"{1 / sampling_rate:.2g}")
    if abs(step * sampling_rate - 1) <= (ROUNDED_TOLERANCE if rounded else STEP_TOLERANCE):
        return []
    rate = f" ({1 / step:g} Hz)" if step > 0 else ""
    return [f"{what} is {step:g} s{rate}, but sampling_rate says {sampling_rate:g} Hz"]
