"""Linear models from matrices that another program assembled (Abaqus, Ansys, OpenSees), over the free dofs. Units SI.

An .npz file holds ``M``, ``K`` and, optionally, ``C`` (row, row), dense or as the parts of a compressed sparse row
matrix (``M_data``, ``M_indices``, ``M_indptr``, ``M_shape``); ``nodes`` (node, 2), x and y in m, or (node, 3) in space;
``dof_node`` (row,), from 1, and ``dof_direction`` (row,), "x", "y", "z", "rx", "ry" or "rz", of each row. Optional:

- ``groups`` (group,): names of groups of elements, and for the first of them ``K_1`` and ``M_1``, its shares of K and
  M, dense or in parts, for the second ``K_2`` and ``M_2``, ...; one of the two may be left out.
- ``rigid_links`` (link, 2): numbers of a leading node, whose degrees of freedom have rows, and of one that follows; or
  ``linked_node`` and ``linked_direction`` (linked,) and ``T`` (linked, row): their motion for a unit of each row's.
- ``lines`` (line, 2): numbers of nodes between which pictures draw a line.
- ``all_dof_node`` and ``all_dof_direction``, the same for all degrees of freedom, those at supports included;
  ``modal_ratios``; ``replaced_ratios`` (mode, 2): number and damping ratio of modes that have their own.
"""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array

from fe_models.arrays import FloatArray, IntArray
from fe_models.errors import InputError, noting, raise_faults
from fe_models.files.array_files import load_arrays, pick_array
from fe_models.files.atomic import write_npz
from fe_models.files.matrix_parts import Dof, MatrixParts, assemble_model
from fe_models.linear import LinearModel, MatrixGroup
from fe_models.rigid_links import Linked
from fe_models.value_limits import LARGEST

LARGEST_DENSE = 1000  # rows; larger matrices are saved as sparse parts
SPARSE_PARTS = ("data", "indices", "indptr", "shape")

Arrays = dict[str, NDArray[np.generic]]


def load_linear_model(path: Path) -> LinearModel:
    """Read a linear model from .npz; `InputError` carries all its faults."""
    arrays, where, faults = load_arrays(path), str(path), list[str]()
    if not arrays.keys() & {"M", "M_data"} and arrays.keys() >= {"omega", "phi"}:
        raise InputError(f"{where}: holds a modal model, no matrices: name it as modal_model in [simulation] instead")
    mass = _npz_matrix(arrays, "M", where, faults)
    stiffness = _npz_matrix(arrays, "K", where, faults)
    damping = _npz_matrix(arrays, "C", where, faults) if _has(arrays, "C") else None
    nodes = _numbers(arrays, "nodes", where, faults)
    dofs = _npz_dofs(arrays, "dof", where, faults)
    everywhere = _npz_dofs(arrays, "all_dof", where, faults) if "all_dof_node" in arrays else dofs
    ratios = _numbers(arrays, "modal_ratios", where, faults) if "modal_ratios" in arrays else None
    replaced = _numbers(arrays, "replaced_ratios", where, faults) if "replaced_ratios" in arrays else None
    links, lines = (_node_numbers(arrays, name, where, faults) for name in ("rigid_links", "lines"))
    linked = _npz_linked(arrays, where, faults)
    groups = _npz_groups(arrays, mass, where, faults)
    if mass is None or stiffness is None or nodes is None or dofs is None or everywhere is None:
        raise InputError(faults)
    raise_faults(faults)
    parts = MatrixParts(
        mass, stiffness, nodes, dofs, damping, everywhere, ratios, replaced, groups, lines, links, linked
    )
    return assemble_model(where, parts)


def save_linear_model(model: LinearModel, path: Path, extra: Mapping[str, ArrayLike] | None = None) -> None:
    """Write ``model``, and any ``extra`` arrays beside it (frequencies, mode shapes), as .npz."""
    arrays: dict[str, ArrayLike] = {}
    named = [("M", model.mass), ("K", model.stiffness), ("C", model.damping)]
    for number, group in enumerate(model.groups, start=1):
        named += [(f"M_{number}", group.mass), (f"K_{number}", group.stiffness)]
    for name, matrix in named:
        if matrix.shape[0] <= LARGEST_DENSE:
            arrays[name] = matrix.toarray()
        else:
            arrays |= _sparse_parts(name, matrix)
    dofs = model.dofs
    free, own = dofs.free, slice(None)
    if dofs.links is not None:
        follows = np.diff(dofs.links.indptr) > 0
        arrays |= {"linked_node": dofs.node[follows], "linked_direction": dofs.direction[follows]}
        arrays |= _sparse_parts("T", dofs.links[follows])
        own = ~follows
    arrays |= {"dof_node": dofs.node[free], "dof_direction": dofs.direction[free]}
    arrays |= {"all_dof_node": dofs.node[own], "all_dof_direction": dofs.direction[own]}
    arrays |= {"nodes": model.coordinates, "modal_ratios": np.array(model.modal_ratios, dtype=float)}
    if model.replaced_ratios:
        arrays["replaced_ratios"] = np.array(model.replaced_ratios)
    if model.groups:
        arrays["groups"] = np.array([group.name for group in model.groups])
    if model.lines is not None:
        arrays["lines"] = model.lines
    write_npz(path, arrays | dict(extra or {}))


