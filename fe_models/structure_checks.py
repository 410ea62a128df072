"""What must hold for any structure, read from a file or made in Python; each fault is one line, all are returned.

Items are named as in a structure file, numbered from 1: ``elements[3]``, ``supports[1]``.
"""

from collections import Counter
from collections.abc import Iterable, Iterator
from math import isfinite

from fe_models.causes import Effect, PointDamper
from fe_models.causes.laws import with_parts
from fe_models.errors import raise_faults
from fe_models.sections import Section
from fe_models.stability import connection_faults
from fe_models.structure import (
    PLANE_FRAME,
    Beam,
    Cable,
    Dashpot,
    PointMass,
    Spring,
    Structure,
    Support,
)
from fe_models.value_limits import LARGEST

MOST_FINITE_ELEMENTS = 50_000
"""Of a structure after its beams are divided: 150,000 degrees of freedom, of which modes take a minute."""
SMALLEST_PROPERTY = 1e-30  # of a section, in SI units: that of a wire of a few atoms has more
SHORTEST = 1e-9  # m, of an element
Item = Beam | Cable | Spring | PointMass | Dashpot | Support | Effect


def check_structure(structure: Structure) -> list[str]:
    """Return all faults of ``structure``: of its parts, and, where these are sound, of the whole."""
    sections = dict.fromkeys(item.section for item in structure.elements if isinstance(item, Beam | Cable))
    faults = [*check_frame(structure), *_repeated("section name", (section.name for section in sections))]
    for section in sections:
        faults.extend(check_section(f"section {section.name!r}", section))
    for where, item in numbered_items(structure):
        faults.extend(check_item(structure, where, item))
    faults.extend(check_supports(structure) + check_held(structure))
    return faults or connection_faults(with_parts(structure))


def require_structure(structure: Structure) -> Structure:
    """Return ``structure``, or raise one `InputError` with all its faults."""
    raise_faults(f"structure {structure.name!r}: {fault}" for fault in check_structure(structure))
    return structure


def numbered_items(structure: Structure) -> Iterator[tuple[str, Item]]:
    """Yield every part of the structure with its place."""
    for key in ("elements", "point_masses", "dashpots", "supports", "effects"):
        for number, item in enumerate(getattr(structure, key), start=1):
            yield f"{key}[{number}]", item


def check_frame(structure: Structure) -> list[str]:
    """Return faults of nodes, directions, refinement and damping."""
    faults = [] if structure.nodes else ["nodes: there are none; give [x, y] of each, in m"]
    for number, point in enumerate(structure.nodes, start=1):
        if not all(isfinite(value) for value in point):
            faults.append(f"nodes[{number}]: {list(point)} is not a point; both coordinates must be finite")
    if not structure.directions:
        faults.append("directions: there are none; expected some of x, y, rz")
    faults.extend(_repeated("direction", structure.directions))
    unknown = [direction for direction in structure.directions if direction not in PLANE_FRAME]
    faults.extend(f"directions: {direction!r} is unknown; expected some of x, y, rz" for direction in unknown)
    if structure.divisions < 1:
        faults.append(f"divisions = {structure.divisions}; must be 1 (no refinement) or more")
    faults.extend(_size_faults(structure))
    damping = structure.damping
    for name, value in (("mass_factor", damping.mass_factor), ("stiffness_factor", damping.stiffness_factor)):
        faults.extend(_not_negative(f"damping.{name}", value))
    dampers = bool(structure.dashpots) or any(isinstance(effect, PointDamper) for effect in structure.effects)
    other = dampers or damping.mass_factor > 0 or damping.stiffness_factor > 0
    least, why = (-1, " (negative: less than dashpots and Rayleigh damping give)") if other else (0, "")
    for ratio in damping.modal_ratios:
        if not (least < ratio < 1 or ratio == 0):
            faults.append(
                f"damping.modal_ratios: {ratio} is no damping ratio; expected {least} <= ratio < 1 (0.01 is 1 %){why}"
            )
    return faults


def _size_faults(structure: Structure) -> list[str]:
    """Return a fault where the structure has more finite elements than can be computed with."""
    beams = sum(isinstance(element, Beam) for element in structure.elements)
    count = beams * max(structure.divisions, 1) + len(structure.elements) - beams
    size, what = max((count, "finite elements"), (len(structure.nodes), "nodes"))
    if size <= MOST_FINITE_ELEMENTS:
        return []
    of_divisions = f" with divisions = {structure.divisions}" if structure.divisions > 1 else ""
    return [f"the structure has {size} {what}{of_divisions}; at most {MOST_FINITE_ELEMENTS} can be computed with"]


