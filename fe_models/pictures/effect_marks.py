"""Dashpots and effects on the drawing of a model: a diamond with its name at each, joined to where it acts."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes.base import Effect
from fe_models.causes.laws import effects_of
from fe_models.causes.wording import kind_words
from fe_models.pictures.drawing import Color, Patch, Text, polygon, stroke
from fe_models.pictures.figure import View
from fe_models.pictures.geometry import Outline
from fe_models.pictures.labels import Label, around
from fe_models.pictures.legend import Entry
from fe_models.pictures.panels import mass_side
from fe_models.structure import Structure

COLOR: Color = (140, 30, 90)
SIZE = 18  # px, of names
PLACES = {"node", "nodes", "element", "elements"}  # words of locations that are somewhere on the drawing
LINE = 23.0  # px, from one name to the next
SIGN = 6.0  # px, half a diamond
CLEAR = 10.0  # px, from a node to names
JOINED = 1.5  # px, width of the line between what an effect joins
ABOVE = 0.3  # of a mass's side: how far above the middle of masses the line between two of them runs


@dataclass(frozen=True)
class EffectMark:
    """All that acts at one place: ``names``, their ``label``, and the ``lines`` (2, 2) px between what it joins."""

    names: tuple[str, ...]
    label: Label
    lines: tuple[FloatArray, ...]
    color: Color = COLOR

    def texts(self, offset: FloatArray) -> list[Text]:
        """Return the names, one above the other, about the place ``offset`` (2,) px from the label's own."""
        left, top = self._corner(offset)
        return [Text(name, left, top - LINE * row, SIZE, self.color) for row, name in enumerate(self.names)]

    def patches(self, offset: FloatArray) -> list[Patch]:
        """Return the diamonds before the names, and the lines to where it acts."""
        left, top = self._corner(offset)
        at, centre, half = self.label.at[0], self.label.at[0] + offset, self.label.size / 2
        foot = np.clip(at, centre - half, centre + half)
        lines = [stroke(line[None], JOINED, self.color, caps=False) for line in (*self.lines, np.stack([at, foot]))]
        signs = [diamond(np.array([left - 2 * SIGN, top - LINE * row]), self.color) for row in range(len(self.names))]
        return [*lines, *signs]

    def _corner(self, offset: FloatArray) -> tuple[float, float]:
        """Return where the first name begins, and its height."""
        x, y = (self.label.at[0] + offset).tolist()
        return x - self.label.size[0] / 2 + 3.5 * SIGN, y + LINE * (len(self.names) - 1) / 2


def diamond(at: FloatArray, color: Color = COLOR) -> Patch:
    """Return the sign of an effect."""
    return polygon(at + SIGN * np.array([(-1.0, 0.0), (0.0, -1.0), (1.0, 0.0), (0.0, 1.0)]), color)


def marks_of(structure: Structure, outline: Outline, view: View) -> list[EffectMark]:
    """Return a mark for each place with dashpots or effects; springs of effects are drawn as springs are.

    What acts in many elements is named at the middle one of them.
    """
    names: dict[tuple[int, ...], list[str]] = {}
    joined: dict[tuple[int, ...], list[tuple[int, ...]]] = {}
    for places, name in _acting(structure):
        middle = places[len(places) // 2]
        names.setdefault(middle, []).append(name)
        joined.setdefault(middle, []).extend(place for place in places if len(place) == 2)
    half = mass_side(outline, view.factor) / 2 if outline.masses else 0.0
    raised = np.array([0.0, 2 * ABOVE * half])
    marks = []
    for nodes, texts in names.items():
        own = tuple(dict.fromkeys(texts))
        lines = tuple(_ends(place, outline, view) + raised for place in dict.fromkeys(joined[nodes]))
        size = np.array([max(Text(name, 0, 0, SIZE).width for name in own) + 4 * SIGN, LINE * len(own)])
        at = _ends(nodes, outline, view).mean(axis=0) + (raised if lines else 0.0)
        choices = around(size, CLEAR, "abrl") if lines else around(size, CLEAR + half, "brla")
        marks.append(EffectMark(own, Label(at[None], size, choices), lines))
    return marks


def elsewhere(structure: Structure) -> list[str]:
    """Return the names of effects that act at no place of their own, as weight and modal damping do."""
    names = (_name(effect) for effect in effects_of(structure) if not (PLACES & effect.location.keys()))
    return list(dict.fromkeys(names))


def mark_entries(structure: Structure) -> list[Entry]:
    """Return the sample of a legend, where there is something to explain."""
    return [("dashpot or effect", lambda at: [diamond(at)])] if any(True for _ in _acting(structure)) else []


def _acting(structure: Structure) -> Iterable[tuple[list[tuple[int, ...]], str]]:
    """Give what acts at nodes or between two: all its places, and its name."""
    for dashpot in structure.dashpots:
        yield [dashpot.nodes], f"dashpot {dashpot.direction}"
    for effect in effects_of(structure):
        places = _places(effect, structure)
        if places:
            yield places, _name(effect)


def _places(effect: Effect, structure: Structure) -> list[tuple[int, ...]]:
    """Return the nodes of each place of an effect, both ends of an element; none of what is drawn as a spring."""
    if len(effect.extend(structure).elements) > len(structure.elements):
        return []
    place = effect.location
    if "node" in place:
        return [(place["node"],)]
    if "nodes" in place:
        return [tuple(place["nodes"])]
    numbers = [place["element"]] if "element" in place else place.get("elements", [])
    return [structure.elements[number - 1].nodes for number in numbers]


def _name(effect: Effect) -> str:
    direction = effect.location.get("direction")
    return kind_words(effect.kind) + (f" {direction}" if direction else "")


def _ends(nodes: tuple[int, ...], outline: Outline, view: View) -> FloatArray:
    """Return the places (node, 2) px of nodes."""
    return view(outline.coordinates[[node - 1 for node in nodes]])
