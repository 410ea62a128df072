"""The degrees of freedom of a structure."""

import numpy as np

from fe_models.causes.laws import with_parts
from fe_models.dof_map import DofMap
from fe_models.linear import LinearModel
from fe_models.structure import Beam, Structure


def dofs_of(model: Structure | LinearModel) -> DofMap:
    """Return the degrees of freedom of a structure, with the nodes that its refinement adds, or of matrices."""
    return model.dofs if isinstance(model, LinearModel) else structure_dofs(model)


def structure_dofs(structure: Structure) -> DofMap:
    """Return the degrees of freedom of a structure and of the nodes that its refinement adds, supports marked as held.

    Node by node, each with all ``structure.directions`` in their order; first the nodes of the structure, then the
    ``divisions - 1`` inner nodes of each beam, element by element (the numbering of `mesh.mesh`). What a support holds
    is free where an effect puts a spring in the support's place.
    """
    beams = sum(isinstance(element, Beam) for element in structure.elements)
    nodes = len(structure.nodes) + beams * (structure.divisions - 1)
    per_node = len(structure.directions)
    free = np.ones((nodes, per_node), dtype=bool)
    for support in with_parts(structure).supports:
        for direction in support.directions:
            free[support.node - 1, structure.directions.index(direction)] = False
    return DofMap(
        node=np.repeat(np.arange(1, nodes + 1, dtype=np.int64), per_node),
        direction=np.tile(np.array(structure.directions, dtype=np.str_), nodes),
        free=free.ravel(),
    )
