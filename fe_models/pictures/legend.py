"""The foot of a figure: colour bar or named colours, a scale of lengths, and what each line and sign stands for."""

from collections.abc import Callable, Sequence
from math import floor, log10

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.pictures import symbols
from fe_models.pictures.captions import readable
from fe_models.pictures.drawing import GREY, INK, LIGHT, PALE, Color, Patch, Text, disc, ramp, stroke
from fe_models.pictures.figure import MARGIN, Figure
from fe_models.pictures.geometry import Outline
from fe_models.pictures.panels import family, line_styles
from fe_models.pictures.sensor_names import HELD_OUT_COLOR, MEASURED_COLOR

Icon = Callable[[FloatArray], list[Patch]]  # draws a sample, 44 px wide, centred at a place
Entry = tuple[str, Icon]

ROW_HEIGHT = 40  # px, of the legend
BAR_HEIGHT = 84  # px, of the row with colour bar and scale of lengths
BAR_WIDTH = 460
ICON_WIDTH = 44  # px, width of a sample
HALF_ICON: FloatArray = np.array([19.0, 0.0])
SUPPORT_RISE: FloatArray = np.array([0.0, 12.0])  # px, of a support above the middle of its sign
TEXT_SIZE = 20


def footer(figure: Figure, factor: float) -> tuple[float, list[Patch], list[Text]]:
    """Return the height (px) of the foot, and what is in it; ``factor`` is the scale of the panels (px/m)."""
    rows, patches, texts = legend_rows(_entries(figure), figure.width)
    base = float(MARGIN + ROW_HEIGHT * rows)
    if not figure.named:
        _color_bar(figure, base, patches, texts)
    length_scale(figure.width, factor, base + 40, patches, texts)
    return ROW_HEIGHT * rows + BAR_HEIGHT, patches, texts


def legend_rows(entries: Sequence[Entry], width: float) -> tuple[int, list[Patch], list[Text]]:
    """Return how many rows the samples and names take on a picture ``width`` px wide, and what is drawn of them."""
    placed: list[tuple[float, int, str, Icon]] = []
    left, row = float(MARGIN), 0
    for name, icon in entries:
        taken = ICON_WIDTH + 12 + Text(name, 0, 0, TEXT_SIZE).width
        if left + taken > width - MARGIN and left > MARGIN:
            left, row = float(MARGIN), row + 1
        placed.append((left, row, name, icon))
        left += taken + 30
    patches: list[Patch] = []
    texts: list[Text] = []
    for left, line, name, icon in placed:
        y = MARGIN + ROW_HEIGHT * (row - line) + ROW_HEIGHT / 2
        patches.extend(icon(np.array([left + ICON_WIDTH / 2, y])))
        texts.append(Text(name, left + ICON_WIDTH + 12, y, TEXT_SIZE))
    return row + 1, patches, texts


def nice_step(span: float, parts: int) -> float:
    """Return 1, 2 or 5 x 10^n, the smallest step that cuts ``span`` into at most ``parts``."""
    decade = 10.0 ** floor(log10(span / parts))
    return next(digit * decade for digit in (1.0, 2.0, 5.0, 10.0) if digit * decade * parts >= span * (1 - 1e-9))


def _color_bar(figure: Figure, base: float, patches: list[Patch], texts: list[Text]) -> None:
    factor, unit = readable(figure.largest, figure.unit)
    largest = figure.largest * factor
    name = f"displacement ({unit})"
    texts.append(Text(name, MARGIN, base + 44, TEXT_SIZE + 1))
    left = MARGIN + Text(name, 0, 0, TEXT_SIZE + 1).width + 20
    share = np.linspace(0.0, 1.0, 33)
    line = np.stack([left + BAR_WIDTH * share, np.full_like(share, base + 44)], axis=1)
    patches.append(stroke(line[None], 24, INK, caps=False))
    patches.append(stroke(line[None], 20, ramp(share)[None], caps=False))
    if largest <= 0:
        texts.append(Text("0", left, base + 16, TEXT_SIZE - 1, align="center"))
        return
    step = nice_step(largest, 5)
    round_values = np.arange(0.0, largest, step)
    for tick in (*round_values[largest - round_values > 0.5 * step], largest):  # the end is always labelled
        x = left + BAR_WIDTH * tick / largest
        patches.append(stroke(np.array([[[x, base + 32], [x, base + 26]]]), 2, INK, caps=False))
        texts.append(Text(f"{tick:.3g}", x, base + 14, TEXT_SIZE - 1, align="center"))


