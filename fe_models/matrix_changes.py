"""What linear effects do to the matrices of a structure, sparse and of low rank: M + dM, C + dC, K + dK."""

from collections import Counter
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.causes import Effect
from fe_models.causes.dead_load import dead_load_share
from fe_models.causes.modal_damping import replaced_ratios
from fe_models.damping import ratios_of_modes
from fe_models.dead_load import with_dead_load
from fe_models.dof_map import DofMap
from fe_models.dofs import structure_dofs
from fe_models.items import matrices_of, summed
from fe_models.mechanisms import energy
from fe_models.mesh import mesh
from fe_models.modes import natural_modes
from fe_models.structure import Structure
from fe_models.structure_checks import require_structure


@dataclass(frozen=True)
class MatrixChanges:
    """dM, dC, dK over all degrees of freedom, those at supports included, of a structure when effects are added.

    ``mass``, ``damping``, ``stiffness``: sparse (dof, dof). dC is ``damping`` plus, for modal damping, the sum of
    weight v v^T with the columns v of ``modal_vectors`` (dof, rank) and ``modal_weights`` (rank,). ``dofs`` are those
    of the extended structure: where a spring takes a support's place, a degree of freedom is free that was held.
    All are linear in mass, stiffness, coefficient, force and ratio, and in (factor - 1) from the drawn stiffness.
    """

    mass: csr_array
    damping: csr_array
    stiffness: csr_array
    modal_vectors: FloatArray
    modal_weights: FloatArray
    dofs: DofMap

    def reduced(self, shapes: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return Phi^T dM Phi, Phi^T dC Phi and Phi^T dK Phi, each (mode, mode), for ``shapes`` Phi (dof, mode).

        Exact in the span of the shapes; what an effect bends them to outside of it needs shapes of its own.
        """
        mass, damping, stiffness = (shapes.T @ (A @ shapes) for A in (self.mass, self.damping, self.stiffness))
        modal = self.modal_vectors.T @ shapes  # (rank, mode)
        return mass, damping + (modal.T * self.modal_weights) @ modal, stiffness


def matrix_changes(structure: Structure, *effects: Effect, state: FloatArray | None = None) -> MatrixChanges:
    """Return what ``effects`` add to M, C and K of ``structure``, linearised as `assembly.linearise` does at ``state``.

    Only the items that differ are assembled, so that one effect costs a few milliseconds however large the structure;
    modal damping costs the natural modes. Effects with a force law add nothing. `InputError` where they do not fit.
    """
    from fe_models.exudyn.item_matrices import items_of  # loads Exudyn only where it is needed

    extended = require_structure(structure.with_effects(*effects))
    parts = mesh(structure)
    before, after = (
        Counter((item, nodes, tuple(vector.tolist())) for item, nodes, vector in items_of(variant, parts))
        for variant in (structure, extended)
    )
    everywhere = parts.dofs.released()
    mass, damping, stiffness = (csr_array((len(everywhere), len(everywhere))) for _ in range(3))
    for sign, items in ((1.0, after - before), (-1.0, before - after)):
        placed = [(item, nodes, np.array(vector)) for item, nodes, vector in items.elements()]
        dM, dC, dK = summed(matrices_of(structure, placed, state), everywhere)
        mass, damping, stiffness = mass + sign * dM, damping + sign * dC, stiffness + sign * dK
    if state is None and dead_load_share(extended) != dead_load_share(structure):
        nothing = csr_array(stiffness.shape)
        before_it, after_it = (with_dead_load(nothing, variant, everywhere) for variant in (structure, extended))
        stiffness = stiffness + after_it - before_it
    vectors, weights = _modal_part(structure, extended, state)
    return MatrixChanges(mass, damping, stiffness, vectors, weights, structure_dofs(extended))


def _modal_part(structure: Structure, extended: Structure, state: FloatArray | None) -> tuple[FloatArray, FloatArray]:
    """Return M phi_i (dof, rank) and 2 omega_i (ratio_i - xi_i) (rank,) of the modes with new ratios."""
    ratios = dict(replaced_ratios(extended))
    if ratios == dict(replaced_ratios(structure)):
        return np.zeros((len(structure_dofs(extended)), 0)), np.zeros(0)
    model = linearise(extended, state)
    modal = natural_modes(model, max(ratios))
    shapes = modal.shapes[modal.dofs.free]
    kept = dict(replaced_ratios(structure))
    own = energy(model.damping, shapes) / (2 * modal.omega) + ratios_of_modes(model.modal_ratios, len(modal.omega))
    modes = np.array(sorted(ratios)) - 1
    before = np.array([kept.get(int(mode) + 1, own[mode]) for mode in modes])
    weights = 2 * modal.omega[modes] * (modal.damping_ratio[modes] - before)
    return modal.dofs.expand(model.mass @ shapes[:, modes]), weights
