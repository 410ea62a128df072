"""What is known to have moved the structure in a recording: loads, and the motion of its base."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.base_motion import BaseDirection, BaseMotion, rigid_motion, unit_vector
from fe_models.directions import AnyDirection, components
from fe_models.dof_map import DofMap
from fe_models.errors import noting
from fe_models.files.recording_checks import UNITS, UNITS_BESIDE, check_place, size_faults
from fe_models.files.recording_files import load_force
from fe_models.files.tables import Table, read_list, read_table
from fe_models.recordings import Excitation, Load
from fe_models.structure import ROTATIONS

KNOWN_MOTION = ("loads", "base")
"""Lists in the table of a recording of what is known to have moved the structure."""
SI_UNIT = UNITS["acceleration", False]
BASE_UNITS = {SI_UNIT: 1.0} | UNITS_BESIDE["acceleration", False]
"""Units that a base motion may have, each with what one of it is in m/s^2."""


NO_EFFECT = "the load would do nothing"  # at a place that a support holds


@dataclass(frozen=True)
class Checked:
    """What is checked: files in a ``folder``, places among ``dofs`` (None where the model could not be read), and as
    many values as there are ``samples`` (None where the recording could not be read).
    """

    folder: Path
    dofs: DofMap | None
    node_count: int
    samples: int | None


@dataclass(frozen=True)
class _LoadTable:
    node: int
    direction: AnyDirection
    file: str
    key: str | None = None


@dataclass(frozen=True)
class _BaseTable:
    direction: BaseDirection | str  # as text, so that the fault says all that it may be
    file: str
    key: str | None = None
    unit: str = SI_UNIT


def named_columns(tables: list[object]) -> set[tuple[str, str]]:
    """Return the files, each with the name of an array or a column in it, that loads and base motions name."""
    items = [
        item
        for table in tables
        if isinstance(table, dict)
        for key in KNOWN_MOTION
        for _, item in read_list(table, key, "", [])
    ]
    named = [(item.get("file"), item.get("key")) for item in items if isinstance(item, dict)]
    return {(file, key) for file, key in named if isinstance(file, str) and isinstance(key, str)}


def read_known_motion(
    table: Table, place: str, checked: Checked, faults: list[str]
) -> tuple[tuple[Load, ...], tuple[BaseMotion, ...]]:
    """Return the loads and the base motions in the ``table`` of a recording, noting the faults of others."""
    loads = (_read_load(item, where, checked, faults) for where, item in read_list(table, "loads", place, faults))
    base = (_read_base(item, where, checked, faults) for where, item in read_list(table, "base", place, faults))
    return tuple(load for parts in loads for load in parts), tuple(motion for motion in base if motion is not None)


def excitation_faults(excitation: Excitation | None, table: Table) -> list[str]:
    """Return what contradicts the stated ``excitation`` in the table of a recording."""
    known = [key for key in KNOWN_MOTION if table.get(key)]
    if excitation == "measured" and not known:
        keys = " or ".join(f"[[recordings.{key}]]" for key in KNOWN_MOTION)
        return [f'excitation = "measured", but nothing says what was: name it in {keys}']
    if excitation not in (None, "measured") and known:
        return [f'excitation = "{excitation}" contradicts its {known[0]}; leave it out, or say "measured"']
    return []


def _read_load(item: object, where: str, checked: Checked, faults: list[str]) -> tuple[Load, ...]:
    """Return a load, or its two components where it acts between x and y."""
    row = read_table(_LoadTable, item, where, faults)
    along = None if row is None else noting(faults, where, components, row.direction)
    if row is None or along is None:
        return ()
    if checked.dofs is not None:
        found = [check_place(row.node, axis, checked.dofs, checked.node_count, NO_EFFECT) for axis in along]
        if all(found):  # a support may well take one of two components
            faults.extend(f"{where}: {fault}" for fault in dict.fromkeys(fault for each in found for fault in each))
        along = {axis: part for (axis, part), wrong in zip(along.items(), found, strict=True) if not wrong}
    values = _read_values(row.file, row.key, "N m" if row.direction in ROTATIONS else "N", where, checked, faults)
    return () if values is None else tuple(Load(row.node, axis, part * values) for axis, part in along.items())


def _read_base(item: object, where: str, checked: Checked, faults: list[str]) -> BaseMotion | None:
    row = read_table(_BaseTable, item, where, faults)
    if row is None:
        return None
    along = noting(faults, where, unit_vector, row.direction)
    if (
        along is not None
        and checked.dofs is not None
        and not rigid_motion(checked.dofs, along)[checked.dofs.free].any()
    ):
        faults.append(f"{where}: no node of this model moves in direction {row.direction!r}; the base would do nothing")
    if row.unit not in BASE_UNITS:
        faults.append(f"{where}: unit {row.unit!r} is none of an acceleration; expected {' or '.join(BASE_UNITS)}")
    values = _read_values(row.file, row.key, row.unit, where, checked, faults)
    if along is None or values is None or row.unit not in BASE_UNITS:
        return None
    return BaseMotion(row.direction, BASE_UNITS[row.unit] * values)  # type: ignore[arg-type]  # `unit_vector` knows it


def _read_values(
    file: str, key: str | None, unit: str, where: str, checked: Checked, faults: list[str]
) -> FloatArray | None:
    """Return the values in a file, in ``unit`` where it states its own; NaN where they were lost."""
    values = noting(faults, where, load_force, checked.folder / file, key, unit)
    if values is None:
        return None
    if checked.samples is not None and len(values) != checked.samples:
        faults.append(f"{where}: {file}: {len(values)} values for {checked.samples} samples; one a sample is needed")
    if np.isinf(values).any():
        faults.append(f"{where}: {file}: holds infinite values")
    wrong = size_faults(values[:, None], [f"{where}: {file}"])
    faults.extend(wrong)
    return None if wrong else values
