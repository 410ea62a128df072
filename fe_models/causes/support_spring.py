"""A spring to the ground: a restraint that the model lacks, or a support that is too soft."""

from dataclasses import dataclass, replace
from typing import ClassVar, Literal

from fe_models.causes.base import Part, negative_faults, node_faults, parameter
from fe_models.structure import Spring, Structure, Support


@dataclass(frozen=True)
class SupportSpring(Part):
    """A spring between a node and the ground: K_ii += stiffness.

    Where a support holds the node in that direction, the spring takes the support's place (a support too soft; 0:
    lost). Elsewhere it is a restraint that the model lacks, or, negative, takes something from one that it has.
    """

    kind: ClassVar[str] = "support_spring"
    node: int
    direction: Literal["x", "y", "rz"]
    stiffness: float = parameter("N/m", "N m/rad")

    def extend(self, structure: Structure) -> Structure:
        """Return the structure with the spring, and without the support in its direction."""
        supports = []
        for support in structure.supports:
            if support.node == self.node:
                kept = tuple(direction for direction in support.directions if direction != self.direction)
                support = Support(support.node, kept)
            if support.directions:
                supports.append(support)
        spring = Spring((self.node,), self.direction, self.stiffness, group=self.kind)
        return replace(structure, elements=(*structure.elements, spring), supports=tuple(supports))

    def faults(self, structure: Structure) -> list[str]:
        """Return faults of the place and of the stiffness."""
        faults = node_faults(structure, (self.node,), self.direction) + self.number_faults()
        held = any(s.node == self.node and self.direction in s.directions for s in structure.supports)
        return faults + (negative_faults(stiffness=self.stiffness) if held else [])
