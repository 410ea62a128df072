"""The paper's figures as curves: channels, latent states, displacement at a node, force-displacement loop, training."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from io import StringIO
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
# of Okabe & Ito: distinguished by everyone
COLOURS = (
    "#0072B2",
    "#E69F00",
    "#009E73",
    "#CC79A7",
    "#56B4E9",
    "#D55E00",
)
MOST_POINTS = 2500  # of a line that is drawn as one on a page: longer ones are fewer bytes as an image
PANEL_WIDTH, PANEL_HEIGHT = 6.2, 1.9  # inches
WHOLE_WIDTH, ZOOM_WIDTH = 4.2, 2.6  # inches, of a long signal and of the part of it beside it
ZOOM_PERIODS = 6.0  # of the strongest vibration: as many can be distinguished, and followed by eye
MIN_ZOOM_RATIO = 3.0  # a signal so many times as long as that has a part shown larger
Curves = Mapping[str, FloatArray]
"""A name of `STYLES` and values (time, panel)."""


@dataclass(frozen=True, eq=False)
class Sheet:
    """A ``figure`` of matplotlib with its ``title``, laid out once, and then the same in a file and on a page."""

    figure: Any
    title: Any

    def save(self, path: Path) -> Path:
        """Write it whole into ``path``, a file of pixels, and return that."""
        with _own_settings(), writing(path) as temporary:
            self.figure.savefig(temporary)
        return path

    def svg(self) -> str:
        """Return it as SVG for a page, cut off below its title: the page has a caption."""
        from matplotlib.transforms import Bbox  # loaded only where something is drawn

        written = StringIO()
        with _own_settings():
            top = self.title.get_window_extent().y0 / self.figure.dpi  # inches
            shown = Bbox.from_extents(0.0, 0.0, self.figure.get_figwidth(), top)
            self.title.set_visible(False)
            try:
                self.figure.savefig(written, format="svg", bbox_inches=shown, transparent=True, metadata={"Date": None})
            finally:
                self.title.set_visible(True)
        return written.getvalue()


Sheets = Mapping[str, Sheet]
"""Sheets by the names of the files into which they are saved."""
NO_SHEETS: Sheets = {}


@contextmanager
def figure(
    panels: int, columns: int, title: str, widths: Sequence[float] | None = None
) -> Iterator[tuple[Sheet, list[Any]]]:
    """Give a sheet and its axes, one a panel, to draw on; when the block ends, it is laid out and may be saved.

    ``widths``: of the columns in inches; left out, all are as wide as one picture is.
    """
    from matplotlib.figure import Figure  # loaded only where something is drawn
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    rows = ceil(panels / columns)
    with _own_settings():
        inches = list(widths) if widths else [PANEL_WIDTH] * columns
        layout = ConstrainedLayoutEngine()
        drawing = Figure(figsize=(sum(inches), PANEL_HEIGHT * rows + 0.9), layout=layout, dpi=130)
        axes = drawing.subplots(rows, columns, squeeze=False, width_ratios=inches).ravel().tolist()
        for empty in axes[panels:]:
            empty.remove()
        yield Sheet(drawing, drawing.suptitle(title, fontsize=11)), axes[:panels]
        for line in (line for axis in axes[:panels] for line in axis.lines):
            line.set_rasterized(len(line.get_xdata()) > MOST_POINTS)
        _take_literally(drawing)
        layout.execute(drawing)
        drawing.set_layout_engine(None)  # else each saving would lay it out again


@contextmanager
def _own_settings() -> Iterator[None]:
    """Let matplotlib draw as it does by itself, whatever a user's matplotlibrc asks for, such as LaTeX."""
    import matplotlib as mpl  # loaded only where something is drawn

    look: dict[str, Any] = {"axes.spines.top": False, "axes.spines.right": False, "font.size": 9}
    look |= {"svg.fonttype": "none", "svg.hashsalt": "page"}  # texts stay texts; the same figure is the same file
    with mpl.rc_context(), catch_warnings():
        simplefilter("ignore", UserWarning)  # of letters that the font lacks, in somebody's names
        mpl.rcdefaults()
        mpl.rcParams.update(look)  # type: ignore[arg-type]  # of texts that are names of settings
        yield


def _take_literally(drawing: Any) -> None:
    """Draw all texts of a figure as they are, names with "$" or "_" among them; numbers at axes may be formulas."""
    from matplotlib.axis import Axis
    from matplotlib.text import Text
    from matplotlib.ticker import FixedFormatter, FuncFormatter

    artists = [drawing]
    while artists:
        artist = artists.pop()
        if isinstance(artist, Text):
            artist.set_parse_math(False)
        if not isinstance(artist, Axis):
            artists += artist.get_children()
            continue
        artists.append(artist.label)  # of ticks with numbers nothing is asked, which would make them all
        if isinstance(artist.get_major_formatter(), FixedFormatter | FuncFormatter):  # of names
            artists += artist.get_ticklabels()


def draw_curves(time: FloatArray, curves: Curves, labels: Sequence[str], title: str) -> Sheet:
    """Draw several quantities over time (s), a panel each; ``labels`` are their axes' names, with units."""
    with figure(len(labels), 2 if len(labels) > 1 else 1, title) as (sheet, axes):
        for panel, (axis, label) in enumerate(zip(axes, labels, strict=True)):
            for name, values in curves.items():
                axis.plot(time, values[:, panel], label=name, **STYLES[name])
            axis.set_ylabel(label)
            axis.margins(x=0)
        for axis in axes[-2:]:
            axis.set_xlabel("time (s)")
        sheet.figure.legend(
            *axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=len(curves), frameon=False
        )
    return sheet


def draw_channels(time: FloatArray, curves: Curves, labels: Sequence[str], title: str) -> Sheet:
    """Draw what `draw_curves` does, and beside each long signal the part in which its curves differ most."""
    span = clearest_span(time, curves)
    if span is None:
        return draw_curves(time, curves, labels, title)
    beside = 2 if len(labels) > 1 else 1
    with figure(2 * len(labels), 2 * beside, title, [WHOLE_WIDTH, ZOOM_WIDTH] * beside) as (sheet, axes):
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
        sheet.figure.legend(
            *axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=len(curves), frameon=False
        )
    return sheet


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


def draw_latent(time: FloatArray, q: Curves, q_dot: Curves, title: str) -> Sheet:
    """Draw modal coordinates (left) and modal velocities (right), a row a mode; curves (time, mode)."""
    modes = next(iter(q.values())).shape[1]
    both = {name: np.stack([q[name], q_dot[name]], axis=2).reshape(len(time), -1) for name in q}
    labels = [label for mode in range(1, modes + 1) for label in (f"q{mode}", f"q{mode}'")]
    return draw_curves(time, both, labels, title)


def draw_loop(displacement: Curves, force: Curves, node: int) -> Sheet:
    """Draw the restoring force -(M u'')_i (N) at a node against its displacement (m); curves (time,)."""
    title = f"Force against displacement at node {node}, first test window"
    with figure(1, 1, title) as (sheet, (axis,)):
        sheet.figure.set_size_inches(6.2, 4.6)
        for name in displacement:
            axis.plot(displacement[name], force[name], label=name, **STYLES[name])
        axis.set(xlabel=f"displacement at node {node} (m)", ylabel="inertia force -m a (N)")
        sheet.figure.legend(loc="outside lower center", ncols=len(displacement), frameon=False)
    return sheet
