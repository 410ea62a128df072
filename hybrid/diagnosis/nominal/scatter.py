"""Elements that are off by themselves: those patterns of their own stiffness that frequencies and shapes feel.

The user's uncertainties are of groups of elements as wholes; recordings determine natural frequencies far better than
any model has them element by element. A candidate at one of two neighbours must not win by what such deviations do, so
every fit may calibrate them.
"""

from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_array

from fe_models.arrays import FloatArray
from fe_models.causes import StiffnessChange
from fe_models.matrix_changes import matrix_changes
from fe_models.structure import Structure
from fe_models.uncertain_parts import UncertainPart
from hybrid.diagnosis.nominal.config import SCATTER


@dataclass(frozen=True)
class Scatter:
    """``elements``: numbers of those in groups; ``weights`` (pattern, element): orthonormal patterns of the relative
    change of their stiffnesses, which then are as independent as the elements; ``changes``: what a unit of each pattern
    adds to K (dof, dof).
    """

    elements: tuple[int, ...]
    weights: FloatArray
    changes: tuple[csr_array, ...]

    def applied(self, structure: Structure, amounts: FloatArray) -> Structure:
        """Return the structure with so much of each pattern (pattern,)."""
        for number, change in zip(self.elements, amounts @ self.weights, strict=True):
            if change:
                structure = UncertainPart("stiffness", (number,)).scaled(structure, float(1 + change))
        return structure


NO_SCATTER = Scatter((), np.zeros((0, 0)), ())


def scatter_of(
    structure: Structure, parts: tuple[UncertainPart, ...], shapes: FloatArray, omega: FloatArray, ratios: FloatArray
) -> Scatter:
    """Return the patterns that free decays in the mode ``shapes`` (dof, mode) feel, to first order.

    A frequency counts by the phase that it makes until a mode has decayed, a shape by what it takes of another one.
    ``omega`` (mode,) rad/s; ``ratios`` (mode,) of damping; ``parts``: the groups are among them.
    """
    groups = [part.elements for part in parts if part.quantity == "stiffness" and len(part.elements) > 1]
    elements = tuple(number for group in groups for number in group)
    if not elements:
        return NO_SCATTER
    changes = [matrix_changes(structure, StiffnessChange((number,), 2.0)).stiffness for number in elements]
    square, modes = omega**2, np.arange(len(omega))
    apart = square[:, None] - square
    apart[np.abs(apart) < SCATTER.min_relative_separation * square] = np.inf
    weight = 1 / apart
    weight[modes, modes] = 1 / (
        4
        * np.maximum(ratios, SCATTER.min_relative_separation)
        * np.maximum(square, SCATTER.min_relative_separation * square.max())
    )
    felt = np.array([(shapes.T @ (change @ shapes) * weight).ravel() for change in changes])  # (element, two modes)
    patterns, sizes, _ = np.linalg.svd(felt, full_matrices=False)
    weights = patterns[:, sizes > SCATTER.min_pattern_share * sizes[0]].T
    mixed = tuple(csr_array(sum(w * change for w, change in zip(row, changes, strict=True))) for row in weights)
    return Scatter(elements, weights, mixed)
