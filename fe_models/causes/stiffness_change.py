"""Elements that are softer, or stiffer, than drawn."""

from dataclasses import dataclass, replace
from functools import partial
from typing import ClassVar

from fe_models.causes.base import Part, count_faults, elements_of, group_faults, negative_faults, parameter, value_of
from fe_models.causes.candidate import ChangeCandidate
from fe_models.causes.known import Known
from fe_models.causes.searched import Searched
from fe_models.structure import Cable, Element, Spring, Structure

PRIOR_STD_SHARE = 0.5  # of an element's stiffness: the prior standard deviation
REMAINING_SHARES = (0.02, 0.05, 0.12, 0.25)  # of a stiffness: what may be left of an element that is all but lost; its
# compliance, which is felt, goes to infinity


@dataclass(frozen=True)
class StiffnessChange(Searched, Part):
    """Elements whose stiffness is ``factor`` times the nominal one (1: as drawn, 0: lost); their mass stays.

    All forces of the element are multiplied: K_e -> factor K_e, a cable's prestress and, where the structure has
    damping proportional to stiffness, its share of that, too. ``factor`` is one for all elements, or one for each.
    A ``group``, by its name, stands for all its elements; of matrices for its share of K: K + (factor - 1) K_group.
    """

    kind: ClassVar[str] = "stiffness_change"
    template: ClassVar[str] = "{place} has {factor} times its nominal stiffness"
    elements: tuple[int, ...]
    factor: float | tuple[float, ...] = parameter("1")
    group: str = ""

    @property
    def location(self) -> dict[str, object]:
        """The element, the elements or the group."""
        if self.group:
            return {"group": self.group}
        return {"element": self.elements[0]} if len(self.elements) == 1 else {"elements": list(self.elements)}

    def extend(self, structure: Structure) -> Structure:
        """Return the structure with the elements' stiffness multiplied."""
        elements = list(structure.elements)
        for position, number in enumerate(elements_of(structure, self.elements, self.group)):
            elements[number - 1] = scaled(elements[number - 1], value_of(self.factor, position))
        return replace(structure, elements=tuple(elements))

    def faults(self, structure: Structure) -> list[str]:
        """Return faults of the elements and of the factors."""
        faults = group_faults(structure, self.elements, self.group)
        places = elements_of(structure, self.elements, self.group)
        faults += count_faults("factor", self.factor, places) if places else []
        factors = self.factor if isinstance(self.factor, tuple) else (self.factor,)
        return faults + self.number_faults() + [fault for value in factors for fault in negative_faults(factor=value)]

    @classmethod
    def candidates(cls, known: Known) -> list[ChangeCandidate]:
        """Return each element, and each group that is uncertain as a whole, softer or stiffer."""
        return [
            ChangeCandidate(
                kind=cls.kind,
                location=cls(numbers, 1.0).location,
                names=("factor",),
                build=partial(cls, numbers),
                neutral=(1.0,),
                width=(PRIOR_STD_SHARE,),
                lower=(0.0,),
                far=REMAINING_SHARES,
                changes=known.nominal.changes_of(cls(numbers, 2.0)),
                part=known.part_of(numbers),
            )
            for numbers in known.element_groups
        ]


def scaled(element: Element, factor: float) -> Element:
    """Return ``element`` with all its forces multiplied by ``factor``."""
    if isinstance(element, Spring):
        return replace(element, stiffness=factor * element.stiffness)
    element = replace(element, section=replace(element.section, youngs_modulus=factor * element.section.youngs_modulus))
    return replace(element, prestress=factor * element.prestress) if isinstance(element, Cable) else element
