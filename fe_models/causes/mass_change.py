"""A group of elements that is heavier, or lighter, than drawn."""

from dataclasses import dataclass
from typing import ClassVar

from fe_models.causes.base import Part, elements_of, group_faults, negative_faults, parameter
from fe_models.structure import Structure
from fe_models.uncertain_parts import UncertainPart, uncertain_parts, with_mass


@dataclass(frozen=True)
class MassChange(Part):
    """Elements whose mass is ``factor`` times the nominal one, with the point masses that stand for their own.

    Which these are: see `uncertain_parts`. Modes tell it of whole groups, whose factors a diagnosis estimates anyway:
    it makes no candidates of its own. A ``group``, by its name, stands for all its elements; of matrices for its share
    of M: M + (factor - 1) M_group.
    """

    kind: ClassVar[str] = "mass_change"
    template: ClassVar[str] = "{place} has {factor} times its nominal mass"
    elements: tuple[int, ...]
    factor: float = parameter("1")
    group: str = ""

    @property
    def location(self) -> dict[str, object]:
        """The element, the elements or the group."""
        if self.group:
            return {"group": self.group}
        return {"element": self.elements[0]} if len(self.elements) == 1 else {"elements": list(self.elements)}

    def extend(self, structure: Structure) -> Structure:
        """Return the structure with the elements' mass multiplied."""
        known = (part for part in uncertain_parts(structure) if part.quantity == "mass")
        named = elements_of(structure, self.elements, self.group)
        numbers = next(iter(with_mass(structure, [named])), named)
        own = next((part for part in known if part.elements == numbers), UncertainPart("mass", numbers))
        return own.scaled(structure, self.factor)

    def faults(self, structure: Structure) -> list[str]:
        """Return faults of the elements and of the factor."""
        faults = group_faults(structure, self.elements, self.group) + self.number_faults()
        return faults + negative_faults(factor=self.factor)
