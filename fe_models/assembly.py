"""From a structure to the linear model: Exudyn linearises each different finite element once, the rest is a sparse sum.

    M = sum_e B_e^T M_e B_e, likewise C and K, with B_e picking the element's degrees of freedom.

Elements with equal section, length and orientation have equal matrices, so that a structure of 100,000 degrees of
freedom costs Exudyn no more than the drawn one, and no full matrix is ever formed.
"""

from collections import defaultdict
from collections.abc import Hashable
from dataclasses import fields
from typing import TYPE_CHECKING

import numpy as np
from scipy.sparse import coo_array, csr_array

from fe_models.cables import is_slack
from fe_models.dofs import DofMap, FloatArray, IntArray
from fe_models.linear import LinearModel
from fe_models.mesh import Mesh, mesh
from fe_models.structure import Cable, PointMass, Structure
from fe_models.structure_checks import require_structure

if TYPE_CHECKING:
    from fe_models.exudyn_io import ElementMatrices
    from fe_models.exudyn_items import Item


def linearise(structure: Structure, state: FloatArray | None = None) -> LinearModel:
    """Return M, C and K over the free degrees of freedom, for small motion about a state at rest.

    Without ``state``: the drawn geometry, without load or prestress, cables taken as taut bars. With ``state``, the
    displacement (dof,) of a loaded state at rest (`statics.rest_state`): the tangent there, with prestress, P-delta and
    slack cables. `InputError` with all faults where the structure is not usable.
    """
    parts = mesh(require_structure(structure))
    groups = _equal_items(structure, parts, state)
    return LinearModel(
        mass=_scatter([(matrices.mass, rows) for matrices, rows in groups], parts.dofs),
        damping=_scatter([(matrices.damping, rows) for matrices, rows in groups], parts.dofs),
        stiffness=_scatter([(matrices.stiffness, rows) for matrices, rows in groups], parts.dofs),
        dofs=parts.dofs,
        coordinates=parts.coordinates,
        modal_ratios=structure.damping.modal_ratios,
    )


def gravity_load(structure: Structure, acceleration: float = 9.81) -> FloatArray:
    """Return the weight (dof,) of all masses, in N (N m for "rz"): M times ``acceleration`` (m/s^2) along -y."""
    parts = mesh(structure)
    falling = np.where(parts.dofs.direction == "y", -acceleration, 0.0)
    weight = np.zeros(len(parts.dofs))
    for matrices, rows in _equal_items(structure, parts, None):
        np.add.at(weight, rows, falling[rows] @ matrices.mass)
    return weight


Group = tuple["ElementMatrices", IntArray]
"""Matrices (n, n) of equal items, and the rows (item, n) of their degrees of freedom."""


def _equal_items(structure: Structure, parts: Mesh, state: FloatArray | None) -> list[Group]:
    """Return the matrices of each different item, and where its copies sit."""
    from fe_models import exudyn_io  # loads Exudyn only where it is needed
    from fe_models.exudyn_items import Options

    options = Options(damping=structure.damping, prestress=state is not None, slack=False)
    per_node = len(structure.directions)
    matrices: dict[Hashable, ElementMatrices] = {}
    rows_of: dict[Hashable, list[list[int]]] = defaultdict(list)
    for item, nodes, vector in exudyn_io.items_of(structure, parts):
        rows = [per_node * (node - 1) + i for node in nodes for i in range(per_node)]
        moved = None if state is None else state[rows]
        key = (_without_place(item), *vector, None if moved is None else moved.tobytes())
        if key not in matrices:
            matrices[key] = exudyn_io.element_matrices(structure.directions, item, vector, options, moved)
            if moved is not None and isinstance(item, Cable) and is_slack(item, vector, moved):
                matrices[key] = exudyn_io.ElementMatrices(matrices[key].mass, *np.zeros((2, len(rows), len(rows))))
        rows_of[key].append(rows)
    return [(matrices[key], np.array(rows, dtype=np.int64)) for key, rows in rows_of.items()]


def _without_place(item: "Item") -> Hashable:
    """Return what makes an item's matrices: its kind and all its fields but the node numbers and the group."""
    made_of = [getattr(item, entry.name) for entry in fields(item) if entry.name not in ("node", "nodes", "group")]
    return (type(item), isinstance(item, PointMass) or len(item.nodes), *made_of)


def _scatter(blocks: list[tuple[FloatArray, IntArray]], dofs: DofMap) -> csr_array:
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
