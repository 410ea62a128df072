"""What a picture shows of a structure, as plain arrays: bent members, their exaggeration, how far it all reaches."""

from collections.abc import Iterable
from dataclasses import dataclass
from math import floor, log10
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from fe_models.arrays import BoolArray, FloatArray
from fe_models.causes.laws import with_parts
from fe_models.directions import AnyDirection, components
from fe_models.dof_map import DofMap
from fe_models.errors import InputError
from fe_models.linear import LinearModel
from fe_models.mesh import mesh
from fe_models.pictures.projection import in_view, on_sheet, translations
from fe_models.structure import (
    PLANE_FRAME,
    ROTATIONS,
    TRANSLATIONS,
    Beam,
    Cable,
    Direction,
    Structure,
    Support,
    group_name,
)

CONNECTION = "stiffness between nodes"  # what is drawn of imported matrices, where no structure says what it is
Kind = Literal["beam", "cable", "spring", "point"]

STRAIGHT_SHARE = 1 / 120  # of the structure's size: pieces of a curve, of a dozen pixels, that look like it
MAX_PIECES = 60  # of one beam: enough where it is as long as the structure and bends three times
MAX_CONNECTIONS = 4  # a node, of imported matrices: frames and trusses have up to that, condensed matrices more
MOST_THICK = 300  # lines of imported matrices: more are drawn thin, or hide one another
DRAWN_SHARE = 0.08  # of the structure's size: a largest displacement that is plain to see and hides nothing


@dataclass(frozen=True)
class Group:
    """Members that are drawn alike; ``ends`` (line, 2) are their node rows, counted from 0."""

    name: str
    kind: Kind
    ends: NDArray[np.int64]


@dataclass(frozen=True)
class Outline:
    """All that is drawn of a model: ``coordinates`` (node, 2) in m, its members, what holds it, its visible masses.

    ``grounded``: node row and direction of each spring to ground; ``masses``: node rows of the masses of a chain.
    ``in_space``: whether ``coordinates`` are those on the sheet of a model in space (`projection`); ``depth`` (node,):
    then, how far out of the sheet each node is (m).
    """

    coordinates: FloatArray
    dofs: DofMap
    groups: tuple[Group, ...]
    supports: tuple[Support, ...] = ()
    grounded: tuple[tuple[int, Direction], ...] = ()
    masses: tuple[int, ...] = ()
    in_space: bool = False
    depth: FloatArray | None = None

    @property
    def bends(self) -> bool:
        """Whether beams are drawn bent, by the rotations of their nodes; in space they are straight."""
        return not self.in_space and bool((self.dofs.direction == "rz").any())

    def along(self, direction: AnyDirection) -> FloatArray:
        """Return the unit vector (2,) of a translation on the sheet; zero of one straight out of it."""
        parts = components(direction)
        vector = np.array([parts.get(axis, 0.0) for axis in TRANSLATIONS])
        drawn = on_sheet(vector) if self.in_space else vector[:2]
        return np.asarray(drawn / (np.linalg.norm(drawn) or 1.0))

    @property
    def size(self) -> float:
        """The larger of width and height (m)."""
        return float(np.ptp(self.coordinates, axis=0).max()) if len(self.coordinates) > 1 else 1.0

    @property
    def spacing(self) -> float:
        """Median length (m) of the members, by which masses and springs are drawn; the size where there are none."""
        ends = np.vstack([group.ends for group in self.groups if group.kind != "point"] or [np.empty((0, 2), int)])
        lengths = np.linalg.norm(self.coordinates[ends[:, 1]] - self.coordinates[ends[:, 0]], axis=1)
        lengths = lengths[lengths > 0]
        return float(np.median(lengths)) if len(lengths) else self.size

    def pieces(self, group: Group) -> int:
        """Return in how many straight pieces each beam of ``group`` is drawn, so that its curve looks smooth."""
        ends = self.coordinates[group.ends]  # (line, 2, 2)
        longest = float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).max(initial=0.0))
        return int(np.clip(np.ceil(longest / (STRAIGHT_SHARE * self.size)), 2, MAX_PIECES))

    def is_right(self, node: int) -> bool:
        """Whether the node (row) lies right of the middle, so that what holds it sideways is drawn on its right."""
        return bool(self.coordinates[node, 0] > self.coordinates[:, 0].mean())


@dataclass(frozen=True)
class Lines:
    """Deformed members of one group: ``points`` (line, point, 2) as drawn, and the true displacement there.

    ``magnitude`` (line, point) is the length of the displacement, in its own unit, without exaggeration.
    """

    name: str
    kind: Kind
    points: FloatArray
    magnitude: FloatArray


