"""The drawing of a model before any analysis: nodes and elements with their numbers, supports, masses, sensors."""

from dataclasses import dataclass, replace
from math import ceil

import numpy as np

from fe_models.arrays import BoolArray, FloatArray
from fe_models.linear import LinearModel
from fe_models.pictures import symbols
from fe_models.pictures.axes import draw_axes
from fe_models.pictures.drawing import INK, LIGHT, WHITE, Color, Patch, Picture, Text, disc, stroke
from fe_models.pictures.effect_marks import elsewhere, mark_entries, marks_of
from fe_models.pictures.figure import MARGIN, View
from fe_models.pictures.geometry import Outline, deformed_lines, outline
from fe_models.pictures.labels import Label, overlapping, place
from fe_models.pictures.layout import HEAD_HEIGHT, ROW_GAP, SIDE_GAP, reach_of
from fe_models.pictures.legend import (
    BAR_HEIGHT,
    ROW_HEIGHT,
    Entry,
    legend_rows,
    length_scale,
    member_entries,
    support_entries,
)
from fe_models.pictures.numbering import (
    Member,
    Number,
    drawn_number,
    drawn_points,
    element_box,
    element_numbers,
    line_to,
    members,
    node_numbers,
)
from fe_models.pictures.panels import coil, ground_spring, line_styles, mass_side
from fe_models.pictures.pointers import Pointer, pointer_entries, pointer_marks, shades
from fe_models.pictures.sensor_arrows import arrow_patches, arrows_of, sensor_entries
from fe_models.recordings import Sensor
from fe_models.structure import Beam, Cable, Structure

MEMBER_COLOR: Color = (95, 95, 95)
BEAM_COLOR: Color = (205, 205, 205)  # of beams with edges
WIDTHS = (1600, 2200, 3000, 4000)  # px
MAX_HEIGHT_SHARE = 0.68  # of a picture's width: how high the structure is drawn at most
MOST_NUMBERED = 300  # nodes of matrices: of more, those with sensors have numbers alone
MOST_DOTTED = 5000  # nodes: of more, dots would hide the lines, and numbers find no room between them
MOST_LINES = 5000  # that stand by themselves; more are fine and pale, or they would be one dark face
MAX_LEADER_SHARE = 0.02  # of the numbers that a line joins to their places, where a larger picture has room for fewer
GRID_SPACING = 5.0  # px between the points by which numbers are kept off supports
MAX_PLACINGS = 3  # of placing numbers, those first that found no room the time before
MAX_ROUNDS = 3  # of looking for the room that labels need beside the structure, which follows from its scale


@dataclass(frozen=True)
class Drawn:
    """All of a drawing at one scale, from ``low`` to ``high`` (2,) px about the lower left corner of the structure.

    ``left_out``: numbers that have no room; ``far``: how many a line joins to their places.
    """

    patches: tuple[Patch, ...]
    texts: tuple[Text, ...]
    low: FloatArray
    high: FloatArray
    left_out: tuple[Number, ...]
    far: int


@dataclass(frozen=True)
class Subject:
    """What is drawn: a ``model`` as its ``shape`` and its numbered ``lines``, ``sensors``, what is pointed at."""

    model: Structure | LinearModel
    shape: Outline
    lines: tuple[Member, ...]
    sensors: tuple[Sensor, ...]
    pointers: tuple[Pointer, ...]


def structure_picture(
    model: Structure | LinearModel,
    sensors: tuple[Sensor, ...],
    widths: tuple[int, ...] = WIDTHS,
    pointers: tuple[Pointer, ...] = (),
) -> Picture:
    """Return the drawing, in the first of ``widths`` (px) in which all numbers have room, else in the last.

    ``pointers``: to what is marked on it.
    """
    shape = outline(model)
    subject = Subject(model, shape, members(model, shape), sensors, pointers)
    most = MAX_LEADER_SHARE * (len(shape.coordinates) + len(subject.lines))
    tried: list[tuple[Drawn, float, int]] = []
    for width in widths:
        drawn, factor = _at_width(subject, width)
        tried.append((drawn, factor, width))
        if not drawn.left_out and drawn.far <= most:
            break
    best = min(tried, key=lambda one: (len(one[0].left_out), max(one[0].far, most)))
    return _sheet(subject, *best)


