"""Modal models from .npz: ``omega`` (mode,) rad/s, ``xi`` (mode,) or one number, ``phi`` (dof, mode).

``phi`` covers either all degrees of freedom of the model, zero at its supports, or only the free ones.
"""

from pathlib import Path

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.dof_map import DofMap
from fe_models.errors import InputError, noting, raise_faults
from fe_models.files.array_files import load_arrays, pick_array
from fe_models.files.atomic import write_npz
from fe_models.linear import ModalModel

HELD_TOLERANCE = 1e-6  # of a shape's largest value: what counts as zero at a support


def load_modal_model(path: Path, dofs: DofMap) -> ModalModel:
    """Read a modal model of the structure whose degrees of freedom are ``dofs``; `InputError` carries all faults."""
    arrays, where, faults = load_arrays(path), str(path), list[str]()
    omega, xi, phi = (noting(faults, "", pick_array, arrays, name, where) for name in ("omega", "xi", "phi"))
    if omega is None or xi is None or phi is None:
        raise InputError(faults)
    omega = omega.ravel()
    if phi.ndim != 2 or phi.shape[1] != len(omega):
        faults.append(f"{where}: phi has shape {phi.shape}; expected (dof, {len(omega)}), one column a mode of omega")
    elif phi.shape[0] not in (len(dofs), len(dofs.free_rows)):
        rows = f"{len(dofs)} rows (all degrees of freedom) or {len(dofs.free_rows)} (the free ones)"
        faults.append(f"{where}: phi has {phi.shape[0]} rows; the model needs {rows}")
    elif not np.isfinite(phi).all():
        faults.append(f"{where}: phi holds NaN or infinite values")
    elif phi.shape[0] == len(dofs) and _moves_at_supports(phi, dofs):
        faults.append(f"{where}: phi is not zero at the supports of the model")
    if len(omega) == 0 or not np.isfinite(omega).all() or not (omega > 0).all():
        faults.append(f"{where}: omega must be positive natural frequencies in rad/s, found {omega.tolist()}")
    if xi.size not in (1, len(omega)):
        faults.append(f"{where}: xi has {xi.size} values; expected one, or {len(omega)} as omega has")
    if not ((xi >= 0) & (xi < 1)).all():
        faults.append(f"{where}: xi must be damping ratios, 0 <= xi < 1 (0.01 is 1 %), found {xi.ravel().tolist()}")
    raise_faults(faults)
    shapes = phi if phi.shape[0] == len(dofs) else dofs.expand(phi)
    return ModalModel(omega, np.broadcast_to(xi.ravel(), omega.shape).copy(), shapes, dofs)


def save_modal_model(model: ModalModel, path: Path) -> None:
    """Write ``model`` so that `load_modal_model` returns it."""
    write_npz(path, {"omega": model.omega, "xi": model.damping_ratio, "phi": model.shapes})


def _moves_at_supports(phi: FloatArray, dofs: DofMap) -> bool:
    return bool((abs(phi[~dofs.free]) > HELD_TOLERANCE * abs(phi).max(axis=0)).any())
