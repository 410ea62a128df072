"""The parts of a structure whose stiffness or mass its owner knows only within a tolerance, each as a whole.

Every group of elements that its owner named has one stiffness, so have all beams without a group together, and every
other cable and spring; so has the mass of every group with beams, with the point masses along it, and every other point
mass.
"""

from collections import defaultdict
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.sections import Section
from fe_models.structure import Beam, Element, Spring, Structure

# of the nodes of a group of beams: where as many carry point masses these are its own mass, lumped
MIN_LUMPED_SHARE = 0.5
# Correlation of what is off in two parts of one section: cables of one kind come from one lot and one data sheet, and
# the towers of a bridge from one drawing; each is also made and fixed by itself.
SECTION_ALIKE = 0.5


@dataclass(frozen=True)
class UncertainPart:
    """The stiffness of ``elements``, or the mass of ``elements`` and of the point masses at ``nodes``; from 1.

    Of matrices, which have no elements: of a ``group``, by its name.
    """

    quantity: Literal["stiffness", "mass"]
    elements: tuple[int, ...]
    nodes: tuple[int, ...] = ()
    group: str = ""

    @property
    def location(self) -> dict[str, Any]:
        """Where it is, in the words of a report."""
        if self.group:
            return {"group": self.group}
        if not self.elements:
            return {"node": self.nodes[0]}
        return {"element": self.elements[0]} if len(self.elements) == 1 else {"elements": list(self.elements)}

    def scaled(self, structure: Structure, factor: float) -> Structure:
        """Return ``structure`` with this part's stiffness or mass ``factor`` times as large."""
        elements = tuple(
            self._scaled_element(element, factor) if number in self.elements else element
            for number, element in enumerate(structure.elements, start=1)
        )
        if self.quantity == "stiffness":
            return replace(structure, elements=elements)
        masses = tuple(
            replace(point, mass=point.mass * factor) if point.node in self.nodes else point
            for point in structure.point_masses
        )
        return replace(structure, elements=elements, point_masses=masses)

    def _scaled_element(self, element: Element, factor: float) -> Element:
        if isinstance(element, Spring):
            return replace(element, stiffness=element.stiffness * factor) if self.quantity == "stiffness" else element
        section = element.section
        where = f" in {self.elements[0]}-{self.elements[-1]}"  # other elements may keep the section as it is
        section = replace(section, name=section.name.removesuffix(where) + where)
        if self.quantity == "stiffness":
            return replace(element, section=replace(section, youngs_modulus=section.youngs_modulus * factor))
        return replace(element, section=replace(section, density=section.density * factor))


def uncertain_parts(structure: Structure) -> tuple[UncertainPart, ...]:
    """Return all stiffnesses, then all masses; the wires' own mass, which nothing feels, goes with no part."""
    groups, single = defaultdict[str | None, list[int]](list), []
    for number, element in enumerate(structure.elements, start=1):
        if isinstance(element, Beam) or element.group is not None:
            groups[element.group].append(number)
        else:
            single.append(number)
    stiffness = sorted([*map(tuple, groups.values()), *((number,) for number in single)])
    masses, carrying = [], {point.node for point in structure.point_masses}
    loose = set(carrying)
    for numbers in with_mass(structure, groups.values()):
        nodes = _nodes(structure, numbers)
        along = nodes & loose if len(nodes & carrying) >= MIN_LUMPED_SHARE * len(nodes) else set()
        loose -= along
        masses.append(UncertainPart("mass", numbers, tuple(sorted(along))))
    return (
        *(UncertainPart("stiffness", numbers) for numbers in stiffness),
        *masses,
        *(UncertainPart("mass", (), (node,)) for node in sorted(loose)),
    )


def part_correlations(structure: Structure, parts: Sequence[UncertainPart]) -> FloatArray:
    """Return how far deviations of parts go together beforehand, (part, part): of one quantity and one section."""
    sections = [_section(structure, part) for part in parts]
    found = np.eye(len(parts))
    for one, first in enumerate(parts):
        for two, second in enumerate(parts[:one]):
            if sections[one] is not None and sections[one] == sections[two] and first.quantity == second.quantity:
                found[one, two] = found[two, one] = SECTION_ALIKE
    return found


def _section(structure: Structure, part: UncertainPart) -> Section | None:
    """Return the section that all elements of a part have, None where they have several, or none."""
    members = [structure.elements[number - 1] for number in part.elements]
    sections = {None if isinstance(own, Spring) else own.section for own in members}
    return sections.pop() if len(sections) == 1 else None


def with_mass(structure: Structure, groups: Iterable[Iterable[int]]) -> list[tuple[int, ...]]:
    """Return the numbers of those elements of each of the ``groups`` with beams that have mass: all but springs."""
    members = [[(number, structure.elements[number - 1]) for number in numbers] for numbers in groups]
    return [
        tuple(number for number, element in group if not isinstance(element, Spring))
        for group in members
        if any(isinstance(element, Beam) for _, element in group)
    ]


def _nodes(structure: Structure, numbers: Iterable[int]) -> set[int]:
    return {node for number in numbers for node in structure.elements[number - 1].nodes}
