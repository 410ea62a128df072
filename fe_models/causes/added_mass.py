"""A mass that the model does not know of."""

from dataclasses import dataclass, replace
from typing import ClassVar

from fe_models.causes.base import Part, node_faults, parameter
from fe_models.structure import PointMass, Structure


@dataclass(frozen=True)
class AddedMass(Part):
    """A mass (kg; negative: removed) at a node, felt by its translations: M_ii += mass."""

    kind: ClassVar[str] = "added_mass"
    node: int
    mass: float = parameter("kg")

    def extend(self, structure: Structure) -> Structure:
        """Return the structure with the mass."""
        return replace(structure, point_masses=(*structure.point_masses, PointMass(self.node, self.mass)))

    def faults(self, structure: Structure) -> list[str]:
        """Return faults of the node and of the mass."""
        return node_faults(structure, (self.node,)) + self.number_faults()