def outline(model: Structure | LinearModel) -> Outline:
    """Return what is drawn of ``model``: members of a structure, nodes and their connections of imported matrices."""
    if isinstance(model, LinearModel):
        return _matrix_outline(model)
    drawn = with_parts(model)  # a spring that takes a support's place is drawn as one
    parts = mesh(drawn)
    ends: dict[tuple[str, Kind], list[tuple[int, int]]] = {}
    grounded: list[tuple[int, Direction]] = []
    for part in parts.elements:
        element = drawn.elements[part.parent - 1]
        if len(part.nodes) == 2:
            kind: Kind = "beam" if isinstance(element, Beam) else "cable" if isinstance(element, Cable) else "spring"
            ends.setdefault((group_name(element), kind), []).append((part.nodes[0] - 1, part.nodes[1] - 1))
        elif not isinstance(element, Beam | Cable):
            grounded.append((part.nodes[0] - 1, element.direction))
    return Outline(
        _spread(parts.coordinates),
        parts.dofs,
        tuple(Group(name, kind, np.array(pairs)) for (name, kind), pairs in ends.items()),
        drawn.supports,
        tuple(grounded),
        tuple(mass.node - 1 for mass in model.point_masses) if "rz" not in model.directions else (),
    )


def _matrix_outline(model: LinearModel) -> Outline:
    """Return nodes, and lines between those that K couples, unless these are so many that they would hide all.

    Where K couples the rotations of two nodes a beam is between them, which bends; else a straight bar.
    """
    rows = np.arange(len(model.coordinates))
    groups: tuple[Group, ...] = (Group("node", "point", np.column_stack([rows, rows])),)
    dofs = model.dofs
    entries = model.stiffness.tocoo()
    of_row = dofs.free_rows[np.stack(entries.coords, axis=1)][entries.data != 0]  # (entry, 2): degrees of freedom
    pairs = dofs.node[of_row] - 1
    turning = np.isin(dofs.direction[of_row], ROTATIONS).all(axis=1)
    lines = np.unique(pairs[pairs[:, 0] < pairs[:, 1]], axis=0) if model.lines is None else model.lines - 1
    if len(lines) and (model.lines is not None or len(lines) <= MAX_CONNECTIONS * len(rows)):
        code = np.array([len(rows), 1])  # one number a pair
        bending = np.isin(np.sort(lines, axis=1) @ code, pairs[turning] @ code)
        if model.lines is not None:
            bending[:] = bool(np.isin(dofs.direction, ROTATIONS).any()) and len(lines) < MOST_THICK
        kinds: tuple[tuple[Kind, BoolArray], ...] = (("cable", ~bending), ("beam", bending))
        drawn = tuple(Group(CONNECTION, kind, lines[chosen]) for kind, chosen in kinds if chosen.any())
        groups = (*drawn, *groups)
    if model.coordinates.shape[1] == 3:  # signs of supports are drawn in the plane
        seen = in_view(model.coordinates)
        return Outline(seen[:, :2], dofs, groups, in_space=True, depth=seen[:, 2])
    return Outline(_spread(model.coordinates), dofs, groups, _held_nodes(dofs, len(rows)))


def _held_nodes(dofs: DofMap, nodes: int) -> tuple[Support, ...]:
    """Return the supports that matrices show: directions marked as held, and nodes that have none at all."""
    carried = [direction for direction in PLANE_FRAME if direction in dofs.direction]
    held, still = np.zeros((nodes, len(carried)), dtype=bool), ~dofs.moves
    for column, direction in enumerate(carried):
        held[dofs.node[(dofs.direction == direction) & still] - 1, column] = True
    held[np.setdiff1d(np.arange(nodes), dofs.node - 1)] = True
    return tuple(
        Support(int(row) + 1, tuple(direction for direction, fixed in zip(carried, held[row], strict=True) if fixed))
        for row in np.flatnonzero(held.any(axis=1))
    )


def nodal_motion(shape: Outline, displacement: FloatArray) -> FloatArray:
    """Return ``displacement`` (dof,) as (node, 3): x, y, rz, zero where a node has no such degree of freedom.

    Of a model in space across and up on the sheet, and no rotation.
    """
    dofs = shape.dofs
    if displacement.shape != (len(dofs),) or not np.isfinite(displacement).all():
        raise InputError(
            f"A displacement to be drawn, of shape {displacement.shape}, does not fit or holds values not finite:"
            f" give a finite number for each of the model's {len(dofs)} degrees of freedom, those at supports included."
        )
    motion = np.zeros((len(shape.coordinates), 3))
    if shape.in_space:
        motion[:, :2] = on_sheet(translations(dofs, displacement, len(motion)))
        return motion
    for column, direction in enumerate(PLANE_FRAME):
        rows = dofs.direction == direction
        motion[dofs.node[rows] - 1, column] = displacement[rows]
    return motion


def nodal_size(shape: Outline, displacement: FloatArray) -> FloatArray:
    """Return how far each node moves (node,), in space, too, whatever is seen of it on the sheet."""
    return np.linalg.norm(translations(shape.dofs, displacement, len(shape.coordinates)), axis=1)


