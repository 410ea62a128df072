"""The paper's figures as curves: channels, latent states, displacement at a node, force-displacement loop, training."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from math import ceil
from pathlib import Path
from typing import Any
from warnings import catch_warnings, simplefilter

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.files.atomic import writing
from fe_models.recordings import Sensor
from fe_models.spectra import power_spectrum

STYLES: dict[str, dict[str, Any]] = {  # colours of Okabe & Ito: distinguished by everyone
    "measured": {"color": "#555555", "linewidth": 2.2, "alpha": 0.55},
    "truth": {"color": "#555555", "linewidth": 2.2, "alpha": 0.55},
    "FE model": {"color": "#E69F00", "linewidth": 1.0, "linestyle": "--"},
    "hybrid": {"color": "#0072B2", "linewidth": 1.1},
}
COLOURS = (
    "#0072B2",
    "#E69F00",
    "#009E73",
    "#CC79A7",
    "#56B4E9",
    "#D55E00",
)  # of Okabe & Ito: distinguished by everyone
MOST_POINTS = 2500  # of a line that is drawn as one on a page: longer ones are fewer bytes as an image
PANEL_WIDTH, PANEL_HEIGHT = 6.2, 1.9  # inches
WHOLE_WIDTH, ZOOM_WIDTH = 4.2, 2.6  # inches, of a long signal and of the part of it beside it
ZOOM_PERIODS = 6.0  # of the strongest vibration: as many can be distinguished, and followed by eye
MIN_ZOOM_RATIO = 3.0  # a signal so many times as long as that has a part shown larger
Curves = Mapping[str, FloatArray]
"""A name of `STYLES` and values (time, panel)."""


@contextmanager
def figure(
    path: Path, panels: int, columns: int, title: str, widths: Sequence[float] | None = None
) -> Iterator[tuple[Any, list[Any]]]:
    """Give a figure and its axes, one a panel; written to ``path`` when the block ends.

    ``widths``: of the columns in inches; left out, all are as wide as one picture is. An .svg is for a page, whose
    caption says what the title does.
    """
    import matplotlib as mpl  # loaded only where something is drawn
    from matplotlib.figure import Figure

    rows, on_page = ceil(panels / columns), path.suffix == ".svg"
    look: dict[str, Any] = {"axes.spines.top": False, "axes.spines.right": False, "font.size": 9}
    look |= {"svg.fonttype": "none", "svg.hashsalt": "page"}  # texts stay texts; the same figure is the same file
    with mpl.rc_context(), catch_warnings():
        simplefilter("ignore", UserWarning)  # of letters that the font lacks, in somebody's names
        mpl.rcdefaults()  # whatever a user's matplotlibrc asks for, such as LaTeX
        mpl.rcParams.update(look)  # type: ignore[arg-type]  # of texts that are names of settings
        inches = list(widths) if widths else [PANEL_WIDTH] * columns
        sheet = Figure(figsize=(sum(inches), PANEL_HEIGHT * rows + 0.9), layout="constrained", dpi=130)
        axes = sheet.subplots(rows, columns, squeeze=False, width_ratios=inches).ravel().tolist()
        for empty in axes[panels:]:
            empty.remove()
        if not on_page:
            sheet.suptitle(title, fontsize=11)
        yield sheet, axes[:panels]
        for line in (line for axis in axes[:panels] for line in axis.lines):
            line.set_rasterized(on_page and len(line.get_xdata()) > MOST_POINTS)
        _take_literally(sheet)
        with writing(path) as temporary:
            sheet.savefig(temporary, **({"transparent": True} if on_page else {}))


def _take_literally(sheet: Any) -> None:
    """Draw all texts of a figure as they are, names with "$" or "_" among them; numbers at axes may be formulas."""
    from matplotlib.text import Text
    from matplotlib.ticker import FixedFormatter

    numbers = {
        id(label)
        for axes in sheet.axes
        for side in (axes.xaxis, axes.yaxis)
        if not isinstance(side.get_major_formatter(), FixedFormatter)
        for label in side.get_ticklabels(which="both")
    }
    for text in sheet.findobj(Text):
        text.set_parse_math(id(text) in numbers)


def draw_curves(path: Path, time: FloatArray, curves: Curves, labels: Sequence[str], title: str) -> Path:
    """Draw several quantities over time (s), a panel each; ``labels`` are their axes' names, with units."""
    with figure(path, len(labels), 2 if len(labels) > 1 else 1, title) as (sheet, axes):
        for panel, (axis, label) in enumerate(zip(axes, labels, strict=True)):
            for name, values in curves.items():
                axis.plot(time, values[:, panel], label=name, **STYLES[name])
            axis.set_ylabel(label)
            axis.margins(x=0)
        for axis in axes[-2:]:
            axis.set_xlabel("time (s)")
        sheet.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=len(curves), frameon=False)
    return path


