"""What the finite elements themselves make of natural frequencies: long beams bend in fewer ways, and are too stiff."""

from math import ceil

import numpy as np

from fe_models.arrays import BoolArray, FloatArray
from fe_models.assembly import linearise
from fe_models.modes import natural_modes
from fe_models.structure import Beam, Structure
from hybrid.diagnosis.nominal.config import MESH_ERROR
from hybrid.diagnosis.nominal.nominal_model import NominalModel


def coarse_mesh(nominal: NominalModel, moved: BoolArray) -> list[str]:
    """Return a note where elements half as long move a natural frequency of modes that are ``moved`` (mode,)."""
    structure = nominal.structure
    if nominal.kept is None or not any(isinstance(element, Beam) for element in structure.elements):
        return []
    coarse, fine = (_omega(one, nominal.kept) for one in (structure, structure.refined(2 * structure.divisions)))
    off = np.where(moved, np.abs(coarse / fine - 1), 0.0)
    worst = int(np.argmax(off))
    if off[worst] <= MESH_ERROR.min_reported_shift:
        return []
    enough = ceil(
        structure.divisions * (off[worst] / MESH_ERROR.max_shift_of_fine_mesh) ** (1 / MESH_ERROR.convergence_order)
    )
    mode = f"mode {worst + 1} ({coarse[worst] / (2 * np.pi):.4g} Hz) {off[worst]:.1%} off"
    advice = f"what is named may stand for that; set divisions = {enough} in the structure file"
    return [f"the mesh is too coarse: it puts {mode}, and {advice}"]


def _omega(structure: Structure, count: int) -> FloatArray:
    return natural_modes(linearise(structure), count).omega
