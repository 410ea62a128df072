"""Sensors on deformed shapes: a dot that moves with its node, and beside it the names, free of each other."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.pictures.drawing import GREY, WHITE, Color, Patch, Text, disc, stroke
from fe_models.pictures.figure import Figure, Panel, Sweep, View
from fe_models.pictures.geometry import Outline, deformed_lines, nodal_motion
from fe_models.pictures.labels import Label, around, leader, overlapping, place
from fe_models.pictures.panels import mass_side
from fe_models.recordings import Sensor

MEASURED_COLOR: Color = (0, 120, 95)
HELD_OUT_COLOR: Color = (205, 75, 0)
DOT_RADIUS = 10.0  # px, its radius with the white rim
NAME_SIZE = 18  # px of names
LINE_HEIGHT = 21.0  # px from one name of a node to the next
MAX_FRAMES = 8  # pictures in which names are kept off the lines: more take time and show little else
MAX_LINE_POINTS = 600  # of the lines of one picture


@dataclass(frozen=True)
class NodeNames:
    """The names of the sensors at a ``node`` (row), one above the other, in a box of ``size`` (2,) px.

    ``offset`` (2,): of its centre from the node, px.
    """

    node: int
    sensors: tuple[Sensor, ...]
    offset: FloatArray
    size: FloatArray


@dataclass(frozen=True)
class Placed:
    """All names, and if none is on another; ``reach``: corners (2, 2) px of them all, from `Figure.reach`'s lowest."""

    names: tuple[NodeNames, ...]
    reach: FloatArray
    free: bool


def sweep(outline: Outline, frames: Sequence[FloatArray], scale: float, sensors: Sequence[Sensor]) -> Sweep | None:
    """Return where the sensors and the lines beside them move over ``frames`` (frame, dof); None without sensors."""
    if not sensors:
        return None
    rows = [sensor.node - 1 for sensor in sensors]
    paths = [outline.coordinates[rows] + scale * nodal_motion(outline, frame)[rows, :2] for frame in frames]
    seen = np.unique(np.linspace(0, len(frames) - 1, min(MAX_FRAMES, len(frames))).round().astype(int))
    lines = []
    for row in seen:
        drawn = [group.points.reshape(-1, 2) for group in deformed_lines(outline, frames[row], scale)]
        points = np.vstack([outline.coordinates, *drawn])
        lines.append(points[:: -(-len(points) // MAX_LINE_POINTS)])
    return Sweep(np.array(paths), np.array(lines), seen)


def placed_names(figure: Figure, factor: float) -> Placed:
    """Return where the names of sensors stand at ``factor`` px/m; they keep their places in all panels."""
    if figure.sweep is None:
        return Placed((), np.zeros((2, 2)), True)
    outline, nodes, labels = figure.outline, dict[int, list[int]](), []
    for number, sensor in enumerate(figure.sensors):
        nodes.setdefault(sensor.node - 1, []).append(number)
    clear = _clear(outline, factor)
    for node, own in nodes.items():
        sensors = [figure.sensors[number] for number in own]
        width = max(Text(sensor.name, 0, 0, NAME_SIZE, bold=True).width for sensor in sensors)
        size = np.array([width, LINE_HEIGHT * len(own)])
        sideways = not outline.masses and all(sensor.direction == "x" for sensor in sensors)
        outer, inner = ("r", "l") if outline.is_right(node) else ("l", "r")
        sides = "ab" if outline.masses else f"{outer}{inner}ab" if sideways else f"a{outer}{inner}b"
        at = factor * (figure.sweep.sensors[:, own[0]] - figure.reach[0])
        labels.append(Label(at, size, around(size, clear, sides)))
    lines = factor * (figure.sweep.lines - figure.reach[0])
    offsets = place(labels, lines, figure.sweep.frames)
    names = tuple(
        NodeNames(node, tuple(figure.sensors[number] for number in own), offset, label.size)
        for (node, own), offset, label in zip(nodes.items(), offsets, labels, strict=True)
    )
    boxes = np.stack([label.boxes(offset[None])[:, 0] for label, offset in zip(labels, offsets, strict=True)], axis=1)
    reach = np.stack([boxes[0].min(axis=(0, 1)), boxes[1].max(axis=(0, 1))])
    return Placed(names, reach, not overlapping(labels, offsets).any())


def sensor_marks(figure: Figure, view: View, panel: Panel, placed: Placed) -> tuple[list[Patch], list[Text]]:
    """Return a dot on the last shape for each node with sensors, and their names."""
    outline = figure.outline
    motion = nodal_motion(outline, panel.shapes[-1].displacement)[:, :2]
    places = view(outline.coordinates + figure.scale * motion)
    lines: list[Patch] = []
    dots: list[Patch] = []
    texts: list[Text] = []
    for name in placed.names:
        at, centre = places[name.node], places[name.node] + name.offset
        line = leader(at, centre - name.size / 2, centre + name.size / 2, _clear(outline, view.factor) + 10)
        if line is not None:
            lines.append(stroke(line[None], 1.2, GREY, caps=False))
        held_out = all(sensor.role == "held_out" for sensor in name.sensors)
        dots.append(disc(at[None], DOT_RADIUS * view.weight, WHITE))
        dots.append(disc(at[None], 0.75 * DOT_RADIUS * view.weight, HELD_OUT_COLOR if held_out else MEASURED_COLOR))
        top = centre[1] + LINE_HEIGHT * (len(name.sensors) - 1) / 2
        for row, sensor in enumerate(name.sensors):
            color = HELD_OUT_COLOR if sensor.role == "held_out" else MEASURED_COLOR
            y = float(top - LINE_HEIGHT * row)
            texts.append(Text(sensor.name, float(centre[0]), y, NAME_SIZE, color, "center", bold=True, boxed=True))
    return [*lines, *dots], texts


def _clear(outline: Outline, factor: float) -> float:
    """Return how far (px) from its node a name begins: clear of the dot, and of a mass."""
    return mass_side(outline, factor) / 2 + 5 if outline.masses else DOT_RADIUS + 2