def draw_channels(path: Path, time: FloatArray, curves: Curves, labels: Sequence[str], title: str) -> Path:
    """Draw what `draw_curves` does, and beside each long signal the part in which its curves differ most."""
    span = clearest_span(time, curves)
    if span is None:
        return draw_curves(path, time, curves, labels, title)
    beside = 2 if len(labels) > 1 else 1
    with figure(path, 2 * len(labels), 2 * beside, title, [WHOLE_WIDTH, ZOOM_WIDTH] * beside) as (sheet, axes):
        for panel, label in enumerate(labels):
            whole, part = axes[2 * panel : 2 * panel + 2]
            for name, values in curves.items():
                for axis in (whole, part):
                    axis.plot(time, values[:, panel], label=name, **STYLES[name])
            whole.set_ylabel(label)
            whole.margins(x=0)
            show_part(whole, part, span)
        for axis in axes[-2 * beside :]:
            axis.set_xlabel("time (s)")
        sheet.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=len(curves), frameon=False)
    return path


def show_part(whole: Any, part: Any, span: tuple[float, float]) -> None:
    """Let the axes ``part`` show a ``span`` of time (s) of what is drawn on both, and mark it on ``whole``."""
    whole.axvspan(*span, color="#DDDDDD", zorder=-1)
    part.set_facecolor("#F4F4F4")
    part.set(xlim=span, ylim=whole.get_ylim())


def clearest_span(time: FloatArray, curves: Curves) -> tuple[float, float] | None:
    """Return from when to when (s) the ``curves`` (time, panel) differ most, a few periods of the first one long.

    None where the whole is not much longer. Curves count within the first one's range: a forecast may run away.
    """
    first = next(iter(curves.values()))
    low, high = first.min(axis=0), first.max(axis=0)
    size = np.where(high > low, high - low, 1.0)
    power = power_spectrum((first - first.mean(axis=0)) / size).sum(axis=1)
    samples = round(ZOOM_PERIODS * len(time) / max(1, int(np.argmax(power[1:])) + 1))
    if samples * MIN_ZOOM_RATIO > len(time):
        return None
    inside = np.stack([np.clip(values, low, high) for values in curves.values()]) / size  # (curve, time, panel)
    apart = np.concatenate([[0.0], np.cumsum(np.ptp(inside, axis=0).sum(axis=1))])
    start = int(np.argmax(apart[samples:] - apart[:-samples]))
    return float(time[start]), float(time[start + samples - 1])


def channel_labels(sensors: Sequence[Sensor]) -> list[str]:
    """Return an axis name for each sensor; those never fitted are marked."""
    return [
        f"{sensor.name} ({'-' if sensor.unit == '1' else sensor.unit})" + (", held out" * (sensor.role == "held_out"))
        for sensor in sensors
    ]


def draw_latent(path: Path, time: FloatArray, q: Curves, q_dot: Curves, title: str) -> Path:
    """Draw modal coordinates (left) and modal velocities (right), a row a mode; curves (time, mode)."""
    modes = next(iter(q.values())).shape[1]
    both = {name: np.stack([q[name], q_dot[name]], axis=2).reshape(len(time), -1) for name in q}
    labels = [label for mode in range(1, modes + 1) for label in (f"q{mode}", f"q{mode}'")]
    return draw_curves(path, time, both, labels, title)


def draw_loop(path: Path, displacement: Curves, force: Curves, node: int) -> Path:
    """Draw the restoring force -(M u'')_i (N) at a node against its displacement (m); curves (time,)."""
    title = f"Force against displacement at node {node}, first test window"
    with figure(path, 1, 1, title) as (sheet, (axis,)):
        sheet.set_size_inches(6.2, 4.6)
        for name in displacement:
            axis.plot(displacement[name], force[name], label=name, **STYLES[name])
        axis.set(xlabel=f"displacement at node {node} (m)", ylabel="inertia force -m a (N)")
        sheet.legend(loc="outside lower center", ncols=len(displacement), frameon=False)
    return path
