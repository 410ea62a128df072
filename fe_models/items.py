"""Matrices of equal items, which Exudyn linearises once, and their sparse sum over a structure.

    M = sum_e B_e^T M_e B_e, likewise C and K, with B_e picking the element's degrees of freedom.

Elements with equal section, length and orientation have equal matrices, so that a structure of 100,000 degrees of
freedom costs Exudyn no more than the drawn one, and no full matrix is ever formed.
"""

from collections import defaultdict
from collections.abc import Hashable, Iterable
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.sparse import coo_array, csr_array

from fe_models.arrays import FloatArray, IntArray
from fe_models.cables import is_slack
from fe_models.dof_map import DofMap
from fe_models.mesh import Mesh, mesh
from fe_models.structure import Beam, Cable, Direction, PointMass, Spring, Structure

if TYPE_CHECKING:
    from fe_models.exudyn.item_matrices import ElementMatrices
    from fe_models.exudyn.items import Item, Options

    PlacedItem = tuple[Item, tuple[int, ...], FloatArray]

Group = tuple["ElementMatrices", IntArray]
"""Matrices (n, n) of equal items, and the rows (item, n) of their degrees of freedom."""


def equal_items(structure: Structure, parts: Mesh, state: FloatArray | None) -> list[Group]:
    """Return the matrices of each different item of the structure, and where its copies sit."""
    from fe_models.exudyn.item_matrices import items_of  # loads Exudyn only where it is needed

    return matrices_of(structure, items_of(structure, parts), state)


def matrices_of(structure: Structure, items: "Iterable[PlacedItem]", state: FloatArray | None) -> list[Group]:
    """Return the matrices of each different one of ``items`` (item, mesh nodes, vector), and where its copies sit."""
    from fe_models.exudyn.item_matrices import ElementMatrices  # loads Exudyn only where it is needed
    from fe_models.exudyn.items import Options

    options = Options(damping=structure.damping, prestress=state is not None, slack=False)
    per_node = len(structure.directions)
    matrices: dict[Hashable, ElementMatrices] = {}
    rows_of: dict[Hashable, list[list[int]]] = defaultdict(list)
    for item, nodes, vector in items:
        rows = [per_node * (node - 1) + i for node in nodes for i in range(per_node)]
        moved = None if state is None else state[rows]
        alike, bits = _without_place(item), None if moved is None else moved.tobytes()
        key = (alike, *vector, bits)
        if key not in matrices:
            matrices[key] = _linearised(structure.directions, alike, vector.tobytes(), options, bits)
            if moved is not None and isinstance(item, Cable) and is_slack(item, vector, moved):
                matrices[key] = ElementMatrices(matrices[key].mass, *np.zeros((2, len(rows), len(rows))))
        rows_of[key].append(rows)
    return [(matrices[key], np.array(rows, dtype=np.int64)) for key, rows in rows_of.items()]


@lru_cache(maxsize=4096)
def _linearised(
    directions: tuple[Direction, ...], item: "Item", vector: bytes, options: "Options", moved: bytes | None
) -> "ElementMatrices":
    """Return the matrices of one item, kept for all structures that have an equal one; arrays come as their bits."""
    from fe_models.exudyn.item_matrices import element_matrices

    found = element_matrices(
        directions, item, np.frombuffer(vector), options, None if moved is None else np.frombuffer(moved)
    )
    for matrix in (found.mass, found.damping, found.stiffness):
        matrix.setflags(write=False)
    return found


def _without_place(item: "Item") -> "Item":
    """Return what has the item's matrices wherever it sits: the same without its node numbers and its group."""
    if isinstance(item, PointMass):
        return replace(item, node=1)
    nodes: Any = tuple(range(1, len(item.nodes) + 1))
    moved = replace(item, nodes=nodes)
    return replace(moved, group=None) if isinstance(moved, Beam | Cable | Spring) else moved


def summed(groups: list[Group], dofs: DofMap) -> tuple[csr_array, csr_array, csr_array]:
    """Return M, C and K over the free degrees of freedom, each the sum of its blocks in all groups."""
    return (
        scatter([(matrices.mass, rows) for matrices, rows in groups], dofs),
        scatter([(matrices.damping, rows) for matrices, rows in groups], dofs),
        scatter([(matrices.stiffness, rows) for matrices, rows in groups], dofs),
    )


def scatter(blocks: list[tuple[FloatArray, IntArray]], dofs: DofMap) -> csr_array:
    """Return the sum of blocks (n, n), each added at all its rows (item, n), over the free degrees of freedom."""
    place = np.cumsum(dofs.free) - 1  # (dof,): position among the free ones
    rows, columns, values = [], [], []
    for block, where in blocks:
        i, j = np.nonzero(block)
        kept = dofs.free[where[:, i]] & dofs.free[where[:, j]]
        rows.append(place[where[:, i]][kept])
        columns.append(place[where[:, j]][kept])
        values.append(np.broadcast_to(block[i, j], kept.shape)[kept])
    size = int(dofs.free.sum())
    if not blocks:
        return csr_array((size, size))
    entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
    return csr_array(coo_array(entries, shape=(size, size)))


def gravity_load(structure: Structure, acceleration: float = 9.81) -> FloatArray:
    """Return the weight (dof,) of all masses, in N (N m for "rz"): M times ``acceleration`` (m/s^2) along -y."""
    parts = mesh(structure)
    falling = np.where(parts.dofs.direction == "y", -acceleration, 0.0)
    weight = np.zeros(len(parts.dofs))
    for matrices, rows in equal_items(structure, parts, None):
        np.add.at(weight, rows, falling[rows] @ matrices.mass)
    return weight
