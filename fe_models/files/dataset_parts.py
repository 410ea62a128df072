"""The parts of a dataset file, read one by one, so that a fault in one leaves the others to be checked.

Each function adds to ``faults`` what it finds.
"""

from dataclasses import dataclass, fields
from math import inf
from pathlib import Path
from typing import Literal

from fe_models.directions import axis_and_sign
from fe_models.dof_map import DofMap
from fe_models.errors import noting
from fe_models.files.modal_file import load_modal_model
from fe_models.files.recording_checks import (
    READS_ZERO,
    check_place,
    check_rates,
    check_sensor,
    check_sensors,
    to_si,
)
from fe_models.files.tables import Table, at, check_keys, read_list, read_table
from fe_models.recordings import TOLERANCE, Assumptions, Sensor, Uncertainty
from fe_models.structure import Direction


@dataclass(frozen=True)
class DatasetHeader:
    """The single values of a dataset file; an infinite ``sampling_rate`` (Hz) where it has none."""

    schema: Literal[1]
    model: str
    sampling_rate: float = inf
    lowpass: float | None = None


HEADER_KEYS = tuple(item.name for item in fields(DatasetHeader))


@dataclass(frozen=True)
class Surroundings:
    """What the parts are checked against; None where the model or the rates (Hz) have faults themselves.

    ``dead_channels``: whether a channel that never changes is no fault.
    """

    folder: Path
    dofs: DofMap | None
    node_count: int
    sampling_rate: float | None
    lowpass: float | None
    dead_channels: bool = False


@dataclass(frozen=True)
class _Rates:
    sampling_rate: float = inf  # where it cannot be read, any low-pass is below half of it
    lowpass: float | None = None


@dataclass(frozen=True)
class _Place:
    node: int
    direction: Direction


@dataclass(frozen=True)
class _SimulationTable:
    damping_ratio: float | tuple[float, ...] | None = None
    modes: int | None = None
    modal_model: str | None = None
    integrator: Literal["exact", "newmark"] = "exact"
    step: float | None = None
    tolerance: float = TOLERANCE


def read_header(document: Table, where: str, faults: list[str]) -> DatasetHeader | None:
    """Return the single values, with the two frequencies checked against each other.

    Of identified modes alone a sampling rate is not asked for, nor where every recording has its own.
    """
    table = {key: document[key] for key in HEADER_KEYS if key in document}
    own = _rates_of_recordings(document)
    if own and None not in own:
        table.setdefault("sampling_rate", own[0])
    required = () if modes_alone(document) else ("sampling_rate",)
    header = read_table(DatasetHeader, table, where, faults, required)
    rates = {key: table[key] for key in ("sampling_rate", "lowpass") if key in table}
    readable = read_table(_Rates, rates, where, []) or _Rates()
    faults.extend(f"{where} {fault}" for fault in check_rates(readable.sampling_rate, readable.lowpass))
    return header


def _rates_of_recordings(document: Table) -> list[object]:
    """Return the sampling rate that each recording's table states, None where it has none."""
    tables = [table for _, table in read_list(document, "recordings", "", [])]
    return [table.get("sampling_rate") if isinstance(table, dict) else None for table in tables]


def modes_alone(document: Table) -> bool:
    """Return whether a dataset file has identified modes and no recordings."""
    return bool(document.get("modes")) and not document.get("recordings")


@dataclass(frozen=True)
class Channels:
    """The ``names`` of all channels in their order, and the ``factors`` that bring each from its unit to SI."""

    names: tuple[str, ...]
    factors: tuple[float, ...]
    units: tuple[str, ...]


def read_sensors(
    document: Table, where: str, surroundings: Surroundings, faults: list[str]
) -> tuple[tuple[Sensor, ...], Channels]:
    """Return the sensors that could be read, in SI, and all channels, read or not."""
    sensors: list[Sensor] = []
    channels: list[str] = []
    factors: list[float] = []
    units: list[str] = []
    for place, table in read_list(document, "sensors", where, faults):
        table, sign = _along_an_axis(table, place, faults)
        sensor = read_table(Sensor, table, place, faults)
        name = table.get("name") if isinstance(table, dict) else None
        channels.append(name if isinstance(name, str) else f"number {len(channels) + 1}")
        units.append("1" if sensor is None else sensor.unit)
        if sensor is None:
            faults.extend(f"{place}: {fault}" for fault in _misplaced(table, surroundings))
            factors.append(1.0)
        else:
            sensor, factor = to_si(sensor)
            factors.append(sign * factor)
            found = check_sensor(sensor, surroundings.dofs, surroundings.node_count)
            faults.extend(f"{place} ({sensor.name}): {fault}" for fault in found)
            sensors.append(sensor)
    if not channels:
        faults.append(f"{at(where, 'sensors')}: there are none; give one [[sensors]] table a channel")
    elif len(sensors) == len(channels):
        faults.extend(f"{where} {fault}" for fault in check_sensors(sensors))
    return tuple(sensors), Channels(tuple(channels), tuple(factors), tuple(units))


