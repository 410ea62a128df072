"""Numbers of nodes and elements: what is numbered, where the numbers may stand, and how they are drawn."""

from dataclasses import dataclass
from math import ceil
from typing import Literal

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.linear import LinearModel
from fe_models.pictures.drawing import GREY, INK, WHITE, Color, Patch, Text, polygon, stroke
from fe_models.pictures.figure import View
from fe_models.pictures.geometry import Outline
from fe_models.pictures.labels import Label, around, leader
from fe_models.pictures.panels import ground_point
from fe_models.structure import Beam, Spring, Structure

ELEMENT_COLOR: Color = (0, 70, 160)  # of elements' numbers, which stand in boxes besides: distinguished in grey, too
NODE_CLEARANCE = 8.0  # px, from the middle of a node to its number
# px between points along beams and thinner elements, which numbers are kept off: most off beams
# elements so many times as long as the widest number carry theirs; beside shorter ones they stand
BEAM_POINT_SPACING, THIN_POINT_SPACING = 5.0, 15.0
MIN_LENGTH_RATIO = 1.8
SHIFTS = (0.0, 3.0, -3.0, 6.0, -6.0, 9.0, -9.0)  # px, up and down, of numbers beside an upright member
SHORT_PERCENTILE = 10  # percent: of the elements' lengths, by which the size of numbers goes
SHARES = (0.5, 0.42, 0.58, 0.34, 0.66, 0.26, 0.74, 0.18, 0.82, 0.1, 0.9)  # along an element, where its number may be


@dataclass(frozen=True)
class Member:
    """The element ``number`` between two places, ``ends`` (2, 2) in m, and its ``nodes`` (rows); ``thin``: no beam."""

    number: int
    nodes: tuple[int, ...]
    ends: FloatArray
    thin: bool


@dataclass(frozen=True)
class Number:
    """The number of a node or an element, ``size`` px high, and where it may stand; ``on_line``: on its element."""

    kind: Literal["node", "element"]
    text: str
    size: int
    label: Label
    on_line: bool = False


def members(model: Structure | LinearModel, outline: Outline) -> tuple[Member, ...]:
    """Return the elements of a structure as they are numbered; none of matrices."""
    if isinstance(model, LinearModel):
        return ()
    found = []
    for number, element in enumerate(model.elements, start=1):
        nodes = [node - 1 for node in element.nodes]
        start = outline.coordinates[nodes[0]]
        if isinstance(element, Spring) and len(nodes) == 1:
            end = ground_point(outline, nodes[0], element.direction)
        else:
            end = outline.coordinates[nodes[1]]
        found.append(Member(number, tuple(nodes), np.stack([start, end]), not isinstance(element, Beam)))
    return tuple(found)


def drawn_points(lines: tuple[Member, ...], view: View) -> list[FloatArray]:
    """Return points (point, 2) px along each element, which numbers are kept off."""
    points = []
    for member in lines:
        start, end = view(member.ends)
        spacing = THIN_POINT_SPACING if member.thin else BEAM_POINT_SPACING
        count = max(2, ceil(float(np.linalg.norm(end - start)) / spacing))
        points.append(start + np.linspace(0.0, 1.0, count)[:, None] * (end - start))
    return points


def text_size(outline: Outline, lines: tuple[Member, ...], view: View) -> int:
    """Return the height (px) of numbers: as large as the space between nodes allows, within what reads well."""
    lengths = [float(np.linalg.norm(member.ends[1] - member.ends[0])) for member in lines]
    short = np.percentile(lengths, SHORT_PERCENTILE) if lengths else outline.spacing
    return int(np.clip(0.42 * short * view.factor, 15, 22))


