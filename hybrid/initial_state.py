"""An initial state that the user gives at some nodes, as modal coordinates and velocities."""

import csv
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fe_models.dofs import FloatArray
from fe_models.errors import InputError, raise_faults
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
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            table = list(csv.DictReader(file))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise InputError(f"{path}: cannot be read as CSV ({error})") from error
    if not table or set(table[0]) != set(COLUMNS):
        found = ", ".join(map(str, table[0])) if table else "no rows"
        raise InputError(f"{path}: expected a header {','.join(COLUMNS)} and at least one row; found {found}")
    faults: list[str] = []
    rows, displacement, velocity = [], [], []
    for line, entry in enumerate(table, start=2):
        try:
            rows.append(modal.dofs.row(int(entry["node"]), entry["direction"].strip()))
            displacement.append(float(entry["displacement"]))
            velocity.append(float(entry["velocity"]))
        except KeyError as error:
            faults.append(f"{path}: line {line}: {error.args[0]}")
        except (ValueError, TypeError, AttributeError):
            faults.append(f"{path}: line {line}: expected a whole number, a direction and two numbers")
    if not faults and not np.isfinite([displacement, velocity]).all():
        faults.append(f"{path}: holds values that are not finite")
    raise_faults(faults)
    return NodalState(tuple(rows), np.array(displacement), np.array(velocity))


def modal_state(state: NodalState, modal: ModalModel) -> tuple[FloatArray, FloatArray]:
    """Return q and q' (mode,) that fit the nodal state best: least squares, the smallest where several fit.

    "Smallest" is meant in strain energy, sum of (omega q)^2: of all shapes through the given points, the one that
    takes the least force.
    """
    shapes = modal.shapes[list(state.rows)] / modal.omega  # (row, mode), for omega q
    q = np.linalg.lstsq(shapes, state.displacement, rcond=1e-9)[0] / modal.omega
    q_dot = np.linalg.lstsq(shapes * modal.omega, state.velocity, rcond=1e-9)[0]
    return np.asarray(q, dtype=float), np.asarray(q_dot, dtype=float)
