"""From a structure to the linear model: M, C and K, for small motion about the drawn geometry or a state at rest."""

import numpy as np
from scipy.sparse import csr_array

from fe_models.arrays import FloatArray
from fe_models.causes import AddedMass, ForceLaw
from fe_models.causes.modal_damping import replaced_ratios
from fe_models.dead_load import with_dead_load
from fe_models.errors import raise_faults
from fe_models.items import equal_items, summed
from fe_models.linear import LinearModel
from fe_models.linear_checks import negative_mass_faults, negative_stiffness_faults
from fe_models.mesh import mesh
from fe_models.mode_count import mode_count
from fe_models.structure import Structure
from fe_models.structure_checks import require_structure


def linearise(structure: Structure, state: FloatArray | None = None) -> LinearModel:
    """Return M, C and K over the free degrees of freedom, for small motion about a state at rest.

    Without ``state``: the drawn geometry, without load or prestress, cables taken as taut bars. With ``state``, the
    displacement (dof,) of a loaded state at rest (`statics.rest_state`): the tangent there, with prestress, P-delta and
    slack cables. Linear effects are in the matrices; the `force_laws` of the others, which exert nothing at rest, are
    not. `InputError` with all faults where the structure is not usable, or its effects take more mass or stiffness away
    than there is.
    """
    parts = mesh(require_structure(structure))
    mass, damping, stiffness = summed(equal_items(structure, parts, state), parts.dofs)
    if state is None:
        stiffness = with_dead_load(stiffness, structure, parts.dofs)
    model = LinearModel(
        mass=mass,
        damping=damping,
        stiffness=stiffness,
        dofs=parts.dofs,
        coordinates=parts.coordinates,
        modal_ratios=structure.damping.modal_ratios,
        replaced_ratios=replaced_ratios(structure),
    )
    if any(not isinstance(effect, ForceLaw) for effect in structure.effects):
        raise_faults(f"structure {structure.name!r}: {fault}" for fault in _overdrawn(structure, model))
    return model


def unsupported(structure: Structure) -> tuple[csr_array, csr_array, csr_array]:
    """Return M, C (without modal damping) and K over all degrees of freedom, as if no support held the structure."""
    parts = mesh(require_structure(structure))
    dofs = parts.dofs.released()
    mass, damping, stiffness = summed(equal_items(structure, parts, None), dofs)
    return mass, damping, with_dead_load(stiffness, structure, dofs)


def _overdrawn(structure: Structure, model: LinearModel) -> list[str]:
    """Return faults where effects leave no positive mass or stiffness, or name modes that the model does not have."""
    faults, diagonal = [], model.mass.diagonal()
    removed = {effect.node for effect in structure.effects if isinstance(effect, AddedMass) and effect.mass < 0}
    for row, (node, direction) in enumerate(zip(model.dofs.node, model.dofs.direction, strict=True)):
        if node in removed and model.dofs.free[row] and direction != "rz":
            left = diagonal[np.count_nonzero(model.dofs.free[:row])]
            if left <= 0:
                faults.append(f"effects leave node {node} a mass of {left:.6g} kg in {direction}; remove less there")
    available = mode_count(model) if model.replaced_ratios and not faults else len(diagonal)
    modes = [mode for mode, _ in model.replaced_ratios if mode > available]
    faults += [f"modal_damping: there is no mode {mode}; the structure has {available}" for mode in modes]
    return faults or negative_mass_faults(model) + negative_stiffness_faults(model)
