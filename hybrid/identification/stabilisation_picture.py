"""The stabilisation diagram: poles of rising order over the spectrum; columns of them stand for modes."""

import numpy as np

from fe_models.recordings import Dataset
from hybrid.figures import COLOURS, Sheet, figure
from hybrid.identification.comparison_pictures import AVERAGES, averaged_power
from hybrid.identification.recording_comparison import Compared

PANEL_WIDTH, PANEL_HEIGHT = 7.0, 2.6  # inches
MAX_PANELS = 8  # recordings drawn: the first ones
HEADROOM = 1.3  # times the highest order: room for the frequencies of modes
FEW = 3  # parts of a free decay over which its power is averaged
LEVELS = 3  # heights, in turn, at which frequencies are written, so that neighbours do not lie over one another


def draw_stabilisation(dataset: Dataset, compared: Compared) -> Sheet:
    """Draw the poles of each recording, those of modes apart from the others, and the modes that were kept."""
    singles = [(recording, data) for recording in dataset.recordings for data in recording.data][:MAX_PANELS]
    shown = compared.recordings[:MAX_PANELS]
    title = "Stabilisation: poles over the order of the identified system" + (
        f" (the first {MAX_PANELS} recordings)" if len(compared.recordings) > MAX_PANELS else ""
    )
    with figure(len(shown), 1, title) as (sheet, axes):
        sheet.figure.set_size_inches(PANEL_WIDTH, PANEL_HEIGHT * len(shown) + 0.9)
        for axis, (recording, data), observed in zip(axes, singles, shown, strict=True):
            poles, modes = observed.found.stabilisation, observed.identified
            rate = dataset.rate_of(recording)
            frequencies, power = averaged_power(data, rate, AVERAGES if observed.found.is_ambient else FEW)
            behind = axis.twinx()
            behind.semilogy(frequencies[1:], power[1:], color="#BBBBBB", linewidth=0.9)
            for minor in (False, True):  # a logarithmic axis would lay out hundreds of ticks that nobody sees
                behind.set_yticks([], minor=minor)
            behind.spines["right"].set_visible(False)
            axis.set_zorder(behind.get_zorder() + 1)
            axis.patch.set_visible(False)
            at = np.abs(poles.roots) / (2 * np.pi)
            stable = poles.mode >= 0
            other = {"color": "#777777", "marker": "x", "s": 9, "linewidths": 0.6, "label": "other pole"}
            axis.scatter(at[~stable], poles.order[~stable], **other)
            own = {"color": COLOURS[0], "marker": "o", "s": 10, "linewidths": 0, "label": "stable pole"}
            axis.scatter(at[stable], poles.order[stable], **own)
            top = float(poles.order.max(initial=2))
            for number, frequency in enumerate(modes.frequencies):
                axis.axvline(frequency, color=COLOURS[5], linewidth=0.7, label="mode (Hz)", zorder=0)
                height = top * (1.04 + 0.08 * (number % LEVELS))
                axis.text(frequency, height, f"{frequency:#.3g}", ha="center", va="bottom", fontsize=6.5)
            for line in observed.found.harmonics:
                axis.axvline(line.frequency, color=COLOURS[3], linewidth=0.9, linestyle="--", label="machine's line")
            highest = max([*modes.frequencies, *compared.nominal]) * 1.15
            axis.set(ylim=(0, HEADROOM * top), xlim=(0, min(highest, rate / 2)))
            axis.set_ylabel(f"order\n{observed.name}")
        axes[-1].set_xlabel("frequency (Hz)")
        labelled = [pair for axis in axes for pair in zip(*reversed(axis.get_legend_handles_labels()), strict=True)]
        handles = dict(labelled)
        sheet.figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=4, frameon=False)
    return sheet