def node_numbers(nodes: list[int], outline: Outline, lines: tuple[Member, ...], view: View) -> list[Number]:
    """Return the numbers of ``nodes`` (rows): beside upright members, else above."""
    size = text_size(outline, lines, view)
    upright = np.zeros((len(outline.coordinates), 2))  # length of the members at each node, across and up
    for member in lines:
        upright[list(member.nodes)] += np.abs(member.ends[1] - member.ends[0])
    numbers = []
    for node in nodes:
        text = Text(str(node + 1), 0, 0, size, bold=True)
        box = np.array([text.width, size + 1.0])
        outer, inner = ("r", "l") if outline.is_right(node) else ("l", "r")
        if outline.masses:
            choices = np.zeros((1, 2))  # in the square of the mass
        elif upright[node, 1] > 2 * upright[node, 0]:
            row = np.array([NODE_CLEARANCE + box[0] / 2, 0.0]) * (1 if outer == "r" else -1)
            column = [side * row + np.array([0.0, shift]) for side in (1, -1) for shift in SHIFTS]
            choices = np.vstack([column, around(box, NODE_CLEARANCE, f"ab{outer}{inner}")])
        else:
            choices = around(box, NODE_CLEARANCE, f"a{outer}{inner}b")
        at = view(outline.coordinates[node])[None]
        numbers.append(Number("node", text.text, size, Label(at, box, choices)))
    return numbers


def element_numbers(outline: Outline, lines: tuple[Member, ...], along: list[FloatArray], view: View) -> list[Number]:
    """Return the numbers of elements, in frames: on the line where it is long, else below it or to its right."""
    size = text_size(outline, lines, view) - 2
    widest = np.array([Text(str(len(lines)), 0, 0, size).width + 8, size + 5.0])
    middle = float(view(outline.coordinates)[:, 0].mean())
    numbers, first = [], 0
    for member, points in zip(lines, along, strict=True):
        text = Text(str(member.number), 0, 0, size)
        box = np.array([text.width + 8, size + 5.0])
        start, end = view(member.ends)
        axis = end - start
        length = float(np.linalg.norm(axis))
        way = axis / length if length > 0 else np.array([1.0, 0.0])
        across = np.array([way[1], -way[0]])
        outer = np.array([1.0, 0.0]) if (start + end)[0] / 2 > middle + 1 else np.array([-1.0, 0.0])
        if across[1] > 0.7 or across @ outer > 0.7:
            across = -across  # downwards, or to the inner side, as numbers of nodes stand on the outer one
        off = 6.0 + abs(across) @ box / 2 + (8.0 if outline.masses else 0.0)  # clear of the coils
        steps = [(share - 0.5) * axis for share in SHARES]
        beside = [step + side * off * across for step in steps for side in (1.0, -1.0)]
        far = off + box[0] * np.array([0.8, 1.6, 2.4])
        beside += [step + side * reach * across for reach in far for step in steps for side in (1.0, -1.0)]
        on_line = length > MIN_LENGTH_RATIO * float(abs(way) @ widest) and not outline.masses
        choices = np.array([*steps, *beside] if on_line else beside)
        own = (first, first + len(points)) if on_line else (0, 0)
        at = (start + end)[None] / 2
        numbers.append(Number("element", text.text, size, Label(at, box, choices, own), on_line))
        first += len(points)
    return numbers


def drawn_number(number: Number, offset: FloatArray) -> tuple[list[Patch], list[Patch], Text]:
    """Return the white ground of a number ``offset`` (2,) px off, over cables and beneath beams; its signs; its text.

    Signs are the box about an element's number, and a line to a place that is far.
    """
    centre = number.label.at[0] + offset
    x, y = centre.tolist()
    line = line_to(number, offset)
    signs = [] if line is None else [stroke(line[None], 1.2, GREY, caps=False)]
    if number.kind == "element":
        text = Text(number.text, x, y, number.size, ELEMENT_COLOR, "center")
        return [], [*signs, *element_box(centre, number.label.size)], text
    text = Text(number.text, x, y, number.size, INK, "center", bold=True)
    return [polygon(corners_of(centre, number.label.size), WHITE)], signs, text


def line_to(number: Number, offset: FloatArray) -> FloatArray | None:
    """Return the line (2, 2) that joins a number to its place where it stands far off."""
    at, half = number.label.at[0], number.label.size / 2
    return None if number.on_line else leader(at, at + offset - half, at + offset + half, NODE_CLEARANCE + 10)


def element_box(centre: FloatArray, size: FloatArray) -> list[Patch]:
    """Return the box in which an element's number stands."""
    corners = corners_of(centre, size)
    return [polygon(corners, WHITE), stroke(np.vstack([corners, corners[:1]])[None], 1.2, ELEMENT_COLOR)]


def corners_of(centre: FloatArray, size: FloatArray) -> FloatArray:
    """Return the corners (4, 2) of a box."""
    return np.asarray(centre + size / 2 * np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]))
