"""The lists of a structure file, read item by item: what cannot be read becomes None, so that the others still count.

Each function adds to ``faults`` what it finds and returns the items with their places.
"""

from collections.abc import Callable
from dataclasses import dataclass
from inspect import Signature, signature
from itertools import pairwise
from typing import Any, TypeVar

from fe_models.causes import Effect, known_effects
from fe_models.causes.base import words
from fe_models.files.tables import Table, at, did_you_mean, read_list, read_table, read_value, show
from fe_models.sections import SHAPES, Section
from fe_models.structure import Beam, Cable, Element, Spring
from fe_models.structure_checks import check_section

UNKNOWN_SECTION = Section("unknown", 1.0, 1.0, 1.0, 1.0)  # lets reading go on; a file with faults makes no structure

T = TypeVar("T")
Placed = list[tuple[str, T | None]]


@dataclass(frozen=True)
class _BeamTable:
    nodes: tuple[int, int]
    section: str
    group: str | None = None


@dataclass(frozen=True)
class _CableTable:
    nodes: tuple[int, int]
    section: str
    prestress: float = 0.0
    tension_only: bool = True
    group: str | None = None


KINDS: dict[str, Any] = {"beam": _BeamTable, "cable": _CableTable, "spring": Spring}


def read_nodes(document: Table, where: str, faults: list[str]) -> tuple[tuple[float, float], ...]:
    """Return the points (m); one that cannot be read still counts, so that the numbers of the others hold."""
    if "nodes" not in document:
        faults.append(f"{at(where, 'nodes')}: missing; expected [[x, y], ...] in m")
    places = read_list(document, "nodes", where, faults)
    points = [read_value(tuple[float, float], point, place, faults) for place, point in places]
    # Unread points stand apart from each other, so that no element seems to have no length.
    return tuple(point or (1e6 * number, 1e6) for number, point in enumerate(points))


def read_sections(document: Table, where: str, faults: list[str]) -> dict[str, Section]:
    """Return the sections by name; those with faults are stand-ins, so that elements can refer to them."""
    sections: dict[str, Section] = {}
    for place, table in read_list(document, "sections", where, faults):
        make, rest = (
            _choose("shape", SHAPES, table, place, faults)
            if isinstance(table, dict) and "shape" in table
            else (Section, table)
        )
        section = read_table(make, rest, place, faults) if make else None
        name = table.get("name") if isinstance(table, dict) else None
        if section is not None:
            faults.extend(check_section(place, section))
        if isinstance(name, str):
            if name in sections:
                faults.append(f"{place}: there is already a section {name!r}; give each its own name")
            sections[name] = section or UNKNOWN_SECTION
    return sections


def read_elements(document: Table, where: str, faults: list[str]) -> Placed[Element]:
    """Return the elements, with their sections."""
    sections = read_sections(document, where, faults)
    placed: Placed[Element] = []
    for place, table in read_list(document, "elements", where, faults):
        make, rest = _choose("kind", KINDS, table, place, faults)
        for row in _one_by_one(rest, place, faults) if make else [None]:
            element = read_table(make, _node_as_nodes(row), place, faults) if make else None
            if isinstance(element, _BeamTable | _CableTable):
                element = _with_section(element, sections, place, faults)
            placed.append((place, element))
    return placed


def _with_section(
    table: _BeamTable | _CableTable, sections: dict[str, Section], place: str, faults: list[str]
) -> Beam | Cable:
    if table.section not in sections:
        faults.append(f"{place}.section: there is no section {table.section!r}{did_you_mean(table.section, sections)}")
    section = sections.get(table.section, UNKNOWN_SECTION)
    if isinstance(table, _BeamTable):
        return Beam(table.nodes, section, table.group)
    return Cable(table.nodes, section, table.prestress, table.tension_only, table.group)


def _one_by_one(table: Table, place: str, faults: list[str]) -> list[Table]:
    """Return the tables of the elements that ``through = [1, 2, 3]`` stands for, or the table itself."""
    if "through" not in table:
        return [table]
    rest = {key: value for key, value in table.items() if key != "through"}
    run = read_value(tuple[int, ...], table["through"], f"{place}.through", faults) or ()
    if len(run) == 1 or "nodes" in table or "node" in table:
        faults.append(f"{place}: give either nodes = [first, last] or through = [first, ..., last]")
        return []
    return [rest | {"nodes": list(pair)} for pair in pairwise(run)]


def read_effects(document: Table, where: str, faults: list[str]) -> Placed[Effect]:
    """Return the effects."""
    placed: Placed[Effect] = []
    for place, table in read_list(document, "effects", where, faults):
        make, rest = _choose("kind", known_effects(), table, place, faults)
        if make is None:
            placed.append((place, None))
            continue
        for one, many in (("node", "nodes"), ("element", "elements")):
            if many in words(make):
                rest = _as_list(rest, one, many)
        if "group" in words(make) and "group" in rest:
            rest = {"elements": []} | rest
        placed.append((place, read_table(_in_words(make), rest, place, faults)))
    return placed


def _in_words(make: type[Effect]) -> Callable[..., Effect]:
    """Return a function that makes the effect from its parameters as files name them."""
    names = {word: name for name, word in words(make).items()}

    def made(**values: Any) -> Effect:
        return make(**{names[word]: value for word, value in values.items()})

    parameters = signature(make).parameters
    made.__signature__ = Signature([parameters[name].replace(name=word) for word, name in names.items()])  # type: ignore[attr-defined]
    return made


def read_all(make: Callable[..., T], document: Table, key: str, where: str, faults: list[str]) -> Placed[T]:
    """Return the items of a list whose tables are just the arguments of ``make``."""
    takes_nodes = "nodes" in signature(make).parameters
    return [
        (place, read_table(make, _node_as_nodes(table) if takes_nodes else table, place, faults))
        for place, table in read_list(document, key, where, faults)
    ]


def _choose(key: str, choices: dict[str, Any], table: Any, place: str, faults: list[str]) -> tuple[Any, Table]:
    """Return what ``table[key]`` names among ``choices`` (None if nothing) and the table without it."""
    if not isinstance(table, dict):
        faults.append(f"{place}: expected a table, found {show(table)}")
        return None, {}
    word = table.get(key)
    if not isinstance(word, str) or word not in choices:
        hint = did_you_mean(str(word or ""), choices)
        faults.append(f"{place}.{key}: " + (f"{show(word)} is unknown{hint}" if key in table else f"missing{hint}"))
        return None, {}
    return choices[word], {name: value for name, value in table.items() if name != key}


def _node_as_nodes(table: Any) -> Any:
    """Return the table with ``node = 1`` written as ``nodes = [1]``, which the dataclasses have."""
    return _as_list(table, "node", "nodes")


def _as_list(table: Any, one: str, many: str) -> Any:
    """Return the table with ``one = 1`` written as ``many = [1]``."""
    if not isinstance(table, dict) or one not in table or many in table:
        return table
    return {many: [table[one]]} | {key: value for key, value in table.items() if key != one}
