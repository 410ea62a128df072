"""Linear models from matrices that another program assembled (Abaqus, Ansys, OpenSees), over the free dofs. Units SI.

An .npz file holds ``M``, ``K`` and, optionally, ``C`` (free, free), dense or as the parts of a compressed sparse row
matrix (``M_data``, ``M_indices``, ``M_indptr``, ``M_shape``); ``nodes`` (node, 2), x and y in m; ``dof_node`` (free,),
from 1, and ``dof_direction`` (free,), "x", "y" or "rz", of each row. Optional: ``all_dof_node`` and
``all_dof_direction``, the same for all degrees of freedom, those at supports included; ``modal_ratios``;
``replaced_ratios`` (mode, 2): number and damping ratio of modes that have their own.
"""

from collections import Counter
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import csr_array

from fe_models.arrays import FloatArray
from fe_models.dof_map import DofMap
from fe_models.errors import InputError, noting, raise_faults
from fe_models.files.array_files import load_arrays, pick_array
from fe_models.files.atomic import write_npz
from fe_models.linear import LinearModel
from fe_models.linear_checks import check_linear_model

LARGEST_DENSE = 1000  # rows; larger matrices are saved as sparse parts
SPARSE_PARTS = ("data", "indices", "indptr", "shape")

Arrays = dict[str, NDArray[np.generic]]
Dof = tuple[int, str]


def load_linear_model(path: Path) -> LinearModel:
    """Read a linear model from .npz; `InputError` carries all its faults."""
    arrays, where, faults = load_arrays(path), str(path), list[str]()
    if not arrays.keys() & {"M", "M_data"} and arrays.keys() >= {"omega", "phi"}:
        raise InputError(f"{where}: holds a modal model, no matrices: name it as modal_model in [simulation] instead")
    mass = _npz_matrix(arrays, "M", where, faults)
    stiffness = _npz_matrix(arrays, "K", where, faults)
    has_damping = "C" in arrays or "C_data" in arrays
    damping = _npz_matrix(arrays, "C", where, faults) if has_damping else None
    nodes = _numbers(arrays, "nodes", where, faults)
    dofs = _npz_dofs(arrays, "dof", where, faults)
    everywhere = _npz_dofs(arrays, "all_dof", where, faults) if "all_dof_node" in arrays else dofs
    ratios = _numbers(arrays, "modal_ratios", where, faults) if "modal_ratios" in arrays else None
    replaced = _numbers(arrays, "replaced_ratios", where, faults) if "replaced_ratios" in arrays else None
    if mass is None or stiffness is None or nodes is None or dofs is None or everywhere is None:
        raise InputError(faults)
    raise_faults(faults)
    return assemble_model(where, mass, damping, stiffness, nodes, dofs, everywhere, ratios, replaced)


def save_linear_model(model: LinearModel, path: Path, extra: Mapping[str, ArrayLike] | None = None) -> None:
    """Write ``model``, and any ``extra`` arrays beside it (frequencies, mode shapes), as .npz."""
    arrays: dict[str, ArrayLike] = {}
    for name, matrix in (("M", model.mass), ("K", model.stiffness), ("C", model.damping)):
        if matrix.shape[0] <= LARGEST_DENSE:
            arrays[name] = matrix.toarray()
        else:
            arrays |= {f"{name}_{part}": getattr(matrix, part) for part in SPARSE_PARTS}
    free = model.dofs.free
    arrays |= {"dof_node": model.dofs.node[free], "dof_direction": model.dofs.direction[free]}
    arrays |= {"all_dof_node": model.dofs.node, "all_dof_direction": model.dofs.direction}
    arrays |= {"nodes": model.coordinates, "modal_ratios": np.array(model.modal_ratios, dtype=float)}
    if model.replaced_ratios:
        arrays["replaced_ratios"] = np.array(model.replaced_ratios)
    write_npz(path, arrays | dict(extra or {}))


def assemble_model(
    where: str,
    mass: csr_array,
    damping: csr_array | None,
    stiffness: csr_array,
    nodes: FloatArray,
    dofs: list[Dof],
    everywhere: list[Dof],
    ratios: FloatArray | None = None,
    replaced: FloatArray | None = None,
) -> LinearModel:
    """Return the model, checked as every linear model is; ``dofs`` are the free ones among ``everywhere``."""
    faults = _dof_faults(everywhere)
    free = set(dofs)
    places = [dof for dof in everywhere if dof in free] if everywhere is not dofs else dofs
    if places != dofs:
        raise InputError(f"{where}: all_dof_node and all_dof_direction must hold those of dof_*, in the same order")
    dof_map = DofMap(
        node=np.array([node for node, _ in everywhere], dtype=np.int64),
        direction=np.array([direction for _, direction in everywhere], dtype=np.str_),
        free=np.array([dof in free for dof in everywhere], dtype=bool),
    )
    damping = csr_array(mass.shape) if damping is None else damping
    modal_ratios = () if ratios is None else tuple(ratios.ravel().tolist())
    pairs: tuple[tuple[int, float], ...] = ()
    if replaced is not None and (replaced.ndim != 2 or replaced.shape[1] != 2 or not np.isfinite(replaced).all()):
        faults.append(f"replaced_ratios is no table of mode and ratio; it has shape {replaced.shape}")
    elif replaced is not None:
        pairs = tuple((int(mode), float(ratio)) for mode, ratio in replaced)
    model = LinearModel(mass, damping, stiffness, dof_map, nodes, modal_ratios, pairs)
    raise_faults(f"{where}: {fault}" for fault in [*faults, *check_linear_model(model)])
    return model


def _dof_faults(dofs: list[Dof]) -> list[str]:
    times = Counter(dofs)
    faults = [f"node {node} {direction} appears {n} times" for (node, direction), n in times.items() if n > 1]
    unknown = sorted({direction for _, direction in dofs} - {"x", "y", "rz"})
    return faults + [f"direction {direction!r} is unknown; expected x, y or rz" for direction in unknown]


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
        faults.append(f'{where}: {prefix}_direction must be an array of texts "x", "y" or "rz", one a row')
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
    return noting(faults, "", pick_array, arrays, name, where)
