"""Shapes that move on a page: lines of the structure in pixels, how far each point moves, and how that goes in time.

A point has two numbers, across and down the page; of a structure in space a third, out of it, so that it can be turned.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.directions import components
from fe_models.pictures.geometry import DRAWN_SHARE, Outline, deformed_lines, nodal_motion
from fe_models.pictures.projection import ELEVATION, in_view, translations
from fe_models.recordings import Sensor
from fe_models.structure import TRANSLATIONS

WIDTH, MAX_HEIGHT, MARGIN = 720.0, 480.0, 24.0  # px
LEAST_HEIGHT = 170.0  # px: of a chain, which has no height of its own
MOST_POINTS = 6000  # that a browser moves smoothly
DOWN = np.array([1.0, -1.0, 1.0])  # across and down the page, and out of it
IN_SPACE = " Drag it, or move the sliders, to see it from another side."
TURNED = " Displacements along the chain are drawn upwards."
SEEN_PERIOD = 2.0  # s: how long one period of a motion takes on the page


@dataclass(frozen=True)
class Layer:
    """What is drawn in one colour (a name of CSS): points that move by q(t) times ``shapes`` (part, point, axis), px at
    scale 1; ``history`` (time, part) of q, None of a natural mode, which goes to and fro. ``is_dots``: points alone.
    """

    name: str
    colour: str
    shapes: FloatArray
    history: FloatArray | None = None
    is_dots: bool = False


@dataclass(frozen=True)
class Choice:
    """One motion to look at: its ``label``, and ``layers`` over one another; ``seconds`` between the samples of a
    history, or a natural mode's period; how many times it is ``slowed`` down so that the eye can follow.
    """

    label: str
    layers: tuple[Layer, ...]
    seconds: float
    slowed: float


@dataclass(frozen=True)
class Motion:
    """``still`` (point, axis) px: the structure at rest, as lines of so many points (``lengths``), then the sensors'
    points; ``choices`` to look at.
    """

    width: float
    height: float
    still: FloatArray
    lengths: tuple[int, ...]
    choices: tuple[Choice, ...]

    @property
    def turns(self) -> bool:
        """Whether it is in space, and can be turned."""
        return self.still.shape[1] == 3

    @property
    def layers(self) -> tuple[Layer, ...]:
        """One layer of each name."""
        every = {layer.name: layer for choice in self.choices for layer in choice.layers}
        return tuple(every.values())

    def begun(self, layer: Layer) -> str:
        """Return the path of the first choice's layer of that name, as it is drawn first; empty without one."""
        return next((self.path(own) for own in self.choices[0].layers if own.name == layer.name), "")

    def path(self, layer: Layer | None = None) -> str:
        """Return the path of an SVG of the structure at rest, or of a layer as it is drawn first."""
        points = self.still
        if layer is not None:
            first = np.ones(len(layer.shapes)) if layer.history is None else layer.history[0]
            points = points + np.einsum("k,kpc->pc", first, layer.shapes)
        points, lined = points[:, :2], sum(self.lengths)
        if layer is not None and layer.is_dots:
            return " ".join(f"M{x:.1f} {y:.1f}h0" for x, y in points[lined:])
        parts = np.split(points[:lined], np.cumsum(self.lengths)[:-1])
        return " ".join("M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in part) for part in parts)

    @property
    def data(self) -> dict[str, Any]:
        """What the page's program moves, as plain data."""
        return {
            "still": _rounded(self.still),
            "width": self.width,
            "height": self.height,
            "elevation": float(np.degrees(ELEVATION)) if self.turns else None,
            "lengths": list(self.lengths),
            "choices": [
                {
                    "label": choice.label,
                    "seconds": choice.seconds,
                    "slowed": choice.slowed,
                    "layers": [
                        {
                            "name": layer.name,
                            "colour": layer.colour,
                            "dots": layer.is_dots,
                            "shapes": [_rounded(shape) for shape in layer.shapes],
                            "history": None if layer.history is None else np.round(layer.history, 4).tolist(),
                        }
                        for layer in choice.layers
                    ],
                }
                for choice in self.choices
            ],
        }


def _rounded(points: FloatArray) -> list[float]:
    return np.round(points, 1).ravel().tolist()


@dataclass(frozen=True)
class Stage:
    """An ``outline`` on the page: pixel = ``origin`` + ``factor`` (x, -y); ``sensors`` whose nodes have points.

    What moves along its own line, a chain, is drawn as if it moved across.
    """

    outline: Outline
    sensors: tuple[Sensor, ...]
    factor: float
    origin: FloatArray
    height: float

    @classmethod
    def of(cls, outline: Outline, sensors: Sequence[Sensor] = ()) -> "Stage | None":
        """Return the stage of an outline; None where it has too many points to move."""
        low, high = outline.coordinates.min(axis=0), outline.coordinates.max(axis=0)
        room = DRAWN_SHARE * outline.size * np.ones(2) * 1.2
        span = np.maximum(high - low + 2 * room, 1e-9)
        factor = float(min((WIDTH - 2 * MARGIN) / span[0], (MAX_HEIGHT - 2 * MARGIN) / span[1]))
        height = float(max(factor * span[1] + 2 * MARGIN, LEAST_HEIGHT))
        middle = (low + high) / 2
        origin = np.array([WIDTH / 2 - factor * middle[0], height / 2 + factor * middle[1]])
        moving = tuple(sensor for sensor in sensors if not sensor.turns)
        stage = cls(outline, moving, factor, origin, height)
        return stage if len(stage.points(np.zeros(len(outline.dofs)))) <= MOST_POINTS else None

    def points(self, displacement: FloatArray) -> FloatArray:
        """Return how far (px) all points, those of sensors last, move (point, axis) for a ``displacement`` (dof,)."""
        if self.outline.in_space:
            nodes = in_view(translations(self.outline.dofs, displacement, len(self.outline.coordinates)))
            return self._on_page(
                np.concatenate([*(line.reshape(-1, 3) for line in self._ends(nodes)), self._at(nodes)])
            )
        moved = deformed_lines(self.outline, displacement, 1.0)
        still = deformed_lines(self.outline, np.zeros_like(displacement), 0.0)
        lines = [a.points - b.points for a, b in zip(moved, still, strict=True) if a.kind != "point"]
        at = self._at(nodal_motion(self.outline, displacement)[:, :2])
        return self._on_page(np.concatenate([*(group.reshape(-1, 2) for group in lines), at]))

    def _ends(self, nodes: FloatArray) -> list[FloatArray]:
        """Return what belongs to the ``nodes`` (node, axis) at the ends of all lines, (line, 2, axis) a group."""
        return [nodes[group.ends] for group in self.outline.groups if group.kind != "point"]

    def _at(self, nodes: FloatArray) -> FloatArray:
        """Return what belongs to those of the ``nodes`` (node, axis) that have a sensor, (sensor, axis)."""
        return nodes[[sensor.node - 1 for sensor in self.sensors]].reshape(-1, nodes.shape[1])

    @property
    def ways(self) -> FloatArray:
        """The unit vectors (sensor, axis) along which sensors measure, on the page."""
        if self.outline.in_space:
            every = [components(sensor.direction) for sensor in self.sensors]
            vectors = np.array([[own.get(axis, 0.0) for axis in TRANSLATIONS] for own in every]).reshape(-1, 3)
            return self._on_page(in_view(vectors / np.linalg.norm(vectors, axis=1, keepdims=True))) / self.factor
        along = np.array([self.outline.along(sensor.direction) for sensor in self.sensors]).reshape(-1, 2)
        return self._on_page(along) / self.factor

    @property
    def words(self) -> str:
        """What is to be known of how it is drawn, for a caption."""
        return IN_SPACE * self.outline.in_space + TURNED * self.is_turned

    @property
    def is_turned(self) -> bool:
        """Whether motions along the structure are drawn across it."""
        across, up = np.ptp(self.outline.coordinates, axis=0)
        moves_across = "x" in self.outline.dofs.direction  # a chain has one direction
        return bool(self.outline.masses) and bool(moves_across == (across >= up))

    def _on_page(self, moved: FloatArray) -> FloatArray:
        """Return motions (point, axis), m, in pixels."""
        turned = moved[:, ::-1] if self.is_turned else moved
        return np.asarray(turned * self.factor * DOWN[: moved.shape[1]])

    def motion(self, choices: Sequence[Choice]) -> Motion:
        """Return the motion that is looked at on this stage."""
        nodes, origin = self.outline.coordinates, self.origin
        if self.outline.depth is not None:
            depth = self.outline.depth
            nodes = np.column_stack([nodes, depth - (depth.min() + depth.max()) / 2])
            origin, drawn = np.append(origin, 0.0), [line for group in self._ends(nodes) for line in group]
        else:
            still = deformed_lines(self.outline, np.zeros(len(self.outline.dofs)), 0.0)
            drawn = [line for group in still if group.kind != "point" for line in group.points]
        points = np.concatenate([*drawn, self._at(nodes)]) * self.factor * DOWN[: nodes.shape[1]] + origin
        return Motion(WIDTH, self.height, points, tuple(len(line) for line in drawn), tuple(choices))
