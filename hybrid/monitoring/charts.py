"""Control charts: all frequencies together, then each natural frequency, over the recordings as they came."""

from collections.abc import Sequence
from typing import Any

from hybrid.figures import COLOURS, Sheet, figure
from hybrid.monitoring.observation import Limits, Observation, Standing
from hybrid.monitoring.tracked_modes import TrackedModes

PANEL = (7.6, 1.5)  # inches
MOST_NAMED = 8  # recordings along an axis
LONGEST_NAME = 14  # characters
LOOKS = {  # of a marker: form and colour, for those who print in black, too
    Standing.HISTORY: ("o", "#555555"),
    Standing.USUAL: ("o", COLOURS[0]),
    Standing.ALARM: ("X", COLOURS[5]),
}


def draw_charts(shown: Sequence[Observation], modes: TrackedModes) -> Sheet:
    """Draw T^2 over its limit, and the frequency of each of the ``modes`` with its limits, a panel each."""
    count = 1 + len(modes.frequencies)
    with figure(count, 1, "Control charts of natural frequencies") as (sheet, axes):
        sheet.figure.set_size_inches(PANEL[0], PANEL[1] * count + 0.6)
        _draw_distance(axes[0], shown)
        for mode, axis in enumerate(axes[1:]):
            _draw_mode(axis, shown, modes, mode)
        for axis in axes:
            axis.set_xlim(-0.5, len(shown) - 0.5)
            _name(axis, shown)
        axes[-1].set_xlabel("recording, in the order in which they came")
        handles, labels = axes[1 if count > 1 else 0].get_legend_handles_labels()
        if handles:
            sheet.figure.legend(handles, labels, loc="outside lower center", ncols=len(handles), frameon=False)
    return sheet


def _name(axis: Any, shown: Sequence[Observation]) -> None:
    """Name some of the recordings, evenly, so that names do not run into each other."""
    step = -(-len(shown) // MOST_NAMED)
    names = [(number, own.name) for number, own in enumerate(shown) if number % step == 0]
    texts = [name if len(name) <= LONGEST_NAME else f"{name[:LONGEST_NAME]}..." for _, name in names]
    axis.set_xticks([number for number, _ in names], texts, fontsize=7)


def _draw_distance(axis: Any, shown: Sequence[Observation]) -> None:
    for number, own in enumerate(shown):
        if own.distance is not None:
            form, colour = LOOKS[own.standing]
            axis.plot(number, max(own.distance, 1e-3), form, color=colour, markersize=5)
    axis.axhline(1.0, color="#555555", linewidth=0.8, linestyle="--")
    axis.set_yscale("log")
    axis.set_ylabel("T² / limit")


def _draw_mode(axis: Any, shown: Sequence[Observation], modes: TrackedModes, mode: int) -> None:
    named = set[Standing]()
    for number, own in enumerate(shown):
        seen = modes.of(own)[mode]
        if seen is not None:
            form, colour = LOOKS[own.standing]
            label = None if own.standing in named else own.standing.value
            named.add(own.standing)
            axis.errorbar(
                number, seen.frequency, 2 * seen.frequency_error, fmt=form, color=colour, markersize=5, label=label
            )
    judged = [(number, _nearest(own, modes.frequencies[mode])) for number, own in enumerate(shown) if own.limits]
    look = {"color": "#555555", "linewidth": 0.8, "drawstyle": "steps-mid"}
    numbers = [number for number, _ in judged]
    if judged:
        axis.plot(numbers, [limits.low for _, limits in judged], "--", label="control limits", **look)
        axis.plot(numbers, [limits.high for _, limits in judged], "--", **look)
    axis.set_ylabel(f"mode {mode + 1} (Hz)")


def _nearest(own: Observation, frequency: float) -> Limits:
    """Return the limits of a mode with a ``frequency`` (Hz): modes were numbered otherwise before others came up."""
    return min(own.limits, key=lambda limits: abs(limits.centre - frequency))
