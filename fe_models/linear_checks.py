"""What makes matrices unusable as a linear model, found before anything is solved with them."""

import numpy as np
from scipy.linalg import eigh, eigvalsh
from scipy.sparse import csr_array

from fe_models.arrays import FloatArray
from fe_models.damping import full_damping
from fe_models.dof_map import DofMap
from fe_models.errors import InputError
from fe_models.linear import LinearModel

SYMMETRY_TOLERANCE = 1e-6
"""Largest |A - A^T| over the largest |A|; matrices printed with seven digits pass."""
NEGATIVE_TOLERANCE = 1e-9
"""Smallest negative eigenvalue of K scaled to a unit diagonal that is no rounding; a mechanism has one of 1e-16."""
LARGEST_EIGENVALUE_CHECK = 1000
"""Free degrees of freedom up to which M is checked by its eigenvalues (0.1 s), beyond it only by its diagonal."""


def check_linear_model(model: LinearModel) -> list[str]:
    """Return one sentence for each fault of M, C and K: shape, numbers, symmetry, sign. Empty for a usable model.

    Whether K resists all motion shows only in solving with it, see `mechanisms`.
    """
    faults = _check_dof_map(model)
    free = int(model.dofs.free.sum())
    for name, matrix, symmetric in (("M", model.mass, True), ("C", model.damping, False), ("K", model.stiffness, True)):
        if matrix.shape != (free, free):
            faults.append(f"{name} is {_size(matrix)}; the dof map has {free} free degrees of freedom")
        elif not np.isfinite(matrix.data).all():
            faults.append(
                f"{name} holds numbers that are not finite (NaN or infinity){_first_broken(matrix, model.dofs)}"
            )
        else:
            faults += _check_symmetry(name, matrix, model.dofs) if symmetric else []
            faults += _check_signs("K", "stiffness", matrix.diagonal(), model.dofs) if name == "K" else []
            faults += _check_damping(model) if name == "C" else []
    return faults or [*_check_mass(model), *_check_lines(model), *_check_groups(model)]


def dof_name(dofs: DofMap, free_row: int) -> str:
    """Return "node 3 in y" for a row of the free matrices."""
    row = dofs.free_rows[free_row]
    return f"node {dofs.node[row]} in {dofs.direction[row]}"


def negative_mass_faults(model: LinearModel) -> list[str]:
    """Return a fault where some motion of a small model has negative kinetic energy."""
    return _check_mass(model) if model.mass.nnz else []


def negative_stiffness_faults(model: LinearModel) -> list[str]:
    """Return a fault where some motion of a small model releases energy: K, scaled to a unit diagonal, is negative."""
    diagonal = model.stiffness.diagonal()
    negative = np.flatnonzero(diagonal < 0)
    if len(negative):
        return [
            f"the stiffness at {dof_name(model.dofs, row)} is negative, {diagonal[row]:.6g}: the state at rest is "
            "unstable; take less stiffness away, or less compression"
            for row in negative[:5]
        ]
    if len(diagonal) > LARGEST_EIGENVALUE_CHECK:
        return []
    scale = 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    values, shapes = eigh(model.stiffness.toarray() * np.outer(scale, scale), subset_by_index=[0, 0])
    if values[0] >= -NEGATIVE_TOLERANCE:
        return []
    most = dof_name(model.dofs, int(np.argmax(np.abs(shapes[:, 0] * scale))))
    return [
        f"the state at rest is unstable, most of all {most}: some motion releases energy (it buckles). "
        "Take less stiffness away, or less compression"
    ]


def energy_faults(model: LinearModel) -> list[str]:
    """Return a fault where damping feeds energy into some motion of a small model: v^T C v is below zero."""
    size = model.mass.shape[0]
    if size > LARGEST_EIGENVALUE_CHECK or not (model.damping.nnz or model.has_modal_damping):
        return []
    damping = full_damping(model) if model.has_modal_damping else model.damping.toarray()
    scale = 1 / np.sqrt(np.maximum(abs(damping.diagonal()), 1e-6 * abs(damping).max(initial=1e-300)))
    values, shapes = eigh((damping + damping.T) / 2 * np.outer(scale, scale), subset_by_index=[0, 0])
    if values[0] >= -SYMMETRY_TOLERANCE * size:
        return []
    most = dof_name(model.dofs, int(np.argmax(np.abs(shapes[:, 0] * scale))))
    return [f"C feeds energy into some motion, most of all {most}: free vibration would grow"]


def _size(matrix: csr_array) -> str:
    return " x ".join(str(length) for length in matrix.shape)


def _check_dof_map(model: LinearModel) -> list[str]:
    dofs = model.dofs
    faults = []
    if not len(dofs.node) == len(dofs.direction) == len(dofs.free):
        faults.append("the dof map's node, direction and free have different lengths")
    if model.coordinates.ndim != 2 or model.coordinates.shape[1] not in (2, 3):
        faults.append(f"coordinates have shape {model.coordinates.shape}; expected (node, 2), or (node, 3) in space")
    elif not np.isfinite(model.coordinates).all():
        faults.append("coordinates hold numbers that are not finite (NaN or infinity)")
    elif len(dofs.node) and not 1 <= dofs.node.min() <= dofs.node.max() <= len(model.coordinates):
        faults.append(
            f"the dof map names nodes {dofs.node.min()} to {dofs.node.max()}; "
            f"coordinates are given for nodes 1 to {len(model.coordinates)}"
        )
    return faults


