"""Drag that grows with the square of the velocity."""

from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

from fe_models.causes.arithmetic import absolute
from fe_models.causes.base import negative_faults, parameter
from fe_models.causes.candidate import LawCandidate
from fe_models.causes.connector import ConnectorEffect, law_at
from fe_models.causes.known import Known
from fe_models.one_node import node_or_nodes
from fe_models.structure import Structure


@node_or_nodes
@dataclass(frozen=True)
class QuadraticDamper(ConnectorEffect):
    """Drag, as of air or water: force = coefficient v |v|."""

    kind: ClassVar[str] = "quadratic_damper"
    template: ClassVar[str] = "drag of {coefficient} acts {at}"
    coefficient: float = parameter("N s^2/m^2", "N m s^2/rad^2")

    def force(self, u: Any, v: Any, t: Any = 0.0) -> Any:
        """Return coefficient * v * |v| (N)."""
        return self.coefficient * v * absolute(v)

    def faults(self, structure: Structure) -> list[str]:
        """Return faults; a negative coefficient would feed energy in."""
        return super().faults(structure) + negative_faults(coefficient=self.coefficient)

    @classmethod
    def candidates(cls, known: Known) -> list[LawCandidate]:
        """Return one at each place that moves, as strong at the usual rate as the usual dashpot."""
        return [
            law_at(
                moving.place,
                ("coefficient",),
                partial(cls, *moving.place.at),
                width=(moving.place.coefficient / moving.speed,),
                lower=(0.0,),
            )
            for moving in known.moving_places
        ]
