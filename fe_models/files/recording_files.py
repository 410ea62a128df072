"""The arrays of recordings and loads, read from .npz, .mat or .csv and brought to the shapes of `recordings`."""

from pathlib import Path

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.errors import InputError, raise_faults
from fe_models.files.array_files import load_arrays, load_csv, pick_array

JUMP = 0.5  # of a step: rounded times are off by less
MOST_TOLD = 3  # jumps of time, each with its place
STEP_TOLERANCE = 0.01  # a stored time step is often rounded to two or three digits
STEP_NAME = "dt"
TIME_COLUMN = "time"
TIMELIKE = ("t", "time", "time (s)", "time [s]", "t (s)", "t [s]", "time_s", "seconds")  # as loggers call it


def load_recording(path: Path, key: str | None, sensors: list[str], sampling_rate: float | None) -> FloatArray:
    """Return (realisation, time, sensor), channels in the order of ``sensors``; `InputError` carries all faults.

    A .csv file has the sensors' names as its header, in any order, and may have a column "time" (s). A time step "dt"
    (s) beside the array, or that column, must agree with ``sampling_rate`` (Hz).
    """
    if path.suffix == ".csv":
        return _load_recording_csv(path, sensors, sampling_rate)
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
    return data if data.ndim == 3 else data[None]


def load_force(path: Path, key: str | None) -> FloatArray:
    """Return a load's values (time,); in a .csv file ``key`` names the column where there are several."""
    if path.suffix == ".csv":
        header, values = load_csv(path)
        force = pick_array({name: values[:, column] for column, name in enumerate(header)}, key, str(path))
    else:
        force = pick_array(load_arrays(path), key, str(path))
    if force.size != max(force.shape, default=0):
        raise InputError(f"{path}: shape {force.shape}; expected (time,), one value a sample")
    return force.ravel()


def _load_recording_csv(path: Path, sensors: list[str], sampling_rate: float | None) -> FloatArray:
    header, values = load_csv(path)
    expected = ", ".join(sensors)
    unknown = [name for name in header if name not in sensors and name != TIME_COLUMN]
    hints = {name: f"; a column of time (s) is called {TIME_COLUMN!r}" for name in unknown if name.lower() in TIMELIKE}
    faults = [f"{path}: column {name!r} is no sensor; expected {expected}{hints.get(name, '')}" for name in unknown]
    faults += [f"{path}: there is no column for sensor {name!r}" for name in sensors if name not in header]
    faults += [f"{path}: column {name!r} appears twice" for name in sorted(set(header)) if header.count(name) > 1]
    if TIME_COLUMN in header and TIME_COLUMN not in sensors and len(values) > 1:
        time = values[:, header.index(TIME_COLUMN)]
        step = float(np.median(np.diff(time)))
        faults += _step_faults(step, sampling_rate, f"{path}: the step of its column {TIME_COLUMN!r}")
        faults += _jump_faults(time, step, path)
    raise_faults(faults)
    return values[None][:, :, [header.index(name) for name in sensors]]


def _jump_faults(time: FloatArray, step: float, path: Path) -> list[str]:
    """Return a fault where ``time`` (sample,) does not go on by one ``step`` each, as where samples were lost."""
    jumps = np.flatnonzero(np.abs(np.diff(time) - step) > JUMP * abs(step))
    told = ", ".join(f"from {time[i]:g} to {time[i + 1]:g} s" for i in jumps[:MOST_TOLD])
    more = f" and at {len(jumps) - MOST_TOLD} more places" if len(jumps) > MOST_TOLD else ""
    words = "give a recording without gaps, or each part as a recording of its own"
    return [f"{path}: its column {TIME_COLUMN!r} jumps {told}{more}: {words}"] if len(jumps) else []


def _step_faults(step: float, sampling_rate: float | None, what: str) -> list[str]:
    """Return a fault where the time step (s) found in a file contradicts the stated sampling rate (Hz)."""
    if sampling_rate is None or abs(step * sampling_rate - 1) <= STEP_TOLERANCE:
        return []
    rate = f" ({1 / step:g} Hz)" if step > 0 else ""
    return [f"{what} is {step:g} s{rate}, but sampling_rate says {sampling_rate:g} Hz"]
