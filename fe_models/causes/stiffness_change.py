"""Elements that are softer, or stiffer, than drawn."""

from dataclasses import dataclass, replace
from typing import ClassVar

from fe_models.causes.base import Part, count_faults, element_faults, negative_faults, parameter, value_of
from fe_models.structure import Cable, Element, Spring, Structure


@dataclass(frozen=True)
class StiffnessChange(Part):
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