def bent(start: FloatArray, end: FloatArray, motion: FloatArray, points: int) -> FloatArray:
    """Return the displacement (line, point, 2) along beams, from that of their ends: ``motion`` (line, 2, 3).

    ``start``, ``end``: (line, 2) in m. Along the beam linear; across it Hermite's cubic, exact for an Euler-Bernoulli
    beam that is loaded at its ends only: v(s) = (1 - 3s^2 + 2s^3) v1 + (s - 2s^2 + s^3) L r1 + (3s^2 - 2s^3) v2
    + (s^3 - s^2) L r2, s = x / L.
    """
    axis = end - start  # (line, 2)
    length = np.linalg.norm(axis, axis=1, keepdims=True)  # (line, 1)
    along = np.divide(axis, length, out=np.zeros_like(axis), where=length > 0)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    local = motion[:, :, :2] @ np.stack([along, across], axis=2)  # (line, 2, 2): end, (u, v)
    u1, v1, u2, v2 = (local[:, node, part, None] for node in (0, 1) for part in (0, 1))
    s = np.linspace(0.0, 1.0, points)  # (point,)
    u = (1 - s) * u1 + s * u2
    v = (1 - 3 * s**2 + 2 * s**3) * v1 + (3 * s**2 - 2 * s**3) * v2
    v += ((s - 2 * s**2 + s**3) * motion[:, 0, 2, None] + (s**3 - s**2) * motion[:, 1, 2, None]) * length
    moved: FloatArray = u[..., None] * along[:, None] + v[..., None] * across[:, None]
    return moved


def deformed_lines(shape: Outline, displacement: FloatArray, scale: float) -> tuple[Lines, ...]:
    """Return all members with ``displacement`` (dof,) drawn ``scale`` times as large; scale 0: the undeformed ones."""
    motion = nodal_motion(shape, displacement)
    size = nodal_size(shape, displacement)
    result = []
    for group in shape.groups:
        start, end = shape.coordinates[group.ends[:, 0]], shape.coordinates[group.ends[:, 1]]
        ends_motion = motion[group.ends]  # (line, 2, 3)
        if group.kind == "point":
            points, moved = start[:, None], ends_motion[:, :1, :2]
        elif group.kind == "beam" and shape.bends:
            count = shape.pieces(group) + 1
            s = np.linspace(0.0, 1.0, count)[:, None]
            points = (1 - s) * start[:, None] + s * end[:, None]
            moved = bent(start, end, ends_motion, count)
        else:
            points, moved = np.stack([start, end], axis=1), ends_motion[:, :, :2]
        seen = np.linalg.norm(moved, axis=-1)
        magnitude = size[group.ends][:, : seen.shape[1]] if shape.in_space else seen
        result.append(Lines(group.name, group.kind, points + scale * moved, magnitude))
    return tuple(result)


def largest_displacement(shape: Outline, displacements: Iterable[FloatArray]) -> float:
    """Return the largest displacement anywhere on the members or at a node, over ``displacements`` (frame, dof)."""
    largest = 0.0
    for displacement in displacements:
        nodal_motion(shape, displacement)  # is refused where it does not fit
        parts = [
            nodal_size(shape, displacement),
            *(lines.magnitude.ravel() for lines in deformed_lines(shape, displacement, 0.0)),
        ]
        largest = max(largest, float(np.concatenate(parts).max()))
    return largest


def choose_scale(displacements: FloatArray | float, size: float) -> float:
    """Return the factor 1, 2 or 5 x 10^n that draws the largest displacement nearest to 8 % of ``size`` (m).

    ``displacements``: lengths of displacements, any shape, in m (or relative). 1 where nothing moves.
    """
    largest = float(np.max(np.abs(displacements), initial=0.0))
    if largest <= 0.0 or size <= 0.0:
        return 1.0
    wanted = DRAWN_SHARE * size / largest
    decade = floor(log10(wanted))
    candidates = [digit * 10.0**power for power in (decade, decade + 1) for digit in (1, 2, 5)]
    return min(candidates, key=lambda factor: abs(log10(factor / wanted)))


def extent(shape: Outline, displacements: Iterable[FloatArray], scale: float) -> FloatArray:
    """Return the (2, 2) corners, lowest then highest (x, y) in m, of the undeformed and every deformed shape."""
    low, high = shape.coordinates.min(axis=0), shape.coordinates.max(axis=0)
    for displacement in displacements:
        nodes = shape.coordinates + scale * nodal_motion(shape, displacement)[:, :2]
        lines = [group.points.reshape(-1, 2) for group in deformed_lines(shape, displacement, scale)]
        reach = np.vstack([nodes, *lines])
        low, high = np.minimum(low, reach.min(axis=0)), np.maximum(high, reach.max(axis=0))
    return np.stack([low, high])


def _spread(coordinates: FloatArray) -> FloatArray:
    """Return ``coordinates`` (node, 2), or nodes one metre apart on a line where all are given at one place."""
    points = np.asarray(coordinates, dtype=float).reshape(-1, 2)
    if len(points) > 1 and not np.ptp(points, axis=0).any():
        return np.column_stack([np.arange(1.0, len(points) + 1), np.zeros(len(points))])
    return points
