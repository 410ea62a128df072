"""Force laws of a hypothesis as functions of elongation and rate, with the flexibility that its modes leave out."""

from dataclasses import replace
from typing import Any

import numpy as np

from fe_models.dofs import FloatArray
from fe_models.effects import SlackCable
from fe_models.uncertain_parts import UncertainPart
from hybrid.diagnosis.causes.candidate import Candidate
from hybrid.diagnosis.nominal.plant import Plant
from hybrid.diagnosis.response.system import Force

SOFTENED = 0.5  # of a force: as much as a softening spring may gain by what gives way behind it


def law_in_motion(law: Any, flexibility: float = 0.0) -> Force:
    """Return the force of a law that does not depend on time, felt through a ``flexibility`` (m/N)."""
    return yielding(lambda u, v: law.force(u, v), flexibility)


def force_of(candidate: Candidate, plant: Plant, values: FloatArray, stiffnesses: FloatArray) -> Force:
    """Return the force of a law of ``values`` (variant, parameter); ``stiffnesses`` (variant, part): factors."""
    cause: Any = candidate.build(*(values[:, i, None] for i in range(values.shape[1])))
    if isinstance(cause, SlackCable):
        law: Any = SlackCable(cause.element, 1.0).law(plant.structure)
        (part,) = (i for i, part in enumerate(plant.parts) if _is_stiffness_of(part, cause.element))
        own = law.stiffness * stiffnesses[:, part, None]
        law = replace(law, stiffness=own, pretension=cause.pretension)
    else:
        law = cause
    return law_in_motion(law, candidate.flexibility)


def yielding(force: Force, flexibility: float) -> Force:
    """Return a ``force`` f(u) felt through a spring: f(u - flexibility f), by one step of Aitken's from f(u) on.

    That is exact where the force is linear, and so for a contact and a slack cable but for where they set in.
    """
    if flexibility == 0:
        return force

    def felt(u: FloatArray, v: FloatArray) -> FloatArray:
        stiff = force(u, v)
        fall = stiff - force(u - flexibility * stiff, v)
        share = np.divide(fall, stiff, out=np.zeros_like(fall), where=np.abs(stiff) > 0)
        return np.asarray(stiff / (1 + np.maximum(share, -SOFTENED)))

    return felt


def _is_stiffness_of(part: UncertainPart, element: int) -> bool:
    return part.quantity == "stiffness" and element in part.elements
