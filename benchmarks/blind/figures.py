"""The pictures of the blind benchmark: confusion, calibration, and how the rates fall."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.blind.confusion import Confusion
from benchmarks.blind.grid import Cell
from benchmarks.blind.rates import Share
from benchmarks.blind.reliability import Bin
from hybrid.figures import Sheet, figure

COLOURS = ("#0072B2", "#E69F00", "#009E73")  # Okabe & Ito
MARKERS = ("o", "s", "^")
DARK_SHARE = 0.6  # share from which a cell is too dark for black ink
LOW_SHARE = 0.05  # an end of a bar as low has no room for a number beneath it
STAGGER = 0.015  # between the lines' points, so that their bars do not hide each other


def draw_confusion(matrix: Confusion) -> Sheet:
    """Draw the share of each kind's cases that were named as each kind."""
    with figure(1, 1, "Hidden against named first (cases)") as (sheet, (axis,)):
        rows, columns = matrix.counts.shape
        sheet.figure.set_size_inches(2.4 + 0.3 * columns, 2.3 + 0.25 * rows)
        shares = matrix.counts / matrix.counts.sum(axis=1, keepdims=True)
        axis.imshow(shares, cmap="Blues", vmin=0, vmax=1.2, aspect="auto")
        for row, column in np.argwhere(matrix.counts):
            ink = "white" if shares[row, column] > DARK_SHARE else "black"
            axis.text(column, row, str(matrix.counts[row, column]), ha="center", va="center", fontsize=8, color=ink)
        axis.set_xticks(range(columns), [word.replace("_", " ") for word in matrix.named], rotation=90, fontsize=8)
        axis.set_yticks(range(rows), [word.replace("_", " ") for word in matrix.hidden], fontsize=8)
        axis.set(xlabel="named first", ylabel="hidden")
    return sheet


def draw_calibration(bins: Sequence[Bin]) -> Sheet:
    """Draw the share of right findings against their probability, with 95 % intervals and counts."""
    with figure(1, 1, "Are the probabilities right?") as (sheet, (axis,)):
        sheet.figure.set_size_inches(4.6, 4.4)
        axis.plot([0, 1], [0, 1], "--", color="#555555", linewidth=1, label="right as often as said")
        promised = [item.promised for item in bins]
        _with_bars(axis, promised, [item.right for item in bins], 0, "findings (with their number)")
        for item in bins:
            low, high = item.right.interval
            end, up = (low, -11) if low > LOW_SHARE else (high, 4)  # points: clear of the axis
            offset = {"textcoords": "offset points", "xytext": (0, up), "ha": "center"}
            axis.annotate(str(item.right.count), (item.promised, end), **offset, fontsize=8)
        axis.set(xlabel="probability named", ylabel="share that is right", xlim=(0, 1.03), ylim=(0, 1.03))
        axis.legend(frameon=False, loc="upper left")
    return sheet


def draw_grid(cells: Sequence[Cell]) -> Sheet:
    """Draw how often the right cause is named first (left), and a wrong one at 0.9 (right), against size."""
    with figure(2, 2, "How the rates fall with noise and size of the hidden effect") as (sheet, (first, wrong)):
        sheet.figure.set_size_inches(10, 3.8)
        for number, noise in enumerate(dict.fromkeys(cell.noise for cell in cells)):
            own = [cell for cell in cells if cell.noise == noise]
            sizes = [cell.size + (number - 1) * STAGGER for cell in own]
            for axis, shares in ((first, [c.first for c in own]), (wrong, [c.wrong for c in own])):
                _with_bars(axis, sizes, shares, number % len(COLOURS), f"noise {100 * noise:.0f} %")
        for axis, label in ((first, "right cause first"), (wrong, "wrong cause at 0.9 or more")):
            axis.set(xlabel="size, from barely detectable to large", ylabel=label, ylim=(-0.03, 1.03))
        first.legend(frameon=False, loc="lower right")
    return sheet


def _with_bars(axis: Any, x: Sequence[float], shares: Sequence[Share], style: int, label: str) -> None:
    """Draw shares with their 95 % intervals in one of the styles."""
    y = np.array([item.value or 0.0 for item in shares])
    ends = np.array([item.interval for item in shares]).reshape(-1, 2)
    bars = np.maximum([y - ends[:, 0], ends[:, 1] - y], 0.0)
    look = {"fmt": f"{MARKERS[style]}-", "color": COLOURS[style], "capsize": 3, "linewidth": 1.2, "markersize": 4}
    axis.errorbar(x, y, yerr=bars, label=label, **look)
