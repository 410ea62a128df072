"""A spring that resists more one way than the other."""

from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

from fe_models.causes.base import parameter
from fe_models.causes.candidate import UNBOUNDED, LawCandidate
from fe_models.causes.connector import ConnectorEffect, law_at
from fe_models.causes.known import Known
from fe_models.one_node import node_or_nodes


@node_or_nodes
@dataclass(frozen=True)
class QuadraticSpring(ConnectorEffect):
    """The asymmetry of a spring, without its linear part: force = stiffness u^2.

    With a positive stiffness the spring hardens under positive elongation and softens under negative.
    """

    kind: ClassVar[str] = "quadratic_spring"
    template: ClassVar[str] = "a quadratic spring of {stiffness} acts {at} (positive: harder where it is elongated)"
    stiffness: float = parameter("N/m^2", "N m/rad^2")

    def force(self, u: Any, v: Any, t: Any = 0.0) -> Any:
        """Return stiffness * u^2 (N)."""
        return self.stiffness * u * u

    @classmethod
    def candidates(cls, known: Known) -> list[LawCandidate]:
        """Return one at each place that moves, as stiff at the usual elongation as what is there."""
        return [
            law_at(
                moving.place,
                ("stiffness",),
                partial(cls, *moving.place.at),
                width=(moving.place.stiffness / (2 * moving.size),),
                lower=UNBOUNDED,
            )
            for moving in known.moving_places
        ]
