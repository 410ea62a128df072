"""The comparison of recordings as tables and pictures."""

from pathlib import Path

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.recordings import Dataset
from fe_models.spectra import line_frequencies, power_spectrum
from hybrid.figures import figure
from hybrid.identification.backbone import Backbone
from hybrid.identification.combinations import Combination
from hybrid.identification.config import COMPARISON
from hybrid.identification.recording_comparison import Compared, Observed

# of Okabe & Ito: distinguished by everyone
COLOURS = ("#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00")
MARKERS = "osD^vP"  # beside colours, for those who print in black
PANEL_WIDTH, PANEL_HEIGHT = 5.2, 1.45  # inches of a panel: spectra make large pictures


def describe_compared(compared: Compared) -> str:
    """Return what is seen, as tables in Markdown."""
    names = [observed.name for observed in compared.recordings]
    lines = [
        "Modes: frequency (Hz) of the nominal model and of each recording's strongest mode of that shape, its",
        "deviation, damping ratio, MAC of the shapes at the sensors; -: no such mode among the strongest",
        "",
        f"| mode | nominal | {' | '.join(names)} |",
        f"|---|---|{'---|' * len(names)}",
    ]
    for mode, frequency in enumerate(compared.nominal):
        cells = [_cell(observed, mode, float(frequency)) for observed in compared.recordings]
        lines.append(f"| {mode + 1} | {frequency:.3f} | {' | '.join(cells)} |")
    lines += ["", "Other modes (Hz, share of the recording's energy, where it moves most):"]
    for observed in compared.recordings:
        lines.append(f"- {observed.name}: {'; '.join(_others(observed, compared.sensors)) or 'none'}")
    lines += [
        "",
        "Energy that all modes together leave of a recording: noise, and what changes while the motion decays",
    ]
    lines += [f"- {observed.name}: {observed.identified.left:.1%}" for observed in compared.recordings]
    caption = "Share of energy that the modes of one recording (row) leave of another (column)"
    lines += ["", f"{caption}, windows of {compared.window:.3g} s", ""]
    lines += [f"| | {' | '.join(names)} |", f"|---|{'---|' * len(names)}"]
    for name, row in zip(names, compared.left, strict=True):
        lines.append(f"| {name} | {' | '.join(f'{share:.1%}' for share in row)} |")
    lines += ["", "Shapes of the strongest modes at the sensors", ""]
    lines += [f"| mode | recording | {' | '.join(compared.sensors)} |", f"|---|---|{'---|' * len(compared.sensors)}"]
    for mode in compared.followed:
        rows = [("nominal", compared.shapes[:, mode])]
        rows += [(each.name, each.identified.shapes[:, each.chosen[mode]]) for each in compared.recordings]
        for name, shape in rows:
            lines.append(f"| {mode + 1} | {name} | {' | '.join(f'{value:.2f}' for value in _upright(shape))} |")
    lines += ["", "While the motion decays (first and last span of time: amplitude, Hz, damping ratio)", ""]
    lines += ["| recording | mode | large | small | change of frequency |", "|---|---|---|---|---|"]
    for observed in compared.recordings:
        for mode, curve in zip(compared.followed, observed.backbones, strict=True):
            ends = ["too short to tell", "-", "-"]
            if len(curve.frequency):
                change = curve.frequency[-1] / curve.frequency[0] - 1
                ends = [_end(curve, 0), _end(curve, -1), f"{change:+.2%}"]
            lines.append(f"| {observed.name} | {mode + 1} | {' | '.join(ends)} |")
    a, b = compared.followed[0] + 1, compared.followed[-1] + 1
    which = f"Sums and differences of f{a} and f{b}" if a != b else f"Multiples of f{a}"
    lines += ["", f"{which}: power there over what is round it", ""]
    words = [
        f"{_term(c.first, a)} {_term(c.second, b, more=True)}".strip() for c in compared.recordings[0].combinations
    ]
    lines += [f"| recording | {' | '.join(words)} |", f"|---|{'---|' * len(words)}"]
    for observed in compared.recordings:
        lines.append(f"| {observed.name} | {' | '.join(map(_combined, observed.combinations))} |")
    return "\n".join(lines)


