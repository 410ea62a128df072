"""What all causes of a wrong simulation have in common, and the two ways in which a structure's effects act."""

from abc import ABC
from collections.abc import Mapping
from dataclasses import field, fields
from math import isfinite
from numbers import Integral, Real
from typing import Any, ClassVar, get_args

from fe_models.causes.force_law import ForceLaw
from fe_models.causes.wording import sentence
from fe_models.structure import ROTATIONS, Carried, Direction, Structure, group_name


def parameter(unit: str, turning: str = "", word: str = "", **options: Any) -> Any:
    """Return the dataclass field of a parameter in ``unit``, or ``turning`` where the direction is a rotation.

    ``word`` is its name in files and reports, where that differs from the attribute's.
    """
    return field(metadata={"unit": unit, "turning": turning or unit, "word": word}, **options)


def setting(unit: str, default: float) -> Any:
    """Return the dataclass field of a number that belongs to the numerics and is no finding."""
    return field(default=default, metadata={"setting": unit})


def words(cause: "type[Cause] | Cause") -> dict[str, str]:
    """Return the word of each field in files and reports, by the attribute's name."""
    return {item.name: item.metadata.get("word") or item.name for item in fields(cause)}  # type: ignore[arg-type]


NUMBERED = frozenset({"node", "nodes", "element", "elements", "modes"})
"""Fields of a location that hold numbers of parts."""

CAUSES: dict[str, "type[Cause]"] = {}
"""All causes by their words; each registers itself where it is defined."""


class Cause(ABC):
    """Something a simulation may lack or get wrong: a frozen dataclass of a location and of parameters with units.

    A class with a ``kind`` of its own is a cause that files may name and a diagnosis may find. ``template``: what it
    does, for its `sentence`, with its place as "{place}" or, after a preposition, "{at}", and its parameters by their
    words; ``negative_template``: the same where these are negative, without their signs.
    """

    kind: ClassVar[str]
    template: ClassVar[str]
    negative_template: ClassVar[str] = ""

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        if "kind" not in cls.__dict__:  # what several causes have in common
            return
        if cls.kind in CAUSES:
            raise TypeError(f"{cls.__name__}: there is a cause {cls.kind!r} already, {CAUSES[cls.kind].__name__}")
        CAUSES[cls.kind] = cls

    def sentence(self, values: Mapping[str, str], structure: Structure) -> str:
        """Return one sentence that an engineer can act on.

        ``values``: each parameter, with uncertainty and unit, in words; ``structure``: the nominal one.
        """
        negative = bool(self.negative_template) and all(own.startswith("-") for own in values.values())
        if negative:
            values = {word: own.removeprefix("-") for word, own in values.items()}
        return sentence(self.negative_template if negative else self.template, self.location, **values)

    @property
    def location(self) -> dict[str, Any]:
        """Where it acts, in the words of a report: ``{"node": 1, "direction": "x"}``, ``{"elements": [3, 4]}``."""
        place = {item.name: getattr(self, item.name) for item in fields(self) if not item.metadata}  # type: ignore[arg-type]
        if len(place.get("nodes", ())) == 1:
            place = {"node": place.pop("nodes")[0]} | place
        return {name: list(value) if isinstance(value, tuple) else value for name, value in place.items()}

    @property
    def parameters(self) -> dict[str, float | list[float]]:
        """How much: each parameter's value, in SI units; lists where the location lists several and values differ."""
        values = {word: getattr(self, name) for name, word in words(self).items() if word in self.units}
        return {word: list(value) if isinstance(value, tuple) else value for word, value in values.items()}

    @property
    def units(self) -> dict[str, str]:
        """The SI unit of each parameter."""
        which = "turning" if getattr(self, "direction", "") in ROTATIONS else "unit"
        names = words(self)
        return {names[item.name]: item.metadata[which] for item in fields(self) if "unit" in item.metadata}  # type: ignore[arg-type]

    def type_faults(self) -> list[str]:
        """Return a fault for each number that is none, and for a direction that there is not."""
        faults = []
        for item in fields(self):  # type: ignore[arg-type]
            value = getattr(self, item.name)
            values = value if isinstance(value, tuple | list) else (value,)
            kind, expected = (Real, "a number") if item.metadata else (Integral, "an integer")
            if not item.metadata and item.name not in NUMBERED:
                continue
            if any(isinstance(one, bool) or not isinstance(one, kind) for one in values if one is not None):
                faults.append(f"{item.name} = {value!r}; expected {expected}")
        direction = getattr(self, "direction", "x")
        if direction not in get_args(Direction):
            faults.append(f"direction = {direction!r}; expected one of {', '.join(get_args(Direction))}")
        return faults

    def number_faults(self) -> list[str]:
        """Return a fault for each number that is not finite."""
        faults = []
        for name, word in words(self).items():
            value = getattr(self, name)
            numbers = value if isinstance(value, tuple) else (value,)
            if any(isinstance(number, float) and not isfinite(number) for number in numbers):
                faults.append(f"{word} = {value}; must be finite")
        return faults