def _sparse_parts(name: str, matrix: csr_array) -> dict[str, ArrayLike]:
    return {f"{name}_{part}": getattr(matrix, part) for part in SPARSE_PARTS}


def _has(arrays: Arrays, name: str) -> bool:
    return name in arrays or f"{name}_data" in arrays


def _npz_groups(arrays: Arrays, mass: csr_array | None, where: str, faults: list[str]) -> tuple[MatrixGroup, ...]:
    """Return the groups that the file names, as far as their shares can be read."""
    if "groups" not in arrays:
        return ()
    names = arrays["groups"]
    if names.dtype.kind != "U" or names.ndim != 1:
        faults.append(f"{where}: groups must be a list of texts, the name of each group")
        return ()
    found, zero = [], csr_array((0, 0) if mass is None else mass.shape)
    for number, name in enumerate(names.tolist(), start=1):
        if not _has(arrays, f"K_{number}") and not _has(arrays, f"M_{number}"):
            faults.append(f"{where}: group {name!r}: holds neither K_{number} nor M_{number}, its shares of K and M")
            continue
        shares = [
            _npz_matrix(arrays, f"{letter}_{number}", where, faults) if _has(arrays, f"{letter}_{number}") else zero
            for letter in "MK"
        ]
        present = [share for share in shares if share is not None]
        if len(present) == len(shares):
            found.append(MatrixGroup(name, *present))
    return tuple(found)


def _npz_linked(arrays: Arrays, where: str, faults: list[str]) -> Linked:
    if "linked_node" not in arrays:
        return Linked()
    dofs, motion = _npz_dofs(arrays, "linked", where, faults), _npz_matrix(arrays, "T", where, faults)
    return Linked() if dofs is None or motion is None else Linked(tuple(dofs), motion)


def _node_numbers(arrays: Arrays, name: str, where: str, faults: list[str]) -> IntArray | None:
    """Return an optional table of node numbers."""
    values = _numbers(arrays, name, where, faults) if name in arrays else None
    if values is None:
        return None
    if not np.isfinite(values).all() or (values != np.round(values)).any():
        faults.append(f"{where}: {name} must hold whole numbers, those of nodes from 1")
        return None
    return values.astype(np.int64)


def _npz_matrix(arrays: Arrays, name: str, where: str, faults: list[str]) -> csr_array | None:
    """Return a matrix given dense or as sparse parts; None, with the fault noted, where it is neither."""
    if f"{name}_data" not in arrays:
        dense = _numbers(arrays, name, where, faults)
        if dense is not None and dense.ndim != 2:
            faults.append(f"{where}: {name} has shape {dense.shape}; expected (free, free)")
            return None
        return None if dense is None else csr_array(dense)
    parts = [_numbers(arrays, f"{name}_{part}", where, faults) for part in SPARSE_PARTS]
    present = [part for part in parts if part is not None]
    if len(present) < len(parts):
        return None
    data, indices, indptr, shape = present
    try:
        size = tuple(int(length) for length in shape)
        matrix = csr_array((data, indices.astype(np.int64), indptr.astype(np.int64)), shape=size)
        matrix.check_format(full_check=True)
    except (ValueError, TypeError, OverflowError) as error:
        faults.append(f"{where}: {name}_data, {name}_indices, ... are no compressed sparse row matrix ({error})")
        return None
    return matrix


def _npz_dofs(arrays: Arrays, prefix: str, where: str, faults: list[str]) -> list[Dof] | None:
    """Return (node, direction) of each row, or None with the faults noted."""
    nodes = _numbers(arrays, f"{prefix}_node", where, faults)
    directions = arrays.get(f"{prefix}_direction")
    if directions is None or directions.dtype.kind != "U":
        faults.append(
            f'{where}: {prefix}_direction must be an array of texts, "x", "y", "z", "rx", "ry" or "rz", one a row'
        )
        return None
    if nodes is None:
        return None
    if nodes.ndim != 1 or nodes.shape != directions.shape:
        faults.append(f"{where}: {prefix}_node {nodes.shape} and {prefix}_direction {directions.shape} differ in shape")
        return None
    if not np.isfinite(nodes).all() or (nodes != np.round(nodes)).any():
        faults.append(f"{where}: {prefix}_node must hold whole numbers, from 1")
        return None
    return list(zip(nodes.astype(int).tolist(), directions.tolist(), strict=True))


def _numbers(arrays: Arrays, name: str, where: str, faults: list[str]) -> FloatArray | None:
    """Return an array of numbers; None, with the fault noted, where it is none, or too large to compute with."""
    values = noting(faults, "", pick_array, arrays, name, where)
    if values is None or not (abs(values[np.isfinite(values)]) > LARGEST).any():
        return values
    faults.append(f"{where}: {name} holds numbers beyond {LARGEST:g}, the largest: are its units SI?")
    return None