def _at_width(subject: Subject, width: int) -> tuple[Drawn, float]:
    """Return the drawing on a sheet ``width`` px wide, and its scale (px/m)."""
    shape = subject.shape
    reach = reach_of(shape, [np.zeros(len(shape.dofs))], 0.0)
    span = np.maximum(reach[1] - reach[0], 1e-3 * shape.size)
    room = width - 2 * MARGIN - 2 * SIDE_GAP
    for _ in range(MAX_ROUNDS):
        factor = float(min(room / span[0], MAX_HEIGHT_SHARE * width / span[1]))
        sign = float(np.clip(0.028 * shape.size * factor, 20, 34))
        drawn = _drawn(subject, View(reach[0], np.zeros(2), factor, sign, 1.0))
        over = drawn.high[0] - drawn.low[0] - (width - 2 * MARGIN)
        if over <= 1:
            break
        room = max(room - over, 0.3 * width)
    return drawn, factor


def _drawn(subject: Subject, view: View) -> Drawn:
    model, shape, lines, sensors = subject.model, subject.shape, subject.lines, subject.sensors
    supports = _supports(shape, view)
    nodes = view(shape.coordinates)
    numbered = _numbered(model, shape, sensors)
    along = drawn_points(lines, view)
    clear = np.vstack([np.zeros((0, 2)), *(_filled(patch) for patch in supports)])
    line_points = np.vstack([np.zeros((0, 2)), *along])
    arrows = arrows_of(sensors, shape, view, line_points)
    pointed = np.vstack([np.zeros((0, 2)), *(arrow.points for arrow in arrows)])
    dots = nodes if len(nodes) <= MOST_DOTTED else nodes[:0]
    obstacles = np.vstack([line_points, clear, pointed, dots, *_spirals(shape, view)])[None]
    marks = marks_of(model, shape, view) if isinstance(model, Structure) else []
    marks = [*pointer_marks(subject.pointers, shape, lines, view), *marks]
    numbers = [*node_numbers(numbered, shape, lines, view), *element_numbers(shape, lines, along, view)]
    labels, numbers, offsets, hidden = _placed(
        [arrow.label for arrow in arrows], numbers, [mark.label for mark in marks], obstacles
    )
    first, end = len(arrows), len(arrows) + len(numbers)
    signs: list[Patch] = []
    grounds: list[Patch] = []
    texts: list[Text] = []
    for arrow, offset in zip(arrows, offsets, strict=False):
        signs += arrow_patches(arrow)
        texts += arrow.texts(offset)
    joints: list[Patch] = []
    for mark, offset in zip(marks, offsets[end:], strict=True):
        joints += mark.patches(offset)
        texts += mark.texts(offset)
    for number, offset, out in zip(numbers, offsets[first:end], hidden[first:end], strict=True):
        if not out:
            ground, sign, text = drawn_number(number, offset)
            grounds += ground
            signs += sign
            texts.append(text)
    thin, thick = _members(shape, view)
    behind = shades(subject.pointers, shape, lines, view)
    first_drawn = [*thin, *behind] if _is_crowded(shape) else [*behind, *thin]  # a face of lines hides what is behind
    patches = [*first_drawn, *grounds, *supports, *thick, *joints, *_nodes(model, shape, view, numbered), *signs]
    left_out = tuple(number for number, out in zip(numbers, hidden[first:end], strict=True) if out)
    boxes = [label.boxes(offset[None])[:, 0, 0] for label, offset in zip(labels, offsets, strict=True)]
    points = np.vstack([nodes, *(patch.points for patch in patches), *boxes])
    far = sum(line_to(number, offset) is not None for number, offset in zip(numbers, offsets[first:end], strict=True))
    return Drawn(tuple(patches), tuple(texts), points.min(axis=0), points.max(axis=0), left_out, far)


def _placed(
    arrows: list[Label], numbers: list[Number], marks: list[Label], obstacles: FloatArray
) -> tuple[list[Label], list[Number], FloatArray, BoolArray]:
    """Return the labels of arrows, numbers and marks; the numbers in that order; offsets; which lie on others.

    Numbers that found no room are placed before the others, which have more freedom, in the next try.
    """
    for attempt in range(MAX_PLACINGS):
        labels = [*arrows, *(number.label for number in numbers), *marks]
        offsets = place(labels, obstacles, np.zeros(1, dtype=int))
        hidden = overlapping(labels, offsets)
        out = hidden[len(arrows) : len(arrows) + len(numbers)]
        if attempt < MAX_PLACINGS - 1 and out.any():
            pairs = list(zip(numbers, out, strict=True))
            numbers = [number for wanted in (True, False) for number, lost in pairs if lost == wanted]
        else:
            break
    return labels, numbers, offsets, hidden