def _along_an_axis(table: object, place: str, faults: list[str]) -> tuple[object, float]:
    """Return a sensor's table with an angle or a vector along an axis as that axis, and -1 where it points back."""
    direction = table.get("direction") if isinstance(table, dict) else None
    if not isinstance(table, dict) or not isinstance(direction, int | float | list) or isinstance(direction, bool):
        return table, 1.0
    given = tuple(direction) if isinstance(direction, list) else direction
    known = noting(faults, f"{place}.direction", axis_and_sign, given)
    axis, sign = ("x", 1.0) if known is None else known
    return table | {"direction": list(axis) if isinstance(axis, tuple) else axis}, sign


def _misplaced(table: object, surroundings: Surroundings) -> list[str]:
    """Return what is wrong with the place of a sensor whose table is wrong otherwise, as far as it can be read."""
    known = {key: table[key] for key in ("node", "direction") if key in table} if isinstance(table, dict) else {}
    place = read_table(_Place, known, "", [])
    if place is None or surroundings.dofs is None:
        return []
    return check_place(place.node, place.direction, surroundings.dofs, surroundings.node_count, READS_ZERO)


def read_assumptions(document: Table, where: str, surroundings: Surroundings, faults: list[str]) -> Assumptions:
    """Return what the user's own simulation assumes."""
    place, table = at(where, "simulation"), document.get("simulation", {})
    plain = table
    if isinstance(table, dict):
        own = [item.name for item in fields(_SimulationTable)]
        check_keys(table, [*own, "uncertainty"], place, faults)
        plain = {key: value for key, value in table.items() if key in own}
    row = read_table(_SimulationTable, plain, place, faults) or _SimulationTable()
    given = table.get("uncertainty", {}) if isinstance(table, dict) else {}
    uncertainty = read_table(Uncertainty, given, f"{place}.uncertainty", faults) or Uncertainty()
    faults.extend(f"{place}.{fault}" for fault in _simulation_faults(row, uncertainty, surroundings))
    modal_model = None
    if row.modal_model is not None and surroundings.dofs is not None:
        path = surroundings.folder / row.modal_model
        modal_model = noting(faults, f"{place}.modal_model", load_modal_model, path, surroundings.dofs)
    return Assumptions(row.damping_ratio, row.modes, modal_model, row.integrator, row.step, uncertainty, row.tolerance)


def _simulation_faults(row: _SimulationTable, uncertainty: Uncertainty, surroundings: Surroundings) -> list[str]:
    faults = []
    ratios = row.damping_ratio if isinstance(row.damping_ratio, tuple) else (row.damping_ratio or 0.0,)
    if not ratios or any(not 0 <= ratio < 1 for ratio in ratios):
        faults.append(f"damping_ratio: {row.damping_ratio} is none; expected 0 <= ratio < 1 (0.01 is 1 %)")
    if row.modes is not None and row.modes < 1:
        faults.append(f"modes = {row.modes}; must be 1 or more")
    if row.modes is not None and surroundings.dofs is not None and row.modes > len(surroundings.dofs.free_rows):
        faults.append(f"modes = {row.modes}; the model has only {len(surroundings.dofs.free_rows)}")
    if row.modes is not None and isinstance(row.damping_ratio, tuple) and len(ratios) != row.modes:
        faults.append(f"damping_ratio: {len(ratios)} ratios for modes = {row.modes}; give one a mode, or one number")
    if row.step is not None and row.step <= 0:
        faults.append(f"step = {row.step:g} s; must be positive")
    if row.tolerance <= 0:
        faults.append(f"tolerance = {row.tolerance:g}; must be positive (0.05 is 5 % of the noise floor)")
    for name, value in vars(uncertainty).items():
        if value < 0:
            faults.append(f"uncertainty.{name} = {value:g}; must not be negative")
    return faults
