"""Force laws of a hypothesis as functions of elongation and rate."""

from typing import Any

from fe_models.arrays import FloatArray
from fe_models.causes.candidate import LawCandidate
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.response.system import Force


def force_of(candidate: LawCandidate, nominal: NominalModel, values: FloatArray, stiffnesses: FloatArray) -> Force:
    """Return the force of a law of ``values`` (variant, parameter); ``stiffnesses`` (variant, part): factors."""
    cause: Any = candidate.build(*(values[:, i, None] for i in range(values.shape[1])))
    law = cause.law(nominal.built)
    own = law if candidate.part is None else law.with_stiffness(stiffnesses[:, candidate.part, None])
    force: Force = own.force
    return force
