"""Sensors on the drawing of a model: an arrow along what each one measures, and the names at its tip."""

from dataclasses import dataclass

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.directions import AnyDirection
from fe_models.pictures import symbols
from fe_models.pictures.drawing import Patch, Text
from fe_models.pictures.figure import View
from fe_models.pictures.geometry import Outline
from fe_models.pictures.labels import Label, around
from fe_models.pictures.legend import Entry
from fe_models.pictures.panels import mass_side
from fe_models.pictures.sensor_names import HELD_OUT_COLOR, LINE_HEIGHT, MEASURED_COLOR, NAME_SIZE
from fe_models.recordings import Sensor
from fe_models.structure import ROTATIONS

ARROW_LENGTH = 50.0  # px, of an arrow
NODE_CLEARANCE = 9.0  # px, between a node and the arrow
MEMBER_CLEARANCE = 16.0  # px, from a member along which the arrow would lie
TURN_RADIUS = 20.0  # px, of the arrow that turns


@dataclass(frozen=True)
class SensorArrow:
    """The arrow of all sensors in one ``direction`` at one node, from ``tail`` to ``tip`` (2,) px."""

    sensors: tuple[Sensor, ...]
    direction: AnyDirection
    tail: FloatArray
    tip: FloatArray
    label: Label

    @property
    def points(self) -> FloatArray:
        """Points (point, 2) px that other labels are kept off."""
        if self.direction in ROTATIONS:
            angle = np.linspace(0, 2 * np.pi, 16)
            return np.asarray(self.tail + TURN_RADIUS * np.stack([np.cos(angle), np.sin(angle)], axis=1))
        return np.asarray(self.tail + np.linspace(0, 1, 8)[:, None] * (self.tip - self.tail))

    def texts(self, offset: FloatArray) -> list[Text]:
        """Return the names, one above the other, about the place ``offset`` (2,) px from the label's own."""
        x, y = (self.label.at[0] + offset).tolist()
        top = y + LINE_HEIGHT * (len(self.sensors) - 1) / 2
        return [
            Text(sensor.name, x, top - LINE_HEIGHT * row, NAME_SIZE, _color(sensor), "center", bold=True)
            for row, sensor in enumerate(self.sensors)
        ]


def arrows_of(sensors: tuple[Sensor, ...], outline: Outline, view: View, lines: FloatArray) -> list[SensorArrow]:
    """Return an arrow for each node and direction with sensors, off the ``lines`` (point, 2) px where that can be."""
    together: dict[tuple[int, AnyDirection], list[Sensor]] = {}
    for sensor in sensors:
        together.setdefault((sensor.node - 1, sensor.direction), []).append(sensor)
    arrows = []
    for (node, direction), own in together.items():
        at = view(outline.coordinates[node])
        if direction in ROTATIONS:
            tail, tip, sides, clear = at, at, "rlab", TURN_RADIUS + 4
        else:
            tail, tip = _freest(at, outline.along(direction), outline, view, lines)
            sides, clear = ("arl" if outline.masses or direction in ("y", "z") else "rab"), 5.0
            if np.linalg.norm(tip - at) < np.linalg.norm(tail - at):  # it points at its node: the name is at its tail
                sides = {"rab": "lab", "arl": "brl"}[sides]
        end = tail if np.linalg.norm(tip - at) < np.linalg.norm(tail - at) else tip
        width = max(Text(sensor.name, 0, 0, NAME_SIZE, bold=True).width for sensor in own)
        size = np.array([width, LINE_HEIGHT * len(own)])
        arrows.append(SensorArrow(tuple(own), direction, tail, tip, Label(end[None], size, around(size, clear, sides))))
    return arrows


def arrow_patches(arrow: SensorArrow) -> list[Patch]:
    """Return what is drawn of an arrow; orange where all its sensors are held out."""
    color = HELD_OUT_COLOR if all(sensor.role == "held_out" for sensor in arrow.sensors) else MEASURED_COLOR
    if arrow.direction in ROTATIONS:
        return symbols.turn(arrow.tail, TURN_RADIUS, color)
    return symbols.arrow(arrow.tail, arrow.tip, color)


def sensor_entries(sensors: tuple[Sensor, ...]) -> list[Entry]:
    """Return the samples of a legend."""
    half = np.array([20.0, 0.0])
    return [
        (text, lambda at, color=color: symbols.arrow(at - half, at + half, color))  # type: ignore[misc]
        for role, text, color in (
            ("measured", "sensor", MEASURED_COLOR),
            ("held_out", "sensor held out", HELD_OUT_COLOR),
        )
        if any(sensor.role == role for sensor in sensors)
    ]


def _freest(
    at: FloatArray, way: FloatArray, outline: Outline, view: View, lines: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return tail and tip: away from the node, towards it, or beside it, whichever lies on fewest ``lines``."""
    across = np.array([-way[1], way[0]])
    if outline.masses:
        above = (mass_side(outline, view.factor) / 2 + 12) * across
        return at + above - ARROW_LENGTH / 2 * way, at + above + ARROW_LENGTH / 2 * way
    options = [
        (at + NODE_CLEARANCE * way, at + (NODE_CLEARANCE + ARROW_LENGTH) * way),
        (at - (NODE_CLEARANCE + ARROW_LENGTH) * way, at - NODE_CLEARANCE * way),
        (at + MEMBER_CLEARANCE * across, at + MEMBER_CLEARANCE * across + ARROW_LENGTH * way),
        (at - MEMBER_CLEARANCE * across, at - MEMBER_CLEARANCE * across + ARROW_LENGTH * way),
    ]
    crossed = []
    for tail, tip in options:
        points = tail + np.linspace(0, 1, 8)[:, None] * (tip - tail)
        near = np.linalg.norm(lines[:, None] - points, axis=2).min(axis=1, initial=np.inf) if len(lines) else lines
        crossed.append(int((near < 7.0).sum()))
    return options[int(np.argmin(crossed))]


def _color(sensor: Sensor) -> tuple[int, int, int]:
    return HELD_OUT_COLOR if sensor.role == "held_out" else MEASURED_COLOR
