"""Draws one panel: the undeformed structure in light grey, its supports, its deformed shapes."""

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.pictures import symbols
from fe_models.pictures.drawing import GREY, INK, LIGHT, PALE, Bytes, Color, Patch, disc, ramp, stroke
from fe_models.pictures.figure import Figure, Panel, Shape, View
from fe_models.pictures.geometry import Lines, Outline, deformed_lines, nodal_motion, nodal_size
from fe_models.structure import Direction

BEAM_WIDTH = 8.0  # px
BEAM_STYLES = ((BEAM_WIDTH, False), (BEAM_WIDTH, True), (5.0, False), (5.0, True))  # width, dark edges; group by group
CABLE_WIDTH = 2.2  # px
MASS_SHARE = 0.3  # side of a mass over the length of a spring


def structure_patches(figure: Figure, view: View, panel: Panel) -> list[Patch]:
    """Return the undeformed structure, then supports, then each shape."""
    outline = figure.outline
    still = np.zeros(len(outline.dofs))
    patches = []
    for lines, (width, _) in zip(deformed_lines(outline, still, 0.0), line_styles(outline), strict=True):
        if lines.kind == "point":
            patches.append(disc(view(lines.points[:, 0]), 5 * view.weight, LIGHT))
        elif not (lines.kind == "spring" and outline.masses):  # a second row of zigzags would hide the first
            patches.append(stroke(view(lines.points), width * view.weight, LIGHT))
    for node in outline.masses:
        patches.extend(symbols.mass(view(outline.coordinates[node]), mass_side(outline, view.factor), PALE, LIGHT))
    first = panel.shapes[0].displacement
    moved = view(outline.coordinates + figure.scale * nodal_motion(outline, first)[:, :2])
    carried = tuple(str(direction) for direction in np.unique(outline.dofs.direction))
    for support in outline.supports:
        name = symbols.support_name(support.directions, carried)
        away = symbols.support_side(support.directions, outline.is_right(support.node - 1))
        patches.extend(symbols.support(name, moved[support.node - 1], view.sign, away))
    for shape in panel.shapes:
        patches.extend(_shape_patches(figure, view, shape))
    return patches


def _shape_patches(figure: Figure, view: View, shape: Shape) -> list[Patch]:
    outline = figure.outline
    drawn = deformed_lines(outline, shape.displacement, figure.scale)
    patches: list[Patch] = []
    for lines, style in zip(drawn, line_styles(outline), strict=True):
        patches.extend(_member_patches(figure, view, shape, lines, style))
    motion = nodal_motion(outline, shape.displacement)[:, :2]
    nodes = view(outline.coordinates + figure.scale * motion)
    tint = _tint(figure, shape, nodal_size(outline, shape.displacement))  # (node, 3)
    for node, direction in outline.grounded:
        red, green, blue = (int(value) for value in tint[node])
        patches.extend(ground_spring(outline, view, node, direction, nodes[node], shape.width, (red, green, blue)))
    for node in outline.masses:
        red, green, blue = (int(value) for value in tint[node])
        patches.extend(
            symbols.mass(nodes[node], mass_side(outline, view.factor) * shape.width**0.5, (red, green, blue))
        )
    return patches


def _member_patches(figure: Figure, view: View, shape: Shape, lines: Lines, style: tuple[float, bool]) -> list[Patch]:
    width, edged = style[0] * view.weight * shape.width, style[1]
    points, tint = view(lines.points), _tint(figure, shape, lines.magnitude)
    if lines.kind == "point":
        origin = view(figure.outline.coordinates)
        paths = np.stack([origin, points[:, 0]], axis=1)
        return [stroke(paths, 1.5, GREY, caps=False), disc(points[:, 0], 7 * view.weight * shape.width, tint[:, 0])]
    if lines.kind == "spring":
        amplitude = coil(figure.outline, view)
        return [
            stroke(symbols.zigzag(line[0], line[-1], amplitude), 3 * shape.width, tuple(shade.mean(axis=0)))
            for line, shade in zip(points, tint, strict=True)
        ]
    body = stroke(points, width, tint)
    return [stroke(points, width + 4 * view.weight, INK), body] if edged and shape.color is None else [body]


def ground_spring(
    outline: Outline, view: View, node: int, direction: Direction, at: FloatArray, width: float, color: Color
) -> list[Patch]:
    """Return the spring from a ``node`` (row), drawn ``at`` (2,) px, to the ground."""
    if direction == "rz":
        return [stroke(symbols.spiral(at, 0.8 * view.sign), 2.5 * width, color)]
    point = ground_point(outline, node, direction)
    away = point - outline.coordinates[node]
    foot = view(point)
    line = symbols.zigzag(foot, at, coil(outline, view))
    hatch = symbols.ground(foot, 1.2 * view.sign, away / np.linalg.norm(away))
    return [*hatch, stroke(line, 3 * width, color)]


def _tint(figure: Figure, shape: Shape, magnitude: FloatArray) -> Bytes:
    """Return colours (..., 3): by displacement, or the shape's own."""
    if shape.color is not None:
        return np.broadcast_to(np.array(shape.color, dtype=np.uint8), (*magnitude.shape, 3))
    return ramp(magnitude / figure.largest if figure.largest > 0 else np.zeros_like(magnitude))


def family(name: str) -> str:
    """Return the name of a group without its side, so that "left tower" and "right tower" are drawn and named alike."""
    return " ".join(word for word in name.split() if word not in ("left", "right")) or name


def line_styles(outline: Outline) -> list[tuple[float, bool]]:
    """Return width (px) and edges of each group: beams thick, in turn plain and edged; cables thin."""
    beams = list(dict.fromkeys(family(group.name) for group in outline.groups if group.kind == "beam"))
    return [
        BEAM_STYLES[beams.index(family(group.name)) % len(BEAM_STYLES)]
        if group.kind == "beam"
        else (CABLE_WIDTH, False)
        for group in outline.groups
    ]


def mass_side(outline: Outline, factor: float) -> float:
    """Return the side (px) of the square that is a mass, at ``factor`` px/m."""
    return float(np.clip(MASS_SHARE * outline.spacing * factor, 14, 80))


def coil(outline: Outline, view: View) -> float:
    """Return how far (px) the teeth of a spring stand off its axis."""
    return float(np.clip(0.06 * outline.spacing * view.factor, 4, 14))


def ground_point(outline: Outline, node: int, direction: Direction) -> FloatArray:
    """Return where (m) the ground end of a spring is drawn: below its node, or beside it on the nearer outer side."""
    at = outline.coordinates[node]
    reach = outline.spacing if outline.masses else min(outline.spacing, 0.12 * outline.size)
    beside = np.array([reach if outline.is_right(node) else -reach, 0.0])
    point: FloatArray = at + {"x": beside, "y": reach * symbols.DOWNWARDS, "rz": np.zeros(2)}[direction]
    return point
