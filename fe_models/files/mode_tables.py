"""The tables ``[[modes]]`` of a dataset file: modes that somebody identified, one table a mode.

::

    [[modes]]
    recording = "before"                  # the state it belongs to
    frequency = 3.866                     # Hz
    frequency_std = 0.01                  # Hz; this and all that follows is optional
    damping_ratio = 0.003
    damping_std = 0.0005
    shape = [-0.02, 0.19, 0.71, 1.0]      # at the sensors, in SI, on any one scale; complex: [[re, im], ...]
    shape_std = 0.02                      # of each component, on the same scale
    role = "train"                        # "train" (default) or "test", the same in all modes of a recording
"""

from collections.abc import Iterable
from dataclasses import dataclass, fields
from typing import Any, Literal

import numpy as np

from fe_models.arrays import ComplexArray, FloatArray
from fe_models.files.recording_checks import HIGHEST_RATE, LOWEST_RATE
from fe_models.files.tables import Table, at, read_list, read_table
from fe_models.mode_estimate import ModeEstimate
from fe_models.recordings import Recording

ShapeTable = tuple[float | tuple[float, float], ...]


@dataclass(frozen=True)
class _ModeTable:
    recording: str
    frequency: float
    frequency_std: float | None = None
    damping_ratio: float | None = None
    damping_std: float | None = None
    shape: ShapeTable | None = None
    shape_std: float | None = None
    role: Literal["train", "test"] = "train"


def read_modes(document: Table, where: str, channels: list[str], faults: list[str]) -> tuple[ModeEstimate, ...]:
    """Return the modes that could be read; ``channels``: names of all sensors. Adds what is wrong to ``faults``."""
    modes = []
    for place, table in read_list(document, "modes", where, faults):
        row = read_table(_ModeTable, table, place, faults)
        if row is None:
            continue
        faults.extend(f"{place}: {fault}" for fault in _faults(row, table, len(channels)))
        values = vars(row) | {"shape": None if row.shape is None else _shape(row.shape)}
        modes.append(ModeEstimate(**values))
    return tuple(modes)


def check_states(
    modes: tuple[ModeEstimate, ...], recordings: Iterable[Recording], where: str, faults: list[str]
) -> None:
    """Add a fault for each recording with two roles, and where nothing can be fitted."""
    roles: dict[str, set[str]] = {}
    for each in modes:
        roles.setdefault(each.recording, set()).add(each.role)
    for recording in recordings:
        if recording.name in roles:
            roles[recording.name].add(recording.role)
    for name, found in roles.items():
        if len(found) > 1:
            faults.append(
                f'{at(where, "modes")}: {name!r} has the role "train" in one place and "test" in another; give it one'
            )
    if modes and all(found == {"test"} for found in roles.values()):
        faults.append(f'{at(where, "modes")}: none has the role "train"; at least one is needed to fit a model to')


def mode_row(mode: ModeEstimate) -> Table:
    """Return the table of a mode, without what is unknown or usual."""
    values: Table = {item.name: getattr(mode, item.name) for item in fields(mode)}
    row = {key: value for key, value in values.items() if value is not None and (key, value) != ("role", "train")}
    if mode.shape is not None:
        row["shape"] = _shape_row(mode.shape)
    return row


def _faults(row: _ModeTable, table: Table, sensors: int) -> list[str]:
    """Return faults of what could be read of a ``table``; ``sensors``: how many there are, 0 where that is a fault."""
    faults = []
    if row.frequency <= 0:
        faults.append(f"frequency = {row.frequency:g} Hz; must be positive")
    elif not LOWEST_RATE <= row.frequency <= HIGHEST_RATE:
        faults.append(f"frequency = {row.frequency:g} Hz; expected {LOWEST_RATE:g} to {HIGHEST_RATE:g} Hz")
    if row.damping_ratio is not None and not 0 <= row.damping_ratio < 1:
        faults.append(f"damping_ratio = {row.damping_ratio:g}; expected 0 <= ratio < 1 (0.01 is 1 %)")
    stds = {"frequency": row.frequency_std, "damping_ratio": row.damping_std, "shape": row.shape_std}
    for key, std in stds.items():
        name = f"{key.removesuffix('_ratio')}_std"
        if std is not None and std <= 0:
            faults.append(f"{name} = {std:g}; must be positive; leave it out where it is unknown")
        if std is not None and key not in table:
            faults.append(f"{name} stands without {key}: give both, or neither")
    if row.shape is not None and sensors and len(row.shape) != sensors:
        faults.append(f"shape has {len(row.shape)} values for {sensors} sensors; give one a sensor, in their order")
    if row.shape and not np.any(_shape(row.shape)):
        faults.append("shape is zero everywhere; leave it out where it is unknown")
    return faults


def _shape(values: ShapeTable) -> FloatArray | ComplexArray:
    """Return a shape, complex where any of its components is."""
    if any(isinstance(value, tuple) for value in values):
        return np.array([complex(*value) if isinstance(value, tuple) else complex(value) for value in values])
    return np.array(values, dtype=float)


def _shape_row(shape: FloatArray | ComplexArray) -> list[Any]:
    if np.iscomplexobj(shape):
        return [[float(value.real), float(value.imag)] for value in shape]
    return [float(value) for value in shape]