def _members(shape: Outline, view: View) -> tuple[list[Patch], list[Patch]]:
    """Return cables and springs, then beams, as they are drawn in all pictures, in grey."""
    thin: list[Patch] = []
    thick: list[Patch] = []
    still = deformed_lines(shape, np.zeros(len(shape.dofs)), 0.0)
    for group, (width, edged) in zip(still, line_styles(shape), strict=True):
        points = view(group.points)
        ends = points[:, [0, -1]]
        if group.kind != "point" and _is_crowded(shape):
            thin.append(stroke(ends, 1, LIGHT, caps=False))
        elif group.kind == "spring":
            thin += [stroke(symbols.zigzag(line[0], line[-1], coil(shape, view)), 3, MEMBER_COLOR) for line in points]
        elif group.kind == "cable":
            thin.append(stroke(ends, width, MEMBER_COLOR))
        elif group.kind == "beam":
            thick += [stroke(ends, width + 1, INK)] if edged else []
            thick.append(stroke(ends, width - 2, BEAM_COLOR if edged else MEMBER_COLOR))
    for node, direction in shape.grounded:
        thin += ground_spring(shape, view, node, direction, view(shape.coordinates[node]), 1.0, MEMBER_COLOR)
    return thin, thick


def _is_crowded(shape: Outline) -> bool:
    """Whether there are more lines than stand apart."""
    return sum(len(group.ends) for group in shape.groups if group.kind != "point") > MOST_LINES


def _supports(shape: Outline, view: View) -> list[Patch]:
    carried = tuple(str(direction) for direction in np.unique(shape.dofs.direction))
    patches: list[Patch] = []
    for support in shape.supports:
        name = symbols.support_name(support.directions, carried)
        away = symbols.support_side(support.directions, shape.is_right(support.node - 1))
        patches += symbols.support(name, view(shape.coordinates[support.node - 1]), view.sign, away)
    return patches


def _spirals(shape: Outline, view: View) -> list[FloatArray]:
    """Return points (point, 2) on each spring that turns, which numbers are kept off."""
    nodes = [node for node, direction in shape.grounded if direction == "rz"]
    return [symbols.spiral(view(shape.coordinates[node]), 0.8 * view.sign)[0] for node in nodes]


def _numbered(model: Structure | LinearModel, shape: Outline, sensors: tuple[Sensor, ...]) -> list[int]:
    """Return the rows of the nodes that have numbers on the drawing: those of the file, and inner ones with sensors."""
    count = len(model.nodes) if isinstance(model, Structure) else len(shape.coordinates)
    if isinstance(model, LinearModel) and count > MOST_NUMBERED:
        return sorted({sensor.node - 1 for sensor in sensors})
    return [*range(count), *sorted({sensor.node - 1 for sensor in sensors if sensor.node > count})]


def _nodes(model: Structure | LinearModel, shape: Outline, view: View, numbered: list[int]) -> list[Patch]:
    """Return masses, the dots of nodes, and smaller ones for those that refinement added."""
    places = view(shape.coordinates)
    patches: list[Patch] = []
    if shape.masses:
        for node in shape.masses:
            patches += symbols.mass(places[node], mass_side(shape, view.factor), WHITE)
        return patches
    heavy = _massive(model)
    inner = np.setdiff1d(np.arange(len(places)), numbered)
    if len(inner) and len(places) <= MOST_DOTTED:
        patches.append(disc(places[inner], 3.0, INK, sides=10))
    patches.append(disc(places[numbered], 5.5, INK, sides=16))
    if heavy:
        patches.append(disc(places[heavy], 7.5, INK, sides=20))
    patches.append(disc(places[np.setdiff1d(np.array(numbered, dtype=np.int64), heavy)], 3.5, WHITE, sides=16))
    return patches


def _massive(model: Structure | LinearModel) -> list[int]:
    """Return the rows of the nodes with point masses."""
    return sorted({mass.node - 1 for mass in model.point_masses}) if isinstance(model, Structure) else []


def _filled(patch: Patch) -> FloatArray:
    """Return points (point, 2) all over the rectangle about a sign."""
    low, high = patch.points.min(axis=0), patch.points.max(axis=0)
    sides = [np.arange(a, b + GRID_SPACING, GRID_SPACING) for a, b in zip(low, high, strict=True)]
    return np.stack(np.meshgrid(*sides), axis=-1).reshape(-1, 2)


