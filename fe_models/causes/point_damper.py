"""A linear damper at one place."""

from dataclasses import dataclass, replace
from functools import partial
from typing import ClassVar

from fe_models.causes.base import Part, node_faults, parameter
from fe_models.causes.candidate import UNBOUNDED, DashpotCandidate
from fe_models.causes.known import Known, outer
from fe_models.causes.searched import Searched
from fe_models.one_node import node_or_nodes
from fe_models.structure import Dashpot, Direction, Structure


@node_or_nodes
@dataclass(frozen=True)
class PointDamper(Searched, Part):
    """A linear damper between a node and the ground, or between two nodes: force = coefficient v, C += c b b^T.

    Negative: less damping there than the model has.
    """

    kind: ClassVar[str] = "point_damper"
    template: ClassVar[str] = "a damper of {coefficient} acts {at}"
    negative_template: ClassVar[str] = "the model has {coefficient} of damping too much {at}"
    nodes: tuple[int] | tuple[int, int]
    direction: Direction
    coefficient: float = parameter("N s/m", "N m s/rad")

    def extend(self, structure: Structure) -> Structure:
        """Return the structure with the dashpot."""
        dashpot = Dashpot(self.nodes, self.direction, self.coefficient)
        return replace(structure, dashpots=(*structure.dashpots, dashpot))

    def faults(self, structure: Structure) -> list[str]:
        """Return faults of the place and of the coefficient."""
        return node_faults(structure, self.nodes, self.direction) + self.number_faults()

    @classmethod
    def candidates(cls, known: Known) -> list[DashpotCandidate]:
        """Return a damper at each place."""
        return [
            DashpotCandidate(
                kind=cls.kind,
                location=place.location,
                names=("coefficient",),
                build=partial(cls, *place.at),
                neutral=(0.0,),
                width=(place.coefficient,),
                lower=UNBOUNDED,
                changes=(known.zeros, outer(place.pull), known.zeros),
                twins=place.twins,
            )
            for place in known.places
        ]
