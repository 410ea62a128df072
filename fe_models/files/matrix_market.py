"""Linear models named in a TOML file: of Matrix Market files, or of an .npz file with effects added to it.

See `matrices_file` for what the matrices are.

::

    schema = 1
    [matrices]
    mass = "M.mtx"
    stiffness = "K.mtx"
    damping = "C.mtx"             # optional
    nodes = "nodes.csv"           # header x,y or x,y,z; one line a node
    dofs = "dofs.csv"             # header node,direction; one line a row of the matrices
    modal_ratios = [0.01]         # optional: damping ratios of the modes, the last one going on
    rigid_links = [[1, 4]]        # optional: a leading node and one that follows it
    lines = "lines.csv"           # optional: header first,last; nodes between which pictures draw a line

    [[matrices.groups]]           # optional, for a diagnosis: groups of elements with their shares of K and M
    name = "storey 1"
    stiffness = "K_storey1.mtx"   # one of the two may be left out
    mass = "M_storey1.mtx"

    [[effects]]                   # optional: what the matrices lack; stiffness_change and mass_change of a group,
    kind = "stiffness_change"     # added_mass, support_spring, point_damper
    group = "storey 1"
    factor = 0.8

or, in place of all of ``[matrices]`` above, ``file = "model.npz"``.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from scipy.io import mminfo, mmread
from scipy.sparse import csr_array

from fe_models.arrays import FloatArray, IntArray
from fe_models.errors import InputError, noting, raise_faults
from fe_models.files.matrices_file import load_linear_model
from fe_models.files.matrix_parts import Dof, MatrixParts, assemble_model
from fe_models.files.size_limit import check_values, require_file
from fe_models.files.structure_parts import read_effects
from fe_models.files.tables import Table, check_keys, read_list, read_table
from fe_models.files.text_table import open_table
from fe_models.linear import LinearModel, MatrixGroup
from fe_models.matrix_effects import model_with_effects

LONGEST_NUMBER = 15  # digits of a node's number
NUMBERS_AN_ENTRY = 3  # of a sparse matrix: value, row and column


@dataclass(frozen=True)
class _MatricesTable:
    mass: str
    stiffness: str
    nodes: str
    dofs: str
    damping: str | None = None
    modal_ratios: tuple[float, ...] = ()
    rigid_links: tuple[tuple[int, int], ...] = ()
    lines: str | None = None


@dataclass(frozen=True)
class _FileTable:
    file: str


@dataclass(frozen=True)
class _GroupTable:
    name: str
    stiffness: str | None = None
    mass: str | None = None


def parse_matrices(document: Table, folder: Path, file_name: str) -> LinearModel:
    """Return the model whose files ``document`` names, relative to ``folder``, with its effects."""
    where, faults = f"{file_name}:", list[str]()
    check_keys(document, ["schema", "name", "matrices", "effects"], where, faults)
    read_table(_check_schema, {key: document[key] for key in ("schema",) if key in document}, where, faults)
    effects = [effect for _, effect in read_effects(document, where, faults) if effect is not None]
    table = document["matrices"]
    if isinstance(table, dict) and "file" in table:
        model = _of_file(table, folder, where, faults)
    else:
        model = _of_parts(table, folder, file_name, faults)
    if model is None:
        raise InputError(faults)
    raise_faults(faults)
    changed = noting(faults, where.removesuffix(":"), model_with_effects, model, *effects)
    if changed is None:
        raise InputError(faults)
    return changed


def _of_file(table: Table, folder: Path, where: str, faults: list[str]) -> LinearModel | None:
    row = read_table(_FileTable, table, f"{where} matrices", faults)
    return None if row is None else noting(faults, "", load_linear_model, folder / row.file)


def _of_parts(table: object, folder: Path, file_name: str, faults: list[str]) -> LinearModel | None:
    where = f"{file_name}: matrices"
    plain = {key: value for key, value in table.items() if key != "groups"} if isinstance(table, dict) else table
    row = read_table(_MatricesTable, plain, where, faults)
    if row is None:
        return None
    mass = noting(faults, "", _load_matrix, folder / row.mass)
    stiffness = noting(faults, "", _load_matrix, folder / row.stiffness)
    damping = noting(faults, "", _load_matrix, folder / row.damping) if row.damping else None
    nodes = noting(faults, "", _load_nodes, folder / row.nodes)
    dofs = noting(faults, "", _load_dofs, folder / row.dofs)
    lines = noting(faults, "", _load_lines, folder / row.lines) if row.lines else None
    groups = _groups(table if isinstance(table, dict) else {}, where, folder, mass, faults)
    if faults or mass is None or stiffness is None or nodes is None or dofs is None:
        return None
    parts = MatrixParts(
        mass,
        stiffness,
        nodes,
        dofs,
        damping,
        modal_ratios=np.array(row.modal_ratios) if row.modal_ratios else None,
        groups=groups,
        lines=lines,
        rigid_links=np.array(row.rigid_links) if row.rigid_links else None,
    )
    return noting(faults, "", assemble_model, file_name, parts)


def _groups(
    table: Table, where: str, folder: Path, mass: csr_array | None, faults: list[str]
) -> tuple[MatrixGroup, ...]:
    """Return the groups with their shares, as far as these can be read."""
    found, zero = [], csr_array((0, 0) if mass is None else mass.shape)
    for place, item in read_list(table, "groups", where, faults):
        row = read_table(_GroupTable, item, place, faults)
        if row is None:
            continue
        if row.stiffness is None and row.mass is None:
            faults.append(f"{place}: names neither stiffness nor mass, its shares of K and M")
        shares = [
            zero if file is None else noting(faults, place, _load_matrix, folder / file)
            for file in (row.mass, row.stiffness)
        ]
        present = [share for share in shares if share is not None]
        if len(present) == len(shares):
            found.append(MatrixGroup(row.name, *present))
    return tuple(found)


def _load_matrix(path: Path) -> csr_array:
    require_file(path)
    try:
        rows, columns, entries, form, *_ = mminfo(path)
        check_values(NUMBERS_AN_ENTRY * entries if form == "coordinate" else rows * columns, path)
        matrix = mmread(path)
    except InputError:
        raise
    except (ValueError, OverflowError, OSError) as error:
        raise InputError(f"{path}: not a readable Matrix Market file ({error})") from None
    if matrix.dtype.kind not in "iuf":
        raise InputError(f"{path}: entries are {matrix.dtype}, not real numbers")
    return csr_array(matrix, dtype=float)


def _load_nodes(path: Path) -> FloatArray:
    table = open_table(path)
    if not {"x", "y"} <= set(table.header):
        raise InputError(f"{path}: expected the columns x,y (m), in space also z, found {','.join(table.header)}")
    return table.numbers([table.header.index(axis) for axis in ("x", "y", "z") if axis in table.header])


def _load_lines(path: Path) -> IntArray:
    table = open_table(path)
    if not {"first", "last"} <= set(table.header):
        raise InputError(f"{path}: expected the columns first,last, found {','.join(table.header)}")
    values = table.numbers([table.header.index("first"), table.header.index("last")])
    if not np.isfinite(values).all() or (values != values.round()).any():
        raise InputError(f"{path}: holds numbers that are no numbers of nodes")
    return values.astype("int64")


def _load_dofs(path: Path) -> list[Dof]:
    table = open_table(path)
    if not {"node", "direction"} <= set(table.header):
        raise InputError(f"{path}: expected the columns node,direction, found {','.join(table.header)}")
    node_column, direction_column = table.header.index("node"), table.header.index("direction")
    cells = [(line, row[node_column], row[direction_column]) for line, row in table.rows()]
    raise_faults(
        f"{path}: line {line}: {node!r} is not a node number" for line, node, _ in cells if not _is_number(node)
    )
    return [(int(node), direction) for _, node, direction in cells]


def _is_number(node: str) -> bool:
    return node.isdecimal() and len(node) <= LONGEST_NUMBER


def _check_schema(schema: Literal[1]) -> None:
    """Only to check the key of that name."""
