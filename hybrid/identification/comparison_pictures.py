"""The comparison of recordings as pictures."""

from typing import Any

import numpy as np

from fe_models.arrays import TINY, FloatArray
from fe_models.recordings import Dataset, derivative_orders
from fe_models.spectra import line_frequencies, power_spectrum
from hybrid.figures import COLOURS, Sheet, figure
from hybrid.identification.channel_sizes import are_several, rms_of_each
from hybrid.identification.recording_comparison import Compared

MARKERS = "osD^vP"  # beside colours, for those who print in black
PANEL_WIDTH, PANEL_HEIGHT = 5.2, 1.45  # inches of a panel: spectra make large pictures
AVERAGES = 12  # parts of a recording over which the power of random motion is averaged
LEAST_WIDTH = 5.5  # inches: the title needs them


def draw_backbones(dataset: Dataset, compared: Compared) -> Sheet:
    """Draw frequency against amplitude, a panel a mode, with bars of two standard deviations to either side."""
    title = "Frequency while the motion decays\n(bars: two standard deviations of the fit)"
    free = [observed for observed in compared.recordings if not observed.found.is_ambient]
    panels = len(compared.followed)
    with figure(panels, panels, title) as (sheet, axes):
        sheet.figure.set_size_inches(max(4.5 * panels, LEAST_WIDTH), 4.0)
        for number, (axis, mode) in enumerate(zip(axes, compared.followed, strict=True)):
            for row, observed in enumerate(free):
                curve = observed.backbones[number]
                axis.errorbar(
                    curve.amplitude,
                    curve.frequency,
                    2 * curve.deviation,
                    fmt=MARKERS[row % len(MARKERS)] + "-",
                    label=observed.name,
                    color=COLOURS[row % len(COLOURS)],
                    markersize=4,
                    linewidth=1.0,
                    capsize=2.5,
                )
            axis.set_xscale("log")
            _part_ticks(axis)
            axis.set(
                xlabel=f"amplitude where it moves most ({_unit(dataset, compared, mode)})", ylabel="frequency (Hz)"
            )
            axis.set_title(f"mode {mode + 1}, nominal {compared.nominal[mode]:.3f} Hz", fontsize=9)
        count = len(free)
        sheet.figure.legend(
            *axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=count, frameon=False
        )
    return sheet


def _part_ticks(axis: Any) -> None:
    """Give a logarithmic axis that spans less than a power of ten a few plain numbers, which do not touch."""
    from matplotlib.ticker import MaxNLocator, NullLocator, ScalarFormatter

    low, high = axis.get_xlim()
    if high < 10 * low:
        axis.xaxis.set_major_locator(MaxNLocator(4))
        axis.xaxis.set_major_formatter(ScalarFormatter())
        axis.xaxis.set_minor_locator(NullLocator())


def _unit(dataset: Dataset, compared: Compared, mode: int) -> str:
    """Return the unit of a mode's amplitudes: that of the channel with the largest entry of the identified shape."""
    largest = {
        int(np.argmax(np.abs(each.identified.real_shapes[:, each.chosen[mode]]))) for each in compared.recordings
    }
    units = {dataset.sensors[sensor].unit for sensor in largest}
    return units.pop() if len(units) == 1 else "of each recording's own channel"


def draw_spectra(dataset: Dataset, compared: Compared) -> Sheet:
    """Draw the power of all channels of each recording, with the nominal frequencies and the combinations."""
    singles = [(recording, data) for recording in dataset.recordings for data in recording.data]
    which = "peaks at sums and differences" if len(compared.followed) > 1 else "peaks at multiples"
    orders = derivative_orders(dataset.sensors)
    with figure(len(singles), 1, "Power of all channels together, over its largest value") as (sheet, axes):
        sheet.figure.set_size_inches(PANEL_WIDTH, PANEL_HEIGHT * len(singles))
        for axis, (recording, data), observed in zip(axes, singles, compared.recordings, strict=True):
            rate = dataset.rate_of(recording)
            if are_several(orders):  # of several quantities the one with the largest numbers would be all
                data = data / np.maximum(rms_of_each(data, orders), TINY)
            frequencies, power = averaged_power(data, rate) if observed.found.is_ambient else _power(data, rate)
            axis.semilogy(frequencies, power, color="#555555", linewidth=0.8)
            for frequency in compared.nominal:
                axis.axvline(frequency, color=COLOURS[1], linewidth=0.8, linestyle=":", label="nominal modes")
            for combination in (each for each in observed.combinations if each.is_peak):
                place = (combination.found, 3 * combination.level)
                axis.plot(*place, "v", color=COLOURS[0], markersize=4, label=which)
            for line in observed.found.harmonics:
                axis.axvline(line.frequency, color=COLOURS[3], linewidth=0.8, linestyle="--", label="machine's line")
            axis.set(ylabel=observed.name, xlim=(0, min(dataset.lowpass or np.inf, rate / 2)))
            axis.set_ylim(max(1e-9, 0.3 * float(power[1:].min())) if observed.found.is_ambient else 1e-9, 3)
        axes[-1].set_xlabel("frequency (Hz)")
        labelled = [pair for axis in axes for pair in zip(*reversed(axis.get_legend_handles_labels()), strict=True)]
        handles = dict(labelled)
        sheet.figure.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=3, frameon=False)
    return sheet


def averaged_power(data: FloatArray, rate: float, parts: int = AVERAGES) -> tuple[FloatArray, FloatArray]:
    """Return frequencies (line,), Hz, and the power of all channels (line,), over its largest: Welch's averages over
    ``parts`` of the recording, and those between.
    """
    from scipy.signal import welch

    standard = data / np.where(data.std(axis=0) > 0, data.std(axis=0), 1.0)
    frequencies, power = welch(standard, rate, nperseg=max(len(data) // parts, min(len(data), 64)), axis=0)
    total = power.sum(axis=1)
    return np.asarray(frequencies), np.asarray(total / max(float(total[1:].max()), TINY))


def _power(data: FloatArray, rate: float) -> tuple[FloatArray, FloatArray]:
    power = power_spectrum(data - data.mean(axis=0)).sum(axis=1)
    return line_frequencies(len(data), rate), np.asarray(power / power.max())
