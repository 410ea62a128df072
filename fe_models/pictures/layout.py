"""Lays out a figure: panels in rows at one scale, with title, colour bar, scale of lengths and legend."""

from collections import Counter
from collections.abc import Iterable, Sequence
from math import ceil

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.pictures.drawing import Picture, Text
from fe_models.pictures.figure import MARGIN, Figure, Panel, View
from fe_models.pictures.geometry import Outline, extent
from fe_models.pictures.legend import footer
from fe_models.pictures.panels import MASS_SHARE, ground_point, name_height, sensor_marks, structure_patches

HEAD = 84  # px, for title and note
LABEL_SIZE = 24  # px
LABEL = 34  # px, for the labels of panels, where there are any
GAP = 28  # px, beside a panel, for supports and sensors at its ends


def reach_of(outline: Outline, displacements: Iterable[FloatArray], scale: float) -> FloatArray:
    """Return the (2, 2) corners in m of all that the ``displacements`` (frame, dof) will show, ground included."""
    corners = [extent(outline, displacements, scale)]
    corners.extend(ground_point(outline, node, direction)[None] for node, direction in outline.grounded)
    points = np.vstack(corners)
    beyond = 0.6 * MASS_SHARE * outline.spacing if outline.masses else 0.0
    return np.stack([points.min(axis=0) - beyond, points.max(axis=0) + beyond])


def compose(figure: Figure, panels: tuple[Panel, ...]) -> Picture:
    """Return the picture of ``panels`` in rows, all at one scale and in one range of colours."""
    columns, factor = _grid(figure, panels)
    label = LABEL if any(panel.label for panel in panels) else 0
    sign, weight = _sign(figure, factor), 1.0 if columns == 1 else 0.75
    border = _border(figure, factor, sign)
    cell_width = (figure.width - 2 * MARGIN) / columns
    inner = factor * (figure.reach[1] - figure.reach[0])
    cell_height = inner[1] + 2 * border + label
    rows = ceil(len(panels) / columns)
    foot, patches, texts = footer(figure, factor)
    height = ceil(MARGIN + foot + rows * cell_height + HEAD + MARGIN)
    height += height % 2  # films want even sizes
    texts.append(Text(figure.title, MARGIN, height - MARGIN - 16, 30, bold=True))
    texts.append(Text(figure.note, MARGIN, height - MARGIN - 54, 21, (90, 90, 90)))
    for number, panel in enumerate(panels):
        row, column = divmod(number, columns)
        left, top = MARGIN + column * cell_width, height - MARGIN - HEAD - row * cell_height
        corner = np.array([left + (cell_width - inner[0]) / 2, top - label - border - inner[1]])
        view = View(figure.reach[0], corner, factor, sign, weight)
        if panel.label:
            texts.append(Text(panel.label, left, top - 16, LABEL_SIZE))
        patches.extend(structure_patches(figure, view, panel))
        marks, names = sensor_marks(figure, view, panel)
        patches.extend(marks)
        texts.extend(names)
    return Picture(figure.width, height, tuple(patches), tuple(texts))


def _grid(figure: Figure, panels: Sequence[Panel]) -> tuple[int, float]:
    """Return the number of columns and the pixels per metre that show the panels, and their labels, largest."""
    count = len(panels)
    widest = max(Text(panel.label, 0, 0, LABEL_SIZE).width for panel in panels)
    span = np.maximum(figure.reach[1] - figure.reach[0], 1e-3 * figure.outline.size)
    options = []
    for columns in range(1, min(count, 4) + 1):
        width = (figure.width - 2 * MARGIN) / columns - 2 * GAP
        if columns > 1 and width + GAP < widest:
            break
        factor = min(width / span[0], 0.42 * figure.width / span[1])
        room = 2 * _border(figure, factor, _sign(figure, factor)) + LABEL
        tall = ceil(count / columns) * (factor * span[1] + room)
        options.append((columns, float(factor), tall))
    fitting = [option for option in options if option[2] <= (0.85 if count <= 6 else 1.1) * figure.width]
    best = max(fitting, key=lambda option: option[1]) if fitting else min(options, key=lambda option: option[2])
    return best[0], best[1]


def _border(figure: Figure, factor: float, sign: float) -> float:
    """Return the room (px) above and below the structure: for supports, and for the names of sensors at one node."""
    room = 1.6 * sign + 8 if figure.outline.supports else 16.0
    if figure.sensors:
        most = max(Counter(sensor.node for sensor in figure.sensors).values())
        room = max(room, name_height(figure.outline, factor) + 21 * (most - 1) + 12)
    return room


def _sign(figure: Figure, factor: float) -> float:
    """Return the size (px) of supports: readable, yet small against the structure and between its nodes."""
    return float(np.clip(0.028 * figure.outline.size * factor, 18, 32))