def _sheet(subject: Subject, drawn: Drawn, factor: float, width: int) -> Picture:
    """Return the drawing with title and foot."""
    model, shape, lines = subject.model, subject.shape, subject.lines
    rows, patches, texts = legend_rows(_entries(subject), width)
    base = float(MARGIN + ROW_HEIGHT * rows)
    length_scale(width, factor, base + 40, patches, texts)
    draw_axes(shape, np.array([MARGIN + 12.0, base + 22.0]), patches, texts)
    foot = base + BAR_HEIGHT + ROW_GAP
    spare = width - 2 * MARGIN - (drawn.high[0] - drawn.low[0])
    shift = np.array([MARGIN + spare / 2, foot]) - drawn.low
    height = ceil(foot + drawn.high[1] - drawn.low[1] + ROW_GAP + HEAD_HEIGHT + MARGIN)
    height += height % 2
    name = model.name if isinstance(model, Structure) else "Imported matrices"
    texts.append(
        Text(f"{name}: nodes and elements" if lines else f"{name}: nodes", MARGIN, height - MARGIN - 16, 30, bold=True)
    )
    texts.append(Text(_note(model, shape, drawn.left_out), MARGIN, height - MARGIN - 54, 21, (90, 90, 90)))
    patches += [Patch(part.points + shift, part.triangles, part.colors) for part in drawn.patches]
    texts += [replace(text, x=text.x + shift[0], y=text.y + shift[1]) for text in drawn.texts]
    return Picture(width, height, tuple(patches), tuple(texts))


def _note(model: Structure | LinearModel, shape: Outline, left_out: tuple[Number, ...]) -> str:
    """Return what the model has, how large it is, and what the drawing leaves out."""
    across, *up = np.ptp(model.coordinates if shape.in_space else shape.coordinates, axis=0)  # type: ignore[union-attr]
    if isinstance(model, LinearModel):
        parts = [f"{len(shape.coordinates)} nodes, {model.dofs.free.sum()} free degrees of freedom"]
    else:
        kinds = ((Beam, "beam"), (Cable, "cable"))
        counts = [(sum(isinstance(e, kind) for e in model.elements), word) for kind, word in kinds]
        counts.append((len(model.elements) - sum(count for count, _ in counts), "spring"))
        words = ", ".join(f"{count} {word}{'s' * (count > 1)}" for count, word in counts if count)
        parts = [f"{len(model.nodes)} nodes, {len(model.elements)} elements ({words})"]
        if model.divisions > 1:
            parts.append(f"each beam in {model.divisions} finite elements")
    if shape.in_space:
        parts.append(" x ".join(f"{extent:.4g}" for extent in (across, *up)) + " m")
    else:
        parts.append(f"{across:.4g} m wide" + (f", {up[0]:.4g} m high" if up[0] else ""))
    besides = elsewhere(model) if isinstance(model, Structure) else []
    if besides:
        parts.append(f"with {', '.join(besides)}")
    if left_out:
        kinds_out = [(sum(n.kind == kind for n in left_out), kind) for kind in ("node", "element")]
        words = " and ".join(f"{count} {kind}s" for count, kind in kinds_out if count)
        parts.append(f"no room for the numbers of {words}")
    return "; ".join(parts)


def _entries(subject: Subject) -> list[Entry]:
    model, shape = subject.model, subject.shape
    color = LIGHT if _is_crowded(shape) else MEMBER_COLOR
    entries = [entry for entry in member_entries(shape, color) if entry[0] not in ("node", "mass")]
    heavy = _massive(model)
    if shape.masses:
        entries.append(("mass, node number in it", lambda at: symbols.mass(at, 24, WHITE)))
    elif heavy:
        entries.append(("node with point mass", lambda at: [disc(at[None], 7.5, INK)]))
    if not shape.masses and len(heavy) < len(shape.coordinates):
        entries.append(("node", lambda at: [disc(at[None], 5.5, INK), disc(at[None], 3.5, WHITE)]))
    if isinstance(model, Structure) and model.divisions > 1:
        entries.append(("node of refinement", lambda at: [disc(at[None], 3, INK)]))
    if subject.lines:
        entries.append(("number of an element", lambda at: element_box(at, np.array([26.0, 20.0]))))
    marks = mark_entries(model) if isinstance(model, Structure) else []
    pointed = pointer_entries(subject.pointers)
    return [*pointed, *entries, *support_entries(shape), *marks, *sensor_entries(subject.sensors)]
