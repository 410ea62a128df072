"""Linear models from Matrix Market files, named in a TOML file; see `matrices_file` for what the matrices are.

::

    schema = 1
    [matrices]
    mass = "M.mtx"
    stiffness = "K.mtx"
    damping = "C.mtx"      # optional
    nodes = "nodes.csv"    # header x,y; one line a node
    dofs = "dofs.csv"      # header node,direction; one line a row of the matrices
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from scipy.io import mmread
from scipy.sparse import csr_array

from fe_models.arrays import FloatArray
from fe_models.errors import InputError, noting, raise_faults
from fe_models.files.matrices_file import Dof, assemble_model
from fe_models.files.tables import Table, check_keys, read_table
from fe_models.files.text_table import open_table
from fe_models.linear import LinearModel


@dataclass(frozen=True)
class _MatricesTable:
    mass: str
    stiffness: str
    nodes: str
    dofs: str
    damping: str | None = None


def parse_matrices(document: Table, folder: Path, file_name: str) -> LinearModel:
    """Return the model whose Matrix Market files ``document`` names, relative to ``folder``."""
    where, faults = f"{file_name}:", list[str]()
    check_keys(document, ["schema", "name", "matrices"], where, faults)
    read_table(_check_schema, {key: document[key] for key in ("schema",) if key in document}, where, faults)
    table = read_table(_MatricesTable, document["matrices"], f"{where} matrices", faults)
    if table is None:
        raise InputError(faults)
    mass = noting(faults, "", _load_matrix, folder / table.mass)
    stiffness = noting(faults, "", _load_matrix, folder / table.stiffness)
    damping = noting(faults, "", _load_matrix, folder / table.damping) if table.damping else None
    nodes = noting(faults, "", _load_nodes, folder / table.nodes)
    dofs = noting(faults, "", _load_dofs, folder / table.dofs)
    if faults or mass is None or stiffness is None or nodes is None or dofs is None:
        raise InputError(faults)
    return assemble_model(file_name, mass, damping, stiffness, nodes, dofs, dofs)


def _load_matrix(path: Path) -> csr_array:
    try:
        matrix = mmread(path)
    except FileNotFoundError:
        raise InputError(f"{path}: no such file") from None
    except (ValueError, OverflowError, OSError) as error:
        raise InputError(f"{path}: not a readable Matrix Market file ({error})") from None
    if matrix.dtype.kind not in "iuf":
        raise InputError(f"{path}: entries are {matrix.dtype}, not real numbers")
    return csr_array(matrix, dtype=float)


def _load_nodes(path: Path) -> FloatArray:
    table = open_table(path)
    if not {"x", "y"} <= set(table.header):
        raise InputError(f"{path}: expected the columns x,y (m), found {','.join(table.header)}")
    return table.numbers([table.header.index("x"), table.header.index("y")])


def _load_dofs(path: Path) -> list[Dof]:
    table = open_table(path)
    if not {"node", "direction"} <= set(table.header):
        raise InputError(f"{path}: expected the columns node,direction, found {','.join(table.header)}")
    node_column, direction_column = table.header.index("node"), table.header.index("direction")
    cells = [(line, row[node_column], row[direction_column]) for line, row in table.rows()]
    raise_faults(
        f"{path}: line {line}: {node!r} is not a node number" for line, node, _ in cells if not node.isdecimal()
    )
    return [(int(node), direction) for _, node, direction in cells]


def _check_schema(schema: Literal[1]) -> None:
    """Only to check the key of that name."""