def _check_symmetry(name: str, matrix: csr_array, dofs: DofMap) -> list[str]:
    difference = abs(matrix - matrix.T).tocoo()
    largest = abs(matrix).max() if matrix.nnz else 0.0
    if not difference.nnz or difference.data.max() <= SYMMETRY_TOLERANCE * largest:
        return []
    worst = int(np.argmax(difference.data))
    i, j = int(difference.coords[0][worst]), int(difference.coords[1][worst])
    return [
        f"{name} is not symmetric: {matrix[i, j]:.6g} between {dof_name(dofs, i)} and {dof_name(dofs, j)}, "
        f"{matrix[j, i]:.6g} the other way round"
    ]


def _first_broken(matrix: csr_array, dofs: DofMap) -> str:
    entries = matrix.tocoo()
    first = int(np.flatnonzero(~np.isfinite(entries.data))[0])
    return f", the first between {' and '.join(dof_name(dofs, int(index[first])) for index in entries.coords)}"


def _check_signs(name: str, quantity: str, diagonal: FloatArray, dofs: DofMap) -> list[str]:
    return [
        f"{name} has a negative {quantity}, {diagonal[row]:.6g}, at {dof_name(dofs, row)}"
        for row in np.flatnonzero(diagonal < 0)[:5]
    ]


def _check_damping(model: LinearModel) -> list[str]:
    """Return faults of C, the modal part included, from which a damper may take away; none where that is not known."""
    diagonal = model.damping.diagonal()
    if np.any(diagonal < 0) and model.has_modal_damping:
        try:
            diagonal = full_damping(model).diagonal()
        except (InputError, np.linalg.LinAlgError, ValueError):  # too large; or M or K is at fault, as others report
            return []
    return _check_signs("C", "damping", diagonal, model.dofs)


def _check_lines(model: LinearModel) -> list[str]:
    lines, count = model.lines, len(model.coordinates)
    if lines is None or not len(lines):
        return []
    if lines.ndim != 2 or lines.shape[1] != 2:
        return [f"lines have shape {lines.shape}; expected (line, 2): the numbers of two nodes each"]
    if lines.min() < 1 or lines.max() > count:
        return [f"lines name nodes {lines.min()} to {lines.max()}; coordinates are given for nodes 1 to {count}"]
    return []


def _check_groups(model: LinearModel) -> list[str]:
    """Return faults of the groups' shares: each like M and K, and together no more than these."""
    faults, totals = list[str](), {"M": model.mass, "K": model.stiffness}
    for group in model.groups:
        found = list[str]()
        for name, share in (("M", group.mass), ("K", group.stiffness)):
            if share.shape != totals[name].shape:
                found.append(f"its share of {name} is {_size(share)}; {name} is {_size(totals[name])}")
            elif not np.isfinite(share.data).all():
                found.append(f"its share of {name} holds numbers that are not finite (NaN or infinity)")
            else:
                quantity = "mass" if name == "M" else "stiffness"
                found += _check_symmetry(f"its share of {name}", share, model.dofs)
                found += _check_signs(f"its share of {name}", quantity, share.diagonal(), model.dofs)
        if not found and not (group.mass.count_nonzero() or group.stiffness.count_nonzero()):
            found.append("it has a share of neither M nor K; give it one, or leave it out")
        faults += [f"group {group.name!r}: {fault}" for fault in found]
    return faults or _check_sums(model)


def _check_sums(model: LinearModel) -> list[str]:
    """Return faults where groups together have more than M or K has."""
    faults = []
    for name, total, shares in (
        ("M", model.mass, [group.mass.diagonal() for group in model.groups]),
        ("K", model.stiffness, [group.stiffness.diagonal() for group in model.groups]),
    ):
        whole, together = total.diagonal(), np.sum(shares, axis=0) if shares else np.zeros(total.shape[0])
        beyond = np.flatnonzero(together > whole + SYMMETRY_TOLERANCE * np.abs(whole).max(initial=0.0))
        faults += [
            f"the groups' shares of {name} at {dof_name(model.dofs, row)} add up to {together[row]:.6g}, more than the"
            f" {whole[row]:.6g} of {name}: {name} is the sum of all shares and of what never changes"
            for row in beyond[:3]
        ]
    return faults


def _check_mass(model: LinearModel) -> list[str]:
    diagonal = model.mass.diagonal()
    if not diagonal.any():
        return ["M is zero: nothing has mass, so there is no natural mode"]
    negative = np.flatnonzero(diagonal < 0)
    if len(negative):
        return [f"M has a negative mass, {diagonal[row]:.6g}, at {dof_name(model.dofs, row)}" for row in negative[:5]]
    if len(diagonal) <= LARGEST_EIGENVALUE_CHECK:
        lowest, highest = eigvalsh(model.mass.toarray())[[0, -1]]
        if lowest < -SYMMETRY_TOLERANCE * highest:
            return [f"M is not positive: its lowest eigenvalue is {lowest:.6g}, so some motion has negative energy"]
    return []
