"""The paper's figures as curves: channels, latent states, displacement at a node, force-displacement loop, training."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.files.atomic import writing
from fe_models.recordings import Sensor

STYLES: dict[str, dict[str, Any]] = {  # colours of Okabe & Ito: distinguished by everyone
    "measured": {"color": "#555555", "linewidth": 2.2, "alpha": 0.55},
    "truth": {"color": "#555555", "linewidth": 2.2, "alpha": 0.55},
    "FE model": {"color": "#E69F00", "linewidth": 1.0, "linestyle": "--"},
    "hybrid": {"color": "#0072B2", "linewidth": 1.1},
}
PANEL_HEIGHT = 1.9  # inches
Curves = Mapping[str, FloatArray]
"""A name of `STYLES` and values (time, panel)."""


@contextmanager
def figure(path: Path, panels: int, columns: int, title: str) -> Iterator[tuple[Any, list[Any]]]:
    """Give a figure and its axes, one a panel; written to ``path`` when the block ends."""
    import matplotlib as mpl  # loaded only where something is drawn
    from matplotlib.figure import Figure

    rows = ceil(panels / columns)
    with mpl.rc_context({"axes.spines.top": False, "axes.spines.right": False, "font.size": 9}):
        sheet = Figure(figsize=(6.2 * columns, PANEL_HEIGHT * rows + 0.9), layout="constrained", dpi=130)
        axes = sheet.subplots(rows, columns, squeeze=False).ravel().tolist()
        for empty in axes[panels:]:
            empty.remove()
        sheet.suptitle(title, fontsize=11)
        yield sheet, axes[:panels]
        with writing(path) as temporary:
            sheet.savefig(temporary)


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
