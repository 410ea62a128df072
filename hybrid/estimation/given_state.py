"""An initial state that the user gives at some nodes, as modal coordinates and velocities."""

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.dof_map import DofMap
from fe_models.errors import InputError, noting, raise_faults
from fe_models.files.recording_checks import LARGEST_SIGNAL
from fe_models.files.size_limit import check_bytes, require_file
from fe_models.linear import ModalModel

COLUMNS = ("node", "direction", "displacement", "velocity")


@dataclass(frozen=True)
class NodalState:
    """Displacements and velocities (row,) in m and m/s (rad and rad/s for "rz") at some degrees of freedom.

    ``rows``: the numbers of these in a vector over all degrees of freedom.
    """

    rows: tuple[int, ...]
    displacement: FloatArray
    velocity: FloatArray


def read_nodal_state(path: Path, modal: ModalModel) -> NodalState:
    """Read a CSV file with the columns node, direction, displacement and velocity; `InputError` with all its faults."""
    require_file(path)
    check_bytes(path.stat().st_size, path)
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.reader(file)
            table = [(reader.line_num, [cell.strip() for cell in row]) for row in reader if any(row)]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path}: cannot be read as CSV ({error})") from error
    header = table[0][1] if table else []
    if len(table) < 2 or sorted(header) != sorted(COLUMNS):
        found = ",".join(header) + (" and no row" if len(table) == 1 else "") if table else "nothing"
        raise InputError(f"{path}: expected a header {','.join(COLUMNS)} and at least one row; found {found}")
    faults: list[str] = []
    state: dict[int, tuple[float, float]] = {}
    for line, cells in table[1:]:
        entry = noting(faults, f"{path}: line {line}", _read_row, header, cells, modal.dofs)
        if entry is None:
            continue
        if entry[0] in state:
            faults.append(f"{path}: line {line}: node and direction were given before; give each once")
        state[entry[0]] = entry[1:]
    raise_faults(faults)
    displacement, velocity = np.array(list(state.values())).T
    return NodalState(tuple(state), displacement, velocity)


def _read_row(header: list[str], cells: list[str], dofs: DofMap) -> tuple[int, float, float]:
    """Return a row's number in a vector over all degrees of freedom, its displacement and its velocity."""
    entry = dict(zip(header, cells, strict=False))
    try:
        if len(cells) != len(header):
            raise ValueError
        node, direction = int(entry["node"]), entry["direction"]
        displacement, velocity = float(entry["displacement"]), float(entry["velocity"])
    except ValueError:
        what = "a whole number, a direction and two numbers with decimal points"
        raise InputError(f"expected {what}, found {','.join(cells)}") from None
    if not all(abs(value) <= LARGEST_SIGNAL for value in (displacement, velocity)):  # nor is it a number then
        raise InputError(f"holds values that are not finite, or beyond {LARGEST_SIGNAL:g} in SI units")
    try:
        row = dofs.row(node, direction)
    except KeyError as error:
        raise InputError(str(error.args[0])) from None
    if not dofs.free[row] and (displacement or velocity):
        raise InputError(f"node {node} is held in {direction} by a support: it cannot move")
    return row, displacement, velocity


def modal_state(state: NodalState, modal: ModalModel) -> tuple[FloatArray, FloatArray]:
    """Return q and q' (mode,) that fit the nodal state best: least squares, the smallest where several fit.

    "Smallest" is meant in strain energy, sum of (omega q)^2: of all shapes through the given points, the one that
    takes the least force.
    """
    shapes = modal.shapes[list(state.rows)] / modal.omega  # (row, mode), for omega q
    q = np.linalg.lstsq(shapes, state.displacement, rcond=1e-9)[0] / modal.omega
    q_dot = np.linalg.lstsq(shapes * modal.omega, state.velocity, rcond=1e-9)[0]
    return np.asarray(q, dtype=float), np.asarray(q_dot, dtype=float)
