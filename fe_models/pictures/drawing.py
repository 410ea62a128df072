"""A picture as plain data: coloured triangles and texts in pixels, x to the right and y up from the lower left corner.

Everything is laid out in plain modules, where it can be tested without graphics; `render` only paints.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from fe_models.arrays import FloatArray

Color = tuple[int, int, int]
Bytes = NDArray[np.uint8]

INK: Color = (38, 38, 38)
GREY: Color = (150, 150, 150)
LIGHT: Color = (208, 208, 208)
PALE: Color = (243, 243, 243)
WHITE: Color = (255, 255, 255)
# From blue over magenta to orange: lightness rises evenly, so it reads in grey and by the colour-blind, and even its
# brightest end stands out from white.
RAMP: FloatArray = np.array(
    [[35, 60, 160], [110, 35, 160], [175, 40, 135], [218, 78, 85], [241, 132, 40], [250, 182, 35]]
)

TEXT_WIDTH = 0.6  # mean width of a character of DejaVu Sans over its size; bold letters are wider


@dataclass(frozen=True)
class Patch:
    """Triangles of one item: ``points`` (point, 2), ``triangles`` (triangle, 3), ``colors`` (point, 3) in 0..255."""

    points: FloatArray
    triangles: NDArray[np.int64]
    colors: Bytes


@dataclass(frozen=True)
class Text:
    """A line of text of height ``size`` px, centred on ``y``, beginning at, centred on or ending at ``x``."""

    text: str
    x: float
    y: float
    size: int = 22
    color: Color = INK
    align: Literal["left", "center", "right"] = "left"
    bold: bool = False
    boxed: bool = False  # on a white ground, where lines run beneath

    @property
    def width(self) -> float:
        """Estimated width (px)."""
        return TEXT_WIDTH * self.size * len(self.text) * (1.12 if self.bold else 1.0)


@dataclass(frozen=True)
class Picture:
    """``patches`` are painted in order, later ones over earlier ones, on white; texts over all."""

    width: int
    height: int
    patches: tuple[Patch, ...]
    texts: tuple[Text, ...]


def ramp(share: FloatArray) -> Bytes:
    """Return the colours (..., 3) of a quantity between 0 and 1 (values beyond are clipped)."""
    places = np.linspace(0.0, 1.0, len(RAMP))
    return np.stack([np.interp(share, places, RAMP[:, channel]) for channel in range(3)], axis=-1).astype(np.uint8)


def stroke(points: FloatArray, width: float, color: Color | Bytes, caps: bool = True) -> Patch:
    """Return lines (line, point, 2) as ribbons ``width`` px wide; ``color``: one, or (line, point, 3)."""
    lines, count = points.shape[:2]
    steps = np.diff(points, axis=1)  # (line, point - 1, 2)
    lengths = np.linalg.norm(steps, axis=2, keepdims=True)
    along = np.divide(steps, lengths, out=np.zeros_like(steps), where=lengths > 0)
    normals = np.stack([-along[..., 1], along[..., 0]], axis=-1)
    joint = np.concatenate([normals[:, :1], normals[:, :-1] + normals[:, 1:], normals[:, -1:]], axis=1)
    # A mitre keeps the width constant through a bend; its length is limited where the bend is sharp.
    norm = np.linalg.norm(joint, axis=2, keepdims=True)
    joint = np.divide(joint, norm, out=np.zeros_like(joint), where=norm > 0)
    neighbour = np.concatenate([normals[:, :1], normals], axis=1)
    mitre = 1 / np.maximum(np.sum(joint * neighbour, axis=2, keepdims=True), 0.5)
    side = 0.5 * width * mitre * joint  # (line, point, 2)
    ribbon = np.stack([points - side, points + side], axis=2).reshape(-1, 2)  # two corners a point
    first = 2 * (np.arange(lines)[:, None] * count + np.arange(count - 1)[None]).ravel()
    triangles = np.vstack(
        [np.stack([first, first + 1, first + 3], axis=1), np.stack([first, first + 3, first + 2], axis=1)]
    )
    shades = np.broadcast_to(np.asarray(color, dtype=np.uint8), (lines, count, 3))
    body = Patch(ribbon, triangles, np.repeat(shades.reshape(-1, 3), 2, axis=0))
    if not caps:
        return body
    tips = disc(points[:, [0, -1]].reshape(-1, 2), 0.5 * width, shades[:, [0, -1]].reshape(-1, 3), sides=12)
    return merge((body, tips))


def disc(centres: FloatArray, radius: float, color: Color | Bytes, sides: int = 28) -> Patch:
    """Return filled circles at ``centres`` (disc, 2); ``color``: one, or (disc, 3)."""
    angle = np.linspace(0.0, 2 * np.pi, sides, endpoint=False)
    rim = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)  # (side, 2)
    points = np.asarray(centres, dtype=float)[:, None] + rim  # (disc, side, 2)
    shades = np.broadcast_to(np.asarray(color, dtype=np.uint8), (len(points), 3))
    fan = np.stack([np.zeros(sides - 2, int), np.arange(1, sides - 1), np.arange(2, sides)], axis=1)
    triangles = (np.arange(len(points))[:, None, None] * sides + fan).reshape(-1, 3)
    return Patch(points.reshape(-1, 2), triangles, np.repeat(shades, sides, axis=0))


def polygon(corners: FloatArray, color: Color) -> Patch:
    """Return a filled convex polygon with ``corners`` (corner, 2) in order."""
    count = len(corners)
    fan = np.stack([np.zeros(count - 2, int), np.arange(1, count - 1), np.arange(2, count)], axis=1)
    return Patch(np.asarray(corners, dtype=float), fan, np.tile(np.array(color, dtype=np.uint8), (count, 1)))


def merge(patches: Iterable[Patch]) -> Patch:
    """Return one patch with the triangles of all, in order."""
    parts = tuple(patches)
    starts = np.cumsum([0, *(len(part.points) for part in parts[:-1])])
    return Patch(
        np.vstack([part.points for part in parts]),
        np.vstack([part.triangles + start for part, start in zip(parts, starts, strict=True)]),
        np.vstack([part.colors for part in parts]),
    )