def length_scale(width: float, factor: float, y: float, patches: list[Patch], texts: list[Text]) -> None:
    """Add a bar of a round length of the structure at the right, so that sizes can be read off."""
    length = nice_step(90 / factor, 1)  # m, drawn 90 to 225 px long
    right = width - MARGIN
    left = right - length * factor
    patches.append(stroke(np.array([[[left, y], [right, y]]]), 3, INK, caps=False))
    patches.append(stroke(np.array([[[x, y - 8], [x, y + 8]] for x in (left, right)]), 3, INK, caps=False))
    texts.append(Text(f"{length:g} m", (left + right) / 2, y - 26, TEXT_SIZE - 1, align="center"))


def _entries(figure: Figure) -> list[Entry]:
    """Return name and sample of all that the panels show."""
    outline = figure.outline
    entries: list[Entry] = [(name, _line(width, color)) for name, color, width in figure.named]
    entries += member_entries(outline, GREY, beams=not figure.named)  # named shapes have no edges
    entries.append(("undeformed", _undeformed(outline)))
    entries += support_entries(outline)
    for role, text, color in (("measured", "sensor", MEASURED_COLOR), ("held_out", "sensor held out", HELD_OUT_COLOR)):
        if any(sensor.role == role for sensor in figure.sensors):
            entries.append((text, _dot(color)))
    return entries


def member_entries(outline: Outline, color: Color, beams: bool = True) -> list[Entry]:
    """Return name and sample of each kind of member, of masses and of springs to ground."""
    entries: list[Entry] = []
    seen = set()
    for group, (width, edged) in zip(outline.groups, line_styles(outline), strict=True):
        name = family(group.name)
        if name in seen or (group.kind == "beam" and not beams):
            continue
        seen.add(name)
        if group.kind == "point":
            entries.append((name, lambda at: [disc(at[None], 7, GREY)]))
        elif group.kind == "spring":
            entries.append((name, _spring))
        else:
            entries.append((name, _line(width, color, edged)))
    if outline.masses:
        entries.append(("mass", lambda at: symbols.mass(at, 24, GREY)))
    if outline.grounded and "spring" not in {group.kind for group in outline.groups}:
        entries.append(("spring to ground", _spring))
    return entries


def support_entries(outline: Outline) -> list[Entry]:
    """Return name and sign of each kind of support."""
    carried = tuple(str(direction) for direction in np.unique(outline.dofs.direction))
    names = dict.fromkeys(symbols.support_name(support.directions, carried) for support in outline.supports)
    return [(name, _support(name)) for name in names]


def _line(width: float, color: Color, edged: bool = False) -> Icon:
    def draw(at: FloatArray) -> list[Patch]:
        line = np.stack([at - HALF_ICON, at + HALF_ICON])[None]
        edge = [stroke(line, width + 4, INK)] if edged else []
        return [*edge, stroke(line, width, color)]

    return draw


def _dot(color: Color) -> Icon:
    return lambda at: [disc(at[None], 8, color)]


def _support(name: str) -> Icon:
    rise = SUPPORT_RISE / 2 if name in ("clamped", "held", "rotation held") else SUPPORT_RISE
    return lambda at: symbols.support(name, at + rise, 24)


def _spring(at: FloatArray) -> list[Patch]:
    return [stroke(symbols.zigzag(at - HALF_ICON, at + HALF_ICON, 9, 4), 3, GREY)]


def _undeformed(outline: Outline) -> Icon:
    if outline.masses:
        return lambda at: symbols.mass(at, 24, PALE, LIGHT)
    if all(group.kind == "point" for group in outline.groups):
        return _dot(LIGHT)
    return _line(6, LIGHT)
