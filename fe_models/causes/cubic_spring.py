"""A spring that grows stiffer, or softer, with its elongation."""

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
class CubicSpring(ConnectorEffect):
    """A hardening (or, negative, softening) spring without linear part: force = stiffness u^3."""

    kind: ClassVar[str] = "cubic_spring"
    template: ClassVar[str] = "a cubic spring of {stiffness} acts {at} (positive: hardening)"
    stiffness: float = parameter("N/m^3", "N m/rad^3")

    def force(self, u: Any, v: Any, t: Any = 0.0) -> Any:
        """Return stiffness * u^3 (N)."""
        return self.stiffness * u * u * u

    @classmethod
    def candidates(cls, known: Known) -> list[LawCandidate]:
        """Return one at each place that moves, as stiff at the usual elongation as what is there."""
        return [
            law_at(
                moving.place,
                ("stiffness",),
                partial(cls, *moving.place.at),
                width=(moving.place.stiffness / (3 * moving.size**2),),
                lower=UNBOUNDED,
            )
            for moving in known.moving_places
        ]
