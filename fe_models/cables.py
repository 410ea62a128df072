"""The force in a cable: E A times its strain from its free length, and none where it would have to push."""

from math import hypot

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.structure import Cable


def cable_free_length(cable: Cable, vector: FloatArray) -> float:
    """Return the length L0 (m) without force of a cable that carries its prestress N along ``vector`` (2,), in m.

    N = E A (L - L0) / L0, so that L0 = L / (1 + N / (E A)); a cable that has lost its stiffness carries nothing.
    """
    strain = cable.prestress / cable.section.axial_stiffness if cable.section.axial_stiffness else 0.0
    return hypot(*vector) / (1 + strain)


def cable_force(cable: Cable, vector: FloatArray, displacement: FloatArray) -> float:
    """Return the tension (N) of a cable drawn along ``vector`` (2,) once its ends have moved.

    ``displacement`` (n,) holds all degrees of freedom of its first node, then of its last; x and y come first in each.
    """
    first, last = np.split(displacement, 2)
    free_length = cable_free_length(cable, vector)
    strain = hypot(*(vector + last[:2] - first[:2])) / free_length - 1
    force = cable.section.axial_stiffness * strain
    return max(force, 0.0) if cable.tension_only else force


def is_slack(cable: Cable, vector: FloatArray, displacement: FloatArray) -> bool:
    """Return whether the cable, its ends moved as for `cable_force`, carries nothing."""
    return cable.tension_only and cable_force(cable, vector, displacement) == 0.0
