"""Lays out a figure: panels in rows at one scale, with title, colour bar, scale of lengths and legend."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import ceil

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.pictures.drawing import Picture, Text
from fe_models.pictures.figure import MARGIN, Figure, Panel, View
from fe_models.pictures.geometry import Outline, extent
from fe_models.pictures.legend import footer
from fe_models.pictures.panels import MASS_SHARE, ground_point, structure_patches
from fe_models.pictures.sensor_names import Placed, placed_names, sensor_marks, sweep
from fe_models.recordings import Sensor

HEAD_HEIGHT = 84  # px, for title and note
LABEL_SIZE = 24  # px
LABEL_HEIGHT = 34  # px, for the labels of panels, where there are any
SIDE_GAP = 28.0  # px, beside a panel, for supports and sensors at its ends
ROW_GAP = 16.0  # px, above and below a panel
MAX_ROUNDS = 6  # of looking for room: the second suffices but where names are as wide as the panel


@dataclass(frozen=True)
class Arrangement:
    """Panels in so many ``columns``, each ``cell`` px wide, the structure at ``factor`` px/m: ``inner`` (2,) px in all.

    ``beside`` (2, 2) px: room to the left and below, to the right and above; ``label``: height of the panels' labels;
    ``sign``: size of supports, px.
    """

    columns: int
    factor: float
    sign: float
    cell: float
    label: float
    inner: FloatArray
    beside: FloatArray
    placed: Placed

    @property
    def height(self) -> float:
        """Height (px) of a panel with its label."""
        return float(self.label + self.inner[1] + self.beside[:, 1].sum())


def reach_of(outline: Outline, displacements: Iterable[FloatArray], scale: float) -> FloatArray:
    """Return the (2, 2) corners in m of all that the ``displacements`` (frame, dof) will show, ground included."""
    corners = [extent(outline, displacements, scale)]
    corners.extend(ground_point(outline, node, direction)[None] for node, direction in outline.grounded)
    points = np.vstack(corners)
    beyond = 0.6 * MASS_SHARE * outline.spacing if outline.masses else 0.0
    return np.stack([points.min(axis=0) - beyond, points.max(axis=0) + beyond])


def figure_of(
    outline: Outline,
    frames: Sequence[FloatArray],
    scale: float,
    largest: float,
    title: str,
    note: str,
    unit: str = "m",
    sensors: tuple[Sensor, ...] = (),
) -> Figure:
    """Return what the panels of all ``frames`` (frame, dof) share; for the rest see `Figure`."""
    reach = reach_of(outline, frames, scale)
    return Figure(outline, scale, largest, reach, title, note, unit, sensors, sweep(outline, frames, scale, sensors))


def arranged(figure: Figure, panels: Sequence[Panel]) -> Arrangement:
    """Return the arrangement that shows the panels, their labels and the names of sensors largest."""
    count = len(panels)
    widest = max(Text(panel.label, 0, 0, LABEL_SIZE).width for panel in panels)
    label = LABEL_HEIGHT if any(panel.label for panel in panels) else 0
    options = []
    for columns in range(1, min(count, 4) + 1):
        cell = (figure.width - 2 * MARGIN) / columns
        if columns > 1 and cell - SIDE_GAP < widest:
            break
        option = _in_columns(figure, columns, cell, label)
        tall = ceil(count / columns) * option.height
        options.append((option, tall))
    clear = [option for option in options if option[0].placed.free] or options[:1]
    fitting = [option for option in clear if option[1] <= (0.85 if count <= 6 else 1.1) * figure.width]
    best = max(fitting, key=lambda option: option[0].factor) if fitting else min(clear, key=lambda option: option[1])
    return best[0]


def _in_columns(figure: Figure, columns: int, cell: float, label: float) -> Arrangement:
    """Return the arrangement in so many columns, each ``cell`` px wide.

    What stands beside the structure, in pixels, takes from the room that its scale follows from, and follows from it in
    turn: the room is taken as found at the last scale, until it suffices.
    """
    span = np.maximum(figure.reach[1] - figure.reach[0], 1e-3 * figure.outline.size)
    beside = np.full((2, 2), SIDE_GAP)
    for _ in range(MAX_ROUNDS):
        room = max(cell - beside[:, 0].sum(), 0.3 * cell)
        factor = float(min(room / span[0], 0.42 * figure.width / span[1]))
        placed = placed_names(figure, factor)
        needed = _beside(figure, factor, placed)
        if (needed <= beside + 1).all():
            break
        beside = np.maximum(beside, needed)
    inner = factor * (figure.reach[1] - figure.reach[0])
    return Arrangement(columns, factor, _sign(figure, factor), cell, label, inner, beside, placed)


def compose(figure: Figure, panels: tuple[Panel, ...], arrangement: Arrangement | None = None) -> Picture:
    """Return the picture of ``panels`` in rows, all at one scale and in one range of colours, arranged as asked."""
    plan = arrangement or arranged(figure, panels)
    weight = 1.0 if plan.columns == 1 else 0.75
    rows = ceil(len(panels) / plan.columns)
    foot, patches, texts = footer(figure, plan.factor)
    height = ceil(MARGIN + foot + rows * plan.height + HEAD_HEIGHT + MARGIN)
    height += height % 2  # films want even sizes
    texts.append(Text(figure.title, MARGIN, height - MARGIN - 16, 30, bold=True))
    texts.append(Text(figure.note, MARGIN, height - MARGIN - 54, 21, (90, 90, 90)))
    for number, panel in enumerate(panels):
        row, column = divmod(number, plan.columns)
        left, top = MARGIN + column * plan.cell, height - MARGIN - HEAD_HEIGHT - row * plan.height
        spare = plan.cell - plan.inner[0] - plan.beside[:, 0].sum()
        corner = np.array([left + plan.beside[0, 0] + spare / 2, top - plan.label - plan.beside[1, 1] - plan.inner[1]])
        view = View(figure.reach[0], corner, plan.factor, plan.sign, weight)
        if panel.label:
            texts.append(Text(panel.label, left, top - 16, LABEL_SIZE))
        patches.extend(structure_patches(figure, view, panel))
        marks, names = sensor_marks(figure, view, panel, plan.placed)
        patches.extend(marks)
        texts.extend(names)
    return Picture(figure.width, height, tuple(patches), tuple(texts))


def _beside(figure: Figure, factor: float, placed: Placed) -> FloatArray:
    """Return the room (2, 2) px to the left and below, to the right and above, that supports and names need."""
    sign = _sign(figure, factor)
    below = 1.6 * sign + 8 if figure.outline.supports else ROW_GAP
    names = np.stack([-placed.reach[0], placed.reach[1] - factor * (figure.reach[1] - figure.reach[0])]) + 6
    return np.maximum(np.array([[SIDE_GAP, below], [SIDE_GAP, ROW_GAP]]), names if placed.names else 0.0)


def _sign(figure: Figure, factor: float) -> float:
    """Return the size (px) of supports: readable, yet small against the structure and between its nodes."""
    return float(np.clip(0.028 * figure.outline.size * factor, 18, 32))
