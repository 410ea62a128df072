"""Linear effects that are other springs, masses and dashpots than drawn: they become parts of the structure."""

from dataclasses import dataclass, replace
from typing import ClassVar, Literal

from fe_models.effects.base import (
    Effect,
    count_faults,
    element_faults,
    negative_faults,
    node_faults,
    parameter,
    value_of,
)
from fe_models.structure import Cable, Dashpot, Element, PointMass, Spring, Structure, Support


@dataclass(frozen=True)
class StiffnessChange(Effect):
    """Elements whose stiffness is ``factor`` times the nominal one (1: as drawn, 0: lost); their mass stays.

    All forces of the element are multiplied: K_e -> factor K_e, a cable's prestress and, where the structure has
    damping proportional to stiffness, its share of that, too. ``factor`` is one for all elements, or one for each.
    """

    kind: ClassVar[str] = "stiffness_change"
    elements: tuple[int, ...]
    factor: float | tuple[float, ...] = parameter("1")

    @property
    def location(self) -> dict[str, object]:
        """The element, or the elements."""
        return {"element": self.elements[0]} if len(self.elements) == 1 else {"elements": list(self.elements)}

    def extend(self, structure: Structure) -> Structure:
        """Return the structure with the elements' stiffness multiplied."""
        elements = list(structure.elements)
        for position, number in enumerate(self.elements):
            elements[number - 1] = scaled(elements[number - 1], value_of(self.factor, position))
        return replace(structure, elements=tuple(elements))

    def faults(self, structure: Structure) -> list[str]:
        """Return faults of the elements and of the factors."""
        faults = element_faults(structure, self.elements) + count_faults("factor", self.factor, self.elements)
        factors = self.factor if isinstance(self.factor, tuple) else (self.factor,)
        return faults + self.number_faults() + [fault for value in factors for fault in negative_faults(factor=value)]


def scaled(element: Element, factor: float) -> Element:
    """Return ``element`` with all its forces multiplied by ``factor``."""
    if isinstance(element, Spring):
        return replace(element, stiffness=factor * element.stiffness)
    element = replace(element, section=replace(element.section, youngs_modulus=factor * element.section.youngs_modulus))
    return replace(element, prestress=factor * element.prestress) if isinstance(element, Cable) else element


@dataclass(frozen=True)
class AddedMass(Effect):
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


@dataclass(frozen=True)
class SupportSpring(Effect):
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


@dataclass(frozen=True)
class PointDamper(Effect):
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