def check_section(where: str, section: Section) -> list[str]:
    """Return faults of one section's properties."""
    faults = []
    for name in ("youngs_modulus", "area"):
        value = getattr(section, name)
        if not (isfinite(value) and value > 0):
            faults.append(f"{where}: {name} = {value}; must be positive")
        elif not SMALLEST_PROPERTY <= value <= LARGEST:
            faults.append(f"{where}: {name} = {value:g}; expected {SMALLEST_PROPERTY:g} to {LARGEST:g}")
    for name in ("density", "second_moment"):
        faults.extend(_not_negative(f"{where}: {name}", getattr(section, name)))
    return faults


def check_item(structure: Structure, where: str, item: Item) -> list[str]:
    """Return faults of one part against the nodes, directions and elements of ``structure``."""
    if isinstance(item, Effect):
        return [f"{where}: {fault}" for fault in item.faults(structure)]
    nodes: tuple[int, ...] = (item.node,) if isinstance(item, PointMass | Support) else item.nodes
    count = len(structure.nodes)
    faults = [f"{where}: node {n} does not exist; the nodes are 1 to {count}" for n in nodes if not 1 <= n <= count]
    if len(set(nodes)) < len(nodes):
        faults.append(f"{where}: joins node {nodes[0]} to itself; give two different nodes")
    faults.extend(_direction_faults(structure, where, item))
    match item:
        case Beam() | Cable():
            if not faults and structure.length(item) < SHORTEST:
                faults.append(f"{where}: has no length; nodes {nodes[0]} and {nodes[1]} lie on the same point")
            if isinstance(item, Beam) and item.section.second_moment == 0:
                faults.append(f"{where}: a beam needs a second_moment above 0, section {item.section.name!r} has none")
            if isinstance(item, Cable):
                faults.extend(_not_negative(f"{where}: prestress", item.prestress))
        case Spring():
            faults.extend(_not_negative(f"{where}: stiffness", item.stiffness))
        case PointMass():
            faults.extend(_not_negative(f"{where}: mass", item.mass))
        case Dashpot():
            faults.extend(_not_negative(f"{where}: coefficient", item.coefficient))
    return faults


def check_supports(structure: Structure) -> list[str]:
    """Return a fault for each node held twice in a direction."""
    held = Counter((support.node, direction) for support in structure.supports for direction in support.directions)
    return [
        f"supports: node {node} is held {times} times in {direction}; give it once"
        for (node, direction), times in held.items()
        if times > 1
    ]


def check_held(structure: Structure) -> list[str]:
    """Return a fault where nothing at all holds the structure."""
    grounded = any(isinstance(element, Spring) and len(element.nodes) == 1 for element in structure.elements)
    if structure.supports or grounded:
        return []
    return ["supports: there are none, and no spring to ground: the structure floats freely; add some"]


def _direction_faults(
    structure: Structure, where: str, item: Beam | Cable | Spring | PointMass | Dashpot | Support
) -> list[str]:
    """Return a fault for each direction that the item needs and the nodes do not have."""
    have = ", ".join(structure.directions)
    match item:
        case Beam() | Cable():
            needed = PLANE_FRAME if isinstance(item, Beam) else PLANE_FRAME[:2]
            if set(needed) <= set(structure.directions):
                return []
            kind = type(item).__name__.lower()
            return [f"{where}: a {kind} needs the directions {', '.join(needed)}; the nodes have {have}"]
        case PointMass():
            return []
        case Support():
            wanted = item.directions
            if not wanted:
                return [f"{where}: holds no direction; give some of {have}"]
        case _:
            wanted = (item.direction,)
    missing = [direction for direction in wanted if direction not in structure.directions]
    return [f"{where}: direction {direction!r} is not among those of the nodes, {have}" for direction in missing]


def _not_negative(what: str, value: float) -> list[str]:
    if not (isfinite(value) and value >= 0):
        return [f"{what} = {value}; must not be negative"]
    return [] if value <= LARGEST else [f"{what} = {value:g}; expected at most {LARGEST:g}"]


def _repeated(what: str, names: Iterable[str]) -> list[str]:
    return [f"{what} {name!r} is used {times} times" for name, times in Counter(names).items() if times > 1]