def _upright(shape: FloatArray) -> FloatArray:
    """Return a shape (sensor,) scaled to a largest entry of one; of two that are nearly as large the first counts."""
    size = np.abs(shape)
    first = int(np.flatnonzero(size >= COMPARISON.same_sign_share * size.max())[0])
    return np.asarray(shape / size.max() * np.sign(shape[first]))


def _cell(observed: Observed, mode: int, nominal: float) -> str:
    own = observed.chosen[mode]
    if own < 0:
        return "-"
    frequency = observed.identified.frequencies[own]
    ratio, criterion = observed.identified.ratios[own], observed.criterion[mode, own]
    return f"{frequency:.3f} ({frequency / nominal - 1:+.1%}), {ratio:.2%}, {criterion:.3f}"


def _others(observed: Observed, sensors: tuple[str, ...]) -> list[str]:
    """Return the strong modes whose shape is none of the nominal ones."""
    taken = set(observed.chosen)
    return [
        f"{observed.identified.frequencies[i]:.2f} ({observed.identified.energy[i]:.1%}, "
        f"{sensors[int(np.argmax(np.abs(observed.identified.shapes[:, i])))]})"
        for i in range(len(observed.identified.energy))
        if i not in taken and observed.identified.energy[i] >= COMPARISON.min_reported_energy_share
    ]


def _end(curve: Backbone, place: int) -> str:
    return f"{curve.amplitude[place]:.3g}, {curve.frequency[place]:.3f}, {curve.ratio[place]:.2%}"


def _combined(combination: Combination) -> str:
    expected = f"{combination.expected:.2f} Hz expected"
    if np.isnan(combination.found):
        return f"{expected}, above what the recording holds"
    return f"{expected}, {combination.found:.2f} found: {combination.over:.0f}"


def _term(factor: int, mode: int, more: bool = False) -> str:
    sign = "- " if factor < 0 else "+ " if more else ""
    size = "" if abs(factor) == 1 else f"{abs(factor)} "
    return f"{sign}{size}f{mode}" if factor else ""


def draw_backbones(path: Path, compared: Compared) -> Path:
    """Draw frequency against amplitude, a panel a mode, with bars of two standard deviations to either side."""
    title = "Frequency while the motion decays (bars: two standard deviations of the fit)"
    panels = len(compared.followed)
    with figure(path, panels, panels, title) as (sheet, axes):
        sheet.set_size_inches(4.5 * panels, 3.8)
        for number, (axis, mode) in enumerate(zip(axes, compared.followed, strict=True)):
            for row, observed in enumerate(compared.recordings):
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
            axis.set(xlabel="amplitude (as recorded)", ylabel="frequency (Hz)")
            axis.set_title(f"mode {mode + 1}, nominal {compared.nominal[mode]:.3f} Hz", fontsize=9)
        count = len(compared.recordings)
        sheet.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=count, frameon=False)
    return path


def draw_spectra(path: Path, dataset: Dataset, compared: Compared) -> Path:
    """Draw the power of all channels of each recording, with the nominal frequencies and the combinations."""
    singles = [data for recording in dataset.recordings for data in recording.data]
    highest = min(dataset.lowpass or np.inf, dataset.sampling_rate / 2)
    with figure(path, len(singles), 1, "Power of all channels together, over its largest value") as (sheet, axes):
        sheet.set_size_inches(PANEL_WIDTH, PANEL_HEIGHT * len(singles))
        for axis, data, observed in zip(axes, singles, compared.recordings, strict=True):
            frequencies, power = _power(data, dataset.sampling_rate)
            axis.semilogy(frequencies, power, color="#555555", linewidth=0.8)
            for frequency in compared.nominal:
                axis.axvline(frequency, color=COLOURS[1], linewidth=0.8, linestyle=":", label="nominal modes")
            for combination in observed.combinations:
                place = (combination.found, 3 * combination.level)
                axis.plot(*place, "v", color=COLOURS[0], markersize=4, label="sums and differences")
            axis.set(ylabel=observed.name, xlim=(0, highest), ylim=(1e-9, 3))
        axes[-1].set_xlabel("frequency (Hz)")
        handles = dict(zip(*reversed(axes[0].get_legend_handles_labels()), strict=True))
        sheet.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=2, frameon=False)
    return path


def _power(data: FloatArray, rate: float) -> tuple[FloatArray, FloatArray]:
    power = power_spectrum(data).sum(axis=1)
    return line_frequencies(len(data), rate), np.asarray(power / power.max())
