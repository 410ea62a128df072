"""Signs of structural drawings, in pixels: supports by what they hold, springs, masses, ground."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.pictures.drawing import INK, WHITE, Color, Patch, disc, polygon, stroke

DOWNWARDS: FloatArray = np.array([0.0, -1.0])


@dataclass(frozen=True)
class Place:
    """Local axes of a sign: origin ``at`` (2,), unit ``size`` px, local -y towards ``away`` (2,), the ground's side."""

    at: FloatArray
    size: float
    away: FloatArray

    def __call__(self, points: Sequence[tuple[float, float]]) -> FloatArray:
        """Return local points as (point, 2) px."""
        axes = np.stack([np.array([-self.away[1], self.away[0]]), -self.away])  # rows: local x and y in the picture
        placed: FloatArray = self.at + self.size * np.array(points, dtype=float) @ axes
        return placed


def support_name(held: Collection[str], carried: Collection[str]) -> str:
    """Return the engineer's word for a support that holds ``held`` of the directions that its node has."""
    kept = frozenset(held)
    if kept >= frozenset(carried):
        return "clamped" if "rz" in carried else "held"
    if kept == {"x", "y"}:
        return "pinned"
    if kept == {"rz"}:
        return "rotation held"
    return "guided" if "rz" in kept else "roller"


def support_side(held: Collection[str], right: bool) -> FloatArray:
    """Return the direction (2,) from the node to the ground: down; beside, to its outer side, where only x is held."""
    return DOWNWARDS if "y" in held or "x" not in held else np.array([1.0 if right else -1.0, 0.0])


def support(name: str, at: FloatArray, size: float, away: FloatArray = DOWNWARDS) -> list[Patch]:
    """Return the sign of a support called ``name`` (see `support_name`) at a node, ``size`` px large."""
    place = Place(at, size, away)
    if name == "rotation held":
        box = place([(-0.3, -0.3), (0.3, -0.3), (0.3, 0.3), (-0.3, 0.3), (-0.3, -0.3)])
        return [stroke(box[None], 2, INK)]
    if name in ("clamped", "held"):
        block = place([(-0.55, 0.0), (0.55, 0.0), (0.55, -0.28), (-0.55, -0.28)])
        return [polygon(block, INK), *_hatch(place, -0.28)]
    foot = -0.72
    body = [(0.0, 0.0), (0.42, foot), (-0.42, foot)]
    if name == "guided":
        body = [(-0.42, 0.0), (0.42, 0.0), (0.42, foot), (-0.42, foot)]
    signs = [polygon(place(body), WHITE), stroke(place([*body, body[0]])[None], 2, INK)]
    if name == "pinned":
        return [*signs, *_hatch(place, foot)]
    wheels = place([(-0.22, foot - 0.15), (0.22, foot - 0.15)])
    return [*signs, disc(wheels, 0.14 * size, INK), disc(wheels, 0.14 * size - 2, WHITE), *_hatch(place, foot - 0.3)]


def ground(at: FloatArray, size: float, away: FloatArray) -> list[Patch]:
    """Return a hatched line of ground, ``size`` px long, whose free side faces against ``away`` (2,)."""
    return _hatch(Place(at, size, away), 0.0)


def zigzag(start: FloatArray, end: FloatArray, amplitude: float, coils: int = 5) -> FloatArray:
    """Return the points (1, point, 2) of a spring between two places: straight leads, ``coils`` teeth between."""
    axis = end - start
    length = float(np.linalg.norm(axis))
    if length == 0.0:
        return np.stack([start, end])[None]
    along = axis / length
    across = np.array([-along[1], along[0]])
    teeth = np.linspace(0.18, 0.82, 2 * coils + 1)  # share of the length
    sway = amplitude * np.array([0.0, *([1.0, -1.0] * coils)[: 2 * coils - 1], 0.0])
    middle = start + teeth[:, None] * axis + sway[:, None] * across
    return np.vstack([start, middle, end])[None]


def spiral(at: FloatArray, radius: float) -> FloatArray:
    """Return the points (1, point, 2) of a rotational spring round a node."""
    angle = np.linspace(0.0, 5 * np.pi, 60)
    reach = radius * angle / angle[-1]
    turns: FloatArray = at + np.stack([reach * np.cos(angle), reach * np.sin(angle)], axis=1)
    return turns[None]


def mass(at: FloatArray, side: float, face: Color, edge: Color = INK) -> list[Patch]:
    """Return a square of ``side`` px centred on a node."""
    half = side / 2
    corners = at + np.array([(-half, -half), (half, -half), (half, half), (-half, half)])
    return [polygon(corners, face), stroke(np.vstack([corners, corners[:1]])[None], 2, edge)]


def arrow(tail: FloatArray, tip: FloatArray, color: Color, width: float = 3.0) -> list[Patch]:
    """Return a straight arrow between two places; its head is 14 px long, or half the arrow where that is shorter."""
    axis = tip - tail
    length = float(np.linalg.norm(axis))
    along = axis / length
    across = np.array([-along[1], along[0]])
    head = min(14.0, length / 2)
    neck = tip - head * along
    corners = np.stack([tip, neck + 0.45 * head * across, neck - 0.45 * head * across])
    return [stroke(np.stack([tail, neck])[None], width, color, caps=False), polygon(corners, color)]


def turn(at: FloatArray, radius: float, color: Color, width: float = 3.0) -> list[Patch]:
    """Return an arrow that turns counter-clockwise round a node, three quarters of a circle long."""
    angle = np.linspace(-0.25 * np.pi, 1.05 * np.pi, 40)
    arc = at + radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    end = at + radius * np.array([np.cos(1.25 * np.pi), np.sin(1.25 * np.pi)])
    away = (arc[-1] - at) / radius
    corners = np.stack([end, arc[-1] + 6 * away, arc[-1] - 6 * away])
    return [stroke(arc[None], width, color, caps=False), polygon(corners, color)]


def _hatch(place: Place, level: float) -> list[Patch]:
    """Return the line of the ground at a local height and six strokes beneath it."""
    line = place([(-0.62, level), (0.62, level)])
    teeth = [place([(x, level), (x - 0.16, level - 0.2)]) for x in np.linspace(-0.46, 0.56, 6)]
    return [stroke(line[None], 2.5, INK, caps=False), stroke(np.stack(teeth), 1.5, INK, caps=False)]
