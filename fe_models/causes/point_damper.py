"""A linear damper at one place."""

from dataclasses import dataclass, replace
from typing import ClassVar, Literal

from fe_models.causes.base import Part, node_faults, parameter
from fe_models.one_node import node_or_nodes
from fe_models.structure import Dashpot, Structure


@node_or_nodes
@dataclass(frozen=True)
class PointDamper(Part):
    """A linear damper between a node and the ground, or between two nodes: force = coefficient v, C += c b b^T.

    Negative: less damping there than the model has.
    """

    kind: ClassVar[str] = "point_damper"
    nodes: tuple[int] | tuple[int, int]
    direction: Literal["x", "y", "rz"]
    coefficient: float = parameter("N s/m", "N m s/rad")

    def extend(self, structure: Structure) -> Structure:
        """Return the structure with the dashpot."""
        dashpot = Dashpot(self.nodes, self.direction, self.coefficient)
        return replace(structure, dashpots=(*structure.dashpots, dashpot))

    def faults(self, structure: Structure) -> list[str]:
        """Return faults of the place and of the coefficient."""
        return node_faults(structure, self.nodes, self.direction) + self.number_faults()
