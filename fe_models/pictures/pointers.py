"""What is pointed at on the drawing of a model, such as what a diagnosis found: a shade behind it, and its name."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fe_models.causes.base import elements_of
from fe_models.linear import LinearModel
from fe_models.pictures.drawing import Color, Patch, Text, disc, stroke
from fe_models.pictures.effect_marks import CLEAR, LINE, SIGN, SIZE, EffectMark, diamond
from fe_models.pictures.figure import View
from fe_models.pictures.geometry import Outline
from fe_models.pictures.labels import Label, around
from fe_models.pictures.legend import Entry
from fe_models.pictures.numbering import Member
from fe_models.pictures.panels import mass_side
from fe_models.recordings import Sensor
from fe_models.structure import Structure

FOUND: Color = (190, 20, 70)
FOUND_SHADE: Color = (255, 208, 220)
FAINT: Color = (168, 100, 125)
FAINT_SHADE: Color = (243, 228, 234)
MEMBER_WIDTH = 34.0  # px, of the shade behind an element: wider than the coils of a spring
NODE_RADIUS = 24.0  # px, of that behind a node


@dataclass(frozen=True)
class Pointer:
    """A ``name`` for ``nodes`` and ``elements``, by their numbers; ``is_faint``: where it is only possible."""

    name: str
    nodes: tuple[int, ...]
    elements: tuple[int, ...]
    is_faint: bool = False


def pointer_to(
    location: Mapping[str, Any],
    name: str,
    model: Structure | LinearModel,
    sensors: Sequence[Sensor],
    is_faint: bool = False,
) -> Pointer | None:
    """Return the pointer to a location in the words of a report; None of what is nowhere on the drawing."""
    if "sensor" in location:
        own = tuple(sensor.node for sensor in sensors if sensor.name == location["sensor"])
        return Pointer(name, own[:1], (), is_faint) if own else None
    if "load" in location:
        place = location["load"]
        return None if isinstance(place, str) else Pointer(name, (int(place[0]),), (), is_faint)
    nodes = tuple(location["nodes"]) if "nodes" in location else (location["node"],) if "node" in location else ()
    if isinstance(model, LinearModel):
        return Pointer(name, nodes or _nodes_of_group(model, location.get("group", "")), (), is_faint)
    numbers = (location["element"],) if "element" in location else tuple(location.get("elements", ()))
    elements = elements_of(model, numbers, location.get("group", ""))
    return Pointer(name, nodes, elements, is_faint) if nodes or elements else None


def _nodes_of_group(model: LinearModel, name: str) -> tuple[int, ...]:
    """Return the numbers of the nodes that a group of matrices has a share of stiffness or mass at."""
    for group in model.groups:
        if group.name == name:
            rows = np.unique(np.concatenate([group.stiffness.nonzero()[0], group.mass.nonzero()[0]]))
            return tuple(int(node) for node in np.unique(model.dofs.node[model.dofs.free_rows[rows]]))
    return ()


def shades(pointers: Sequence[Pointer], outline: Outline, lines: tuple[Member, ...], view: View) -> list[Patch]:
    """Return what lies behind all that is pointed at; what is only possible below."""
    patches: list[Patch] = []
    for pointer in sorted(pointers, key=lambda one: not one.is_faint):
        color = FAINT_SHADE if pointer.is_faint else FOUND_SHADE
        for member in (own for own in lines if own.number in pointer.elements):
            patches.append(stroke(view(member.ends)[None], MEMBER_WIDTH, color))
        if pointer.nodes:
            at = view(outline.coordinates[[node - 1 for node in pointer.nodes]])
            radius = max(NODE_RADIUS, 0.8 * mass_side(outline, view.factor) if outline.masses else 0.0)
            patches.append(disc(at, radius, color))
            if len(at) == 2:
                patches.append(stroke(at[None], MEMBER_WIDTH, color))
    return patches


def pointer_marks(
    pointers: Iterable[Pointer], outline: Outline, lines: tuple[Member, ...], view: View
) -> list[EffectMark]:
    """Return the names, those of one place one above the other."""
    ends = {member.number: member.ends for member in lines}
    together: dict[tuple[float, float, bool], list[Pointer]] = {}
    for pointer in pointers:
        if pointer.elements:
            at = view(ends[pointer.elements[len(pointer.elements) // 2]]).mean(axis=0)
        else:
            at = view(outline.coordinates[[node - 1 for node in pointer.nodes]]).mean(axis=0)
        x, y = np.round(at, 1).tolist()
        together.setdefault((x, y, pointer.is_faint), []).append(pointer)
    half = mass_side(outline, view.factor) / 2 if outline.masses else 0.0
    marks = []
    for (x, y, is_faint), own in together.items():
        names = tuple(dict.fromkeys(pointer.name for pointer in own))
        size = np.array([max(Text(name, 0, 0, SIZE).width for name in names) + 4 * SIGN, LINE * len(names)])
        choices = around(size, CLEAR + NODE_RADIUS / 2 + half, "abrl")
        color = FAINT if is_faint else FOUND
        marks.append(EffectMark(names, Label(np.array([[x, y]]), size, choices), (), color))
    return marks


def pointer_entries(pointers: Iterable[Pointer]) -> list[Entry]:
    """Return the samples of a legend."""
    kinds = {pointer.is_faint for pointer in pointers}
    words = ((False, "found", FOUND, FOUND_SHADE), (True, "possible instead", FAINT, FAINT_SHADE))
    return [
        (name, lambda at, color=color, shade=shade: [disc(at[None], 16.0, shade), diamond(at, color)])  # type: ignore[misc]
        for is_faint, name, color, shade in words
        if is_faint in kinds
    ]
