"""Motions that a stiffness matrix does not resist: missing supports, hinges in a row, a node that nothing holds.

In floating point a singular K looks like one with a very small eigenvalue. The line is drawn at what rounding alone can
do to the strain energy of a shape, eps (sum_ij (phi_i K_ij phi_j)^2)^(1/2), as if every stored K_ij were off by one
unit in its last place.
"""

import numpy as np
from scipy.sparse import csc_array, csr_array, diags_array
from scipy.sparse.linalg import SuperLU, splu

from fe_models.arrays import BoolArray, FloatArray
from fe_models.dof_map import DofMap
from fe_models.linear import LinearModel
from fe_models.structure import ROTATIONS

ROUNDING_MARGIN = 10.0
"""Strain energy, over that of rounding, that a shape must have; a bridge refined to 100,000 dofs still has 65."""
MAX_MOTIONS = 8
"""Independent motions looked for at once; a free body in the plane has three."""
REGULARISATION = 1e-13
"""Stiffness added to each degree of freedom, relative to its own, to solve with a singular K."""


def factorise(matrix: csr_array) -> SuperLU:
    """Factorise a symmetric sparse matrix, fill kept low by minimum degree; `RuntimeError` where it is singular."""
    return splu(csc_array(matrix), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True})


def energy(matrix: csr_array, shapes: FloatArray) -> FloatArray:
    """Return phi^T A phi for each shape (dof, mode), summed in extended precision where the machine has it.

    In a finely meshed beam nearly all of A phi cancels: with 1e-4 of the span between nodes all sixteen digits do.
    """
    extended = shapes.astype(np.longdouble)
    return np.asarray((extended * (matrix.astype(np.longdouble) @ extended)).sum(axis=0), dtype=float)


def resists(stiffness: csr_array, shapes: FloatArray) -> BoolArray:
    """Return for each shape (free, mode) whether its strain energy is more than rounding could fake; shape (mode,)."""
    squares = shapes**2
    rounding = np.finfo(float).eps * np.sqrt(np.einsum("dm,dm->m", squares, stiffness.power(2) @ squares))
    resisted: BoolArray = energy(stiffness, shapes) > ROUNDING_MARGIN * rounding
    return resisted


def describe_mechanism(model: LinearModel) -> list[str]:
    """Return the faults of a model whose K is singular or negative: which nodes move freely, and in which direction."""
    size = np.ptp(model.coordinates, axis=0).max() or 1.0
    turning = np.isin(model.dofs.direction[model.dofs.free], ROTATIONS)
    faults = []
    motions = free_motions(model.stiffness)
    # A rotation counts by what it moves at the far end of the structure, so that it compares with translations.
    amplitude = np.linalg.norm(motions, axis=1) * np.where(turning, size, 1.0)
    for direction in dict.fromkeys(model.dofs.direction.tolist()):
        here = model.dofs.direction[model.dofs.free] == direction
        moving = here & (amplitude > 1e-3 * amplitude.max(initial=0.0))
        if moving.any():
            verb = f"turn ({direction})" if direction in ROTATIONS else f"move in {direction}"
            faults.append(
                f"{_name_nodes(model.dofs, moving)} can {verb} without resistance: "
                "a support or an element to hold this is missing"
            )
    return faults or [
        "the stiffness matrix is not positive: some motion releases energy. The state is unstable (buckled), or a "
        "stiffness is negative"
    ]


def free_motions(stiffness: csr_array) -> FloatArray:
    """Return a basis (free, motion) of at most `MAX_MOTIONS` motions that K does not resist.

    Inverse iteration with K scaled to a unit diagonal and slightly regularised, then Rayleigh-Ritz.
    """
    diagonal = np.abs(stiffness.diagonal())
    scale = 1 / np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
    scaled = csr_array(diags_array(scale) @ stiffness @ diags_array(scale))
    size = len(diagonal)
    factors = factorise(csr_array(scaled + REGULARISATION * diags_array(np.ones(size))))
    block = np.random.default_rng(0).standard_normal((size, min(MAX_MOTIONS, size)))
    for _ in range(3):
        block, _ = np.linalg.qr(factors.solve(block))
    extended = block.astype(np.longdouble)  # as in `energy`, to tell free motions from merely soft ones
    _, turn = np.linalg.eigh(np.asarray(extended.T @ (scaled.astype(np.longdouble) @ extended), dtype=float))
    motions = block @ turn
    # A unit motion of what has no stiffness at all still has the energy of the regularisation's traces elsewhere.
    free = (np.abs(energy(scaled, motions)) < (10 * REGULARISATION) ** 2) | ~resists(scaled, motions)
    small = np.abs(energy(scaled, motions)) < 10 * REGULARISATION  # what is not small but negative buckles
    return np.asarray(scale[:, None] * motions[:, free & small])


def _name_nodes(dofs: DofMap, moving: BoolArray) -> str:
    nodes = np.unique(dofs.node[dofs.free][moving])
    named = ", ".join(str(node) for node in nodes[:5])
    more = f" and {len(nodes) - 5} more" if len(nodes) > 5 else ""
    return f"node{'s' if len(nodes) > 1 else ''} {named}{more}"
