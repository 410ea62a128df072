"""Structures as TOML files, so that a frame needs no Python. All units SI.

::

    schema = 1
    name = "portal"
    nodes = [[0.0, 0.0], [0.0, 3.0], [4.0, 3.0], [4.0, 0.0]]   # (x, y) in m, numbered from 1
    directions = ["x", "y", "rz"]      # what every node can do (this is the default); ["x"] for a chain
    divisions = 1                      # finite elements a beam (default 1)

    [[sections]]                       # area and second_moment, or a shape with its dimensions:
    name = "column"                    # square_tube (side, wall), round_tube (diameter, wall),
    youngs_modulus = 2.1e11            # rectangle (width, height), round_bar (diameter),
    density = 7850.0                   # round_wire (diameter, no bending stiffness)
    shape = "square_tube"
    side = 0.1
    wall = 0.004

    [[elements]]
    kind = "beam"                      # "beam", "cable" (also: prestress; tension_only = false for a bar) or
    through = [1, 2, 3, 4]             # "spring" (direction, stiffness; node = 1 for one to ground)
    section = "column"                 # through: one element after the other; nodes = [1, 2]: one alone
    group = "frame"                    # a free name; to the diagnosis, a group's stiffness is off as a whole; springs
                                       # and cables without one each by itself. So is its mass, with point masses
                                       # that half of its nodes carry: name a group a storey where floors weigh apart

    [[supports]]
    node = 1
    directions = ["x", "y", "rz"]

A list may also be written in one piece, ``supports = [{ node = 1, directions = ["y"] }, ...]``. Further lists:
``point_masses`` (node, mass), ``dashpots`` (node or nodes, direction, coefficient), ``effects`` (see below); table
``damping`` (mass_factor, stiffness_factor, modal_ratios).

``effects`` are what the drawn structure lacks (`fe_models.causes`), each with its ``kind``, place and parameters:
stiffness_change (element or elements, factor), mass_change (elements, factor), added_mass (node, mass),
support_spring (node, direction, stiffness),
axial_force (elements, force), dead_load (; share), modal_damping (modes, ratio); and, with node or nodes and direction,
point_damper (coefficient), quadratic_damper (coefficient), coulomb_friction (force; regularisation), cubic_spring
(stiffness), quadratic_spring (stiffness), gap_stop (gap, stiffness, side), hysteretic_spring (stiffness, force,
sharpness); slack_cable (element, pretension);
harmonic_force (node, direction, amplitude, frequency; phase). What follows a semicolon may be left out. Of factor,
force and ratio one stands for all places, or a list holds one for each; of mass_change's factor one stands for all.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Literal, TypeVar

from fe_models.causes import Effect
from fe_models.causes.base import words
from fe_models.causes.laws import effects_of
from fe_models.errors import raise_faults
from fe_models.files.atomic import write_text
from fe_models.files.structure_parts import read_all, read_effects, read_elements, read_nodes
from fe_models.files.tables import Table, at, check_keys, parse_toml, read_table, read_toml, read_value
from fe_models.files.toml_text import toml_text
from fe_models.sections import Section
from fe_models.structure import (
    PLANE_FRAME,
    Beam,
    Cable,
    Damping,
    Dashpot,
    Direction,
    PointMass,
    Structure,
    Support,
)
from fe_models.structure_checks import (
    check_frame,
    check_held,
    check_item,
    check_structure,
    check_supports,
    require_structure,
)

T = TypeVar("T")

LISTS = ("sections", "elements", "point_masses", "dashpots", "supports", "effects")


@dataclass(frozen=True)
class _Header:
    schema: Literal[1]
    name: str
    directions: tuple[Direction, ...] = PLANE_FRAME
    divisions: int = 1


def load_structure(path: Path) -> Structure:
    """Read a structure file; `InputError` carries all its faults."""
    return parse_structure(read_toml(path), path.name)


def save_structure(structure: Structure, path: str | Path) -> None:
    """Write a valid structure, so that `load_structure` returns an equal one; `InputError` carries its faults."""
    write_text(Path(path), structure_text(structure))


def structure_text(structure: Structure) -> str:
    """Return a valid structure as the text of its file; `InputError` carries its faults."""
    require_structure(structure)
    return toml_text(structure_table(structure))


def structure_from_text(text: str, file_name: str) -> Structure:
    """Return the structure that the text of a file describes; ``file_name`` is for messages."""
    return parse_structure(parse_toml(text, file_name), file_name)


def parse_structure(document: Table, file_name: str) -> Structure:
    """Return the structure that a parsed TOML document describes; ``file_name`` is for messages."""
    where, faults = f"{file_name}:", list[str]()
    header_keys = [item.name for item in fields(_Header)]
    check_keys(document, [*header_keys, "nodes", "damping", *LISTS], where, faults)
    header = read_table(_Header, {key: document[key] for key in header_keys if key in document}, where, faults)
    damping = read_table(Damping, _one_ratio_as_list(document.get("damping", {})), at(where, "damping"), faults)
    elements = read_elements(document, where, faults)
    masses = read_all(PointMass, document, "point_masses", where, faults)
    dashpots = read_all(Dashpot, document, "dashpots", where, faults)
    supports = read_all(Support, document, "supports", where, faults)
    effects = read_effects(document, where, faults)
    structure = Structure(
        name=header.name if header else "",
        nodes=read_nodes(document, where, faults),
        elements=_those_read(elements),
        point_masses=_those_read(masses),
        dashpots=_those_read(dashpots),
        supports=_those_read(supports),
        directions=header.directions if header else _directions_alone(document),
        damping=damping or Damping(),
        effects=_those_read(effects),
        divisions=header.divisions if header else 1,
    )
    # From here on what depends on several parts, among those that could be read.
    if structure.nodes:
        faults.extend(f"{where} {fault}" for fault in check_frame(structure))
    for place, item in (*elements, *masses, *dashpots, *supports, *effects):
        faults.extend(check_item(structure, place, item) if item is not None else [])
    faults.extend(f"{where} {fault}" for fault in check_supports(structure))
    if all(item is not None for _, item in (*elements, *supports)):
        faults.extend(f"{where} {fault}" for fault in check_held(structure))
    raise_faults(dict.fromkeys(faults) or [f"{where} {fault}" for fault in check_structure(structure)])
    return structure


def structure_table(structure: Structure) -> Table:
    """Return the structure as the TOML document that `parse_structure` reads; defaults are left out."""
    sections = dict.fromkeys(item.section for item in structure.elements if isinstance(item, Beam | Cable))
    table: Table = {
        "schema": 1,
        "name": structure.name,
        "directions": list(structure.directions),
        "divisions": structure.divisions,
        "nodes": [[float(x), float(y)] for x, y in structure.nodes],
        "sections": [_row(section) for section in sections],
        "elements": [{"kind": type(element).__name__.lower()} | _row(element) for element in structure.elements],
        "point_masses": [_row(mass) for mass in structure.point_masses],
        "dashpots": [_row(dashpot) for dashpot in structure.dashpots],
        "supports": [_row(support) for support in structure.supports],
        "damping": _row(structure.damping),
        "effects": [effect_row(effect) for effect in effects_of(structure)],
    }
    return {key: value for key, value in table.items() if value not in ([], {})}


def _row(item: Any) -> Table:
    """Return a part of the structure as a table, without what its defaults say."""
    row: Table = {}
    for part in fields(item):
        value = getattr(item, part.name)
        if value != part.default:
            row[part.name] = value.name if isinstance(value, Section) else _plain(value)
    if len(row.get("nodes", ())) == 1:
        row = {"node": row.pop("nodes")[0]} | row
    if row.get("modal_ratios") == []:
        del row["modal_ratios"]
    return row


def effect_row(effect: Effect) -> Table:
    """Return an effect as a table, with all its numbers, in the words of its kind."""
    row = {word: _plain(getattr(effect, name)) for name, word in words(effect).items()}
    for one, many in (("node", "nodes"), ("element", "elements")):
        if len(row.get(many, ())) == 1:
            row = {one: row.pop(many)[0]} | row
    if "group" in row:  # either says where
        row.pop("elements" if row["group"] else "group", None)
    return {"kind": effect.kind} | row


def _plain(value: Any) -> Any:
    """Return a value with tuples as lists."""
    return [_plain(item) for item in value] if isinstance(value, tuple) else value


def _one_ratio_as_list(table: Any) -> Any:
    """Return the damping table with ``modal_ratios = 0.01`` written as a list."""
    ratio = table.get("modal_ratios") if isinstance(table, dict) else None
    if isinstance(ratio, int | float) and not isinstance(ratio, bool):
        return table | {"modal_ratios": [float(ratio)]}
    return table


def _directions_alone(document: Table) -> tuple[Direction, ...]:
    """Return the directions of a file whose header has faults (already noted) for the checks that need them."""
    return read_value(tuple[Direction, ...], document.get("directions"), "", []) or PLANE_FRAME


def _those_read(placed: Sequence[tuple[str, T | None]]) -> tuple[T, ...]:
    return tuple(item for _, item in placed if item is not None)
