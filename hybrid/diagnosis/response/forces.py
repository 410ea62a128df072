"""Force laws of a hypothesis as functions of elongation and rate."""

from dataclasses import replace
from typing import Any

from fe_models.arrays import FloatArray
from fe_models.causes import SlackCable
from fe_models.causes.candidate import LawCandidate
from fe_models.uncertain_parts import UncertainPart
from hybrid.diagnosis.nominal.plant import Plant
from hybrid.diagnosis.response.system import Force


def law_in_motion(law: Any) -> Force:
    """Return the force of a law that does not depend on time."""
    return lambda u, v: law.force(u, v)


def force_of(candidate: LawCandidate, plant: Plant, values: FloatArray, stiffnesses: FloatArray) -> Force:
    """Return the force of a law of ``values`` (variant, parameter); ``stiffnesses`` (variant, part): factors."""
    cause: Any = candidate.build(*(values[:, i, None] for i in range(values.shape[1])))
    if isinstance(cause, SlackCable):
        law: Any = SlackCable(cause.element, 1.0).law(plant.built)
        (part,) = (i for i, part in enumerate(plant.parts) if _is_stiffness_of(part, cause.element))
        own = law.stiffness * stiffnesses[:, part, None]
        law = replace(law, stiffness=own, pretension=cause.pretension)
    else:
        law = cause
    return law_in_motion(law)


def _is_stiffness_of(part: UncertainPart, element: int) -> bool:
    return part.quantity == "stiffness" and element in part.elements