class Effect(Cause, Carried):
    """A cause that is part of a structure."""

    def extend(self, structure: Structure) -> Structure:
        """Return ``structure`` with what of this effect can be said in plain parts; by default nothing."""
        return structure

    def law(self, structure: Structure) -> ForceLaw | None:
        """Return the force that this effect adds to the linear model of ``structure``, None for linear effects."""
        return None


class Part(Effect):
    """An effect that is a spring, a mass or a dashpot: `extend` says all of it."""


def known_effects() -> dict[str, type[Effect]]:
    """Return the causes that are part of a structure, by their words."""
    return {kind: cause for kind, cause in CAUSES.items() if issubclass(cause, Effect)}


def node_faults(structure: Structure, nodes: tuple[int, ...], direction: str | None = None) -> list[str]:
    """Return faults of nodes, and of a direction they need, against those that the structure has."""
    count = len(structure.nodes)
    faults = [f"node {node} does not exist; the nodes are 1 to {count}" for node in nodes if not 1 <= node <= count]
    if len(set(nodes)) < len(nodes):
        faults.append(f"joins node {nodes[0]} to itself; give two different nodes")
    if direction is not None and direction not in structure.directions:
        have = ", ".join(structure.directions)
        faults.append(f"direction {direction!r} is not among those of the nodes, {have}")
    return faults


def element_faults(structure: Structure, elements: tuple[int, ...]) -> list[str]:
    """Return faults of element numbers: none, unknown, twice the same."""
    count = len(structure.elements)
    faults = [] if elements else ["elements: there are none; give their numbers"]
    faults += [f"element {i} does not exist; the elements are 1 to {count}" for i in elements if not 1 <= i <= count]
    faults += [
        f"element {i} is given {elements.count(i)} times" for i in sorted(set(elements)) if elements.count(i) > 1
    ]
    return faults


def group_faults(structure: Structure, elements: tuple[int, ...], group: str) -> list[str]:
    """Return faults of what is named by its ``group``, or by the numbers of its ``elements``."""
    if not group:
        return element_faults(structure, elements)
    if elements:
        return [f"names group {group!r} and elements; give one of them"]
    known = dict.fromkeys(group_name(element) for element in structure.elements)
    return [] if group in known else [f"there is no group {group!r}; the groups are {', '.join(known)}"]


def elements_of(structure: Structure, elements: tuple[int, ...], group: str) -> tuple[int, ...]:
    """Return the numbers of ``elements``, or of those that a ``group`` has: where nobody gave that name, of all of the
    kind that it names ("beam") without one.
    """
    if not group:
        return elements
    numbered = list(enumerate(structure.elements, start=1))
    given = tuple(number for number, element in numbered if element.group == group)
    return given or tuple(number for number, element in numbered if group_name(element) == group)


def value_of(values: float | tuple[float, ...], position: int) -> float:
    """Return the value for one of several places: ``values`` is one number for all, or one for each."""
    return values[position] if isinstance(values, tuple) else values


def count_faults(name: str, values: float | tuple[float, ...], places: tuple[int, ...]) -> list[str]:
    """Return a fault where a list of values is not as long as that of the places."""
    if not isinstance(values, tuple) or len(values) == len(places):
        return []
    return [f"{name} lists {len(values)} values for {len(places)} places; give one each, or one number for all"]


def negative_faults(**values: float) -> list[str]:
    """Return a fault for each value below zero."""
    return [f"{name} = {value}; must not be negative" for name, value in values.items() if value < 0]
