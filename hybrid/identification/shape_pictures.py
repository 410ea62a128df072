"""How alike shapes are: matrices of the modal assurance criterion, and its coordinates."""

import numpy as np

from fe_models.modes import mac
from hybrid.figures import COLOURS, Sheet, figure
from hybrid.identification.comparison_pictures import MARKERS
from hybrid.identification.recording_comparison import Compared

ON_DARK, ON_LIGHT = "#fefefe", "#333333"  # of labels on cells, which are as dark on a page that is dark itself
CELL = 0.42  # inches of a matrix's cell
MAX_PANELS = 6  # recordings drawn: the first ones
DARK = 0.55  # of a cell's value, from which on its number is white


def draw_mac(compared: Compared) -> Sheet:
    """Draw the MAC of the model's modes with those of each recording, and of the model's with one another."""
    from matplotlib.patches import Rectangle  # loaded only where something is drawn

    shown = compared.recordings[:MAX_PANELS]
    nominal = [f"{number + 1}: {frequency:#.3g}" for number, frequency in enumerate(compared.nominal)]
    none = list[tuple[int, int]]()
    panels = [("the model with itself", nominal, mac(compared.shapes, compared.shapes), none)]
    for observed in shown:
        names = [f"{observed.identified.frequencies[number]:#.3g}" for number in observed.shown]
        pairs = [(mode, observed.shown.index(own)) for mode, own in compared.pairs(observed) if own in observed.shown]
        panels.append((observed.name, names, observed.criterion[:, observed.shown], pairs))
    title = "Modal assurance criterion (MAC) at the sensors (framed: taken for one mode)" + (
        f"\n(the first {MAX_PANELS} recordings)" if len(compared.recordings) > MAX_PANELS else ""
    )
    columns = min(len(panels), 3)
    widest = max(len(names) for _, names, *_ in panels)
    with figure(len(panels), columns, title) as (sheet, axes):
        rows = -(-len(panels) // columns)
        sheet.figure.set_size_inches(
            columns * max(CELL * widest + 1.1, 2.6), rows * max(CELL * len(nominal) + 1.2, 2.0) + 0.7
        )
        for axis, (name, names, values, pairs) in zip(axes, panels, strict=True):
            image = axis.imshow(values, cmap="Blues", vmin=0, vmax=1, aspect="auto")
            for row, column in np.ndindex(values.shape):
                value = values[row, column]
                colour = ON_DARK if value > DARK else ON_LIGHT
                axis.text(column, row, f"{value:.2f}", ha="center", va="center", fontsize=6.5, color=colour)
            for row, column in pairs:
                corner = (column - 0.5, row - 0.5)
                axis.add_patch(Rectangle(corner, 1.0, 1.0, edgecolor=COLOURS[5], facecolor="none", linewidth=1.4))
            axis.set_xticks(range(len(names)), names, rotation=60, fontsize=7)
            axis.set_yticks(range(len(nominal)), nominal, fontsize=7)
            axis.set_title(name, fontsize=9)
            axis.set_xlabel("identified (Hz)" if names is not nominal else "model (Hz)", fontsize=8)
            axis.set_ylabel("model (Hz)", fontsize=8)
        sheet.figure.colorbar(image, ax=axes, shrink=0.6, label="MAC")
    return sheet


def draw_coordinate_mac(compared: Compared) -> Sheet:
    """Draw the coordinate MAC of each sensor, a marker a recording."""
    shown = compared.recordings[:MAX_PANELS]
    title = "Coordinate MAC of recordings with the model\n(1: the sensor moves as in the model, in all paired modes)"
    with figure(1, 1, title) as (sheet, (axis,)):
        sheet.figure.set_size_inches(max(0.55 * len(compared.sensors) + 2.0, 5.0), 3.4)
        places, least = np.arange(len(compared.sensors)), 1.0
        spread = np.linspace(-0.22, 0.22, len(shown)) if len(shown) > 1 else np.zeros(1)
        for row, observed in enumerate(shown):
            values = compared.coordinate_mac(observed)
            least = min(least, float(np.nanmin(values)))
            style = {"color": COLOURS[row % len(COLOURS)], "linewidth": 1.0}
            axis.vlines(places + spread[row], values, 1.0, **style)
            axis.plot(
                places + spread[row], values, MARKERS[row % len(MARKERS)], markersize=5, label=observed.name, **style
            )
        axis.axhline(1.0, color="#555555", linewidth=0.8)
        axis.set_xticks(places, compared.sensors)
        room = max(1 - least, 0.01)
        axis.set_ylim(max(0.0, 1 - 1.15 * room), 1 + 0.05 * room)
        axis.set(xlabel="sensor", ylabel="coordinate MAC")
        sheet.figure.legend(loc="outside lower center", ncols=min(len(shown), 3), frameon=False)
    return sheet
