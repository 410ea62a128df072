"""The comparison of recordings as tables and pictures."""

from pathlib import Path

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.recordings import Dataset
from fe_models.spectra import line_frequencies, power_spectrum
from hybrid.figures import COLOURS, figure
from hybrid.identification.agreement import largest_agreeing_group
from hybrid.identification.backbone import Backbone
from hybrid.identification.combinations import Combination
from hybrid.identification.config import AGREEMENT, BACKBONE, COMPARISON
from hybrid.identification.recording_comparison import Compared, Observed

MARKERS = "osD^vP"  # beside colours, for those who print in black
PANEL_WIDTH, PANEL_HEIGHT = 5.2, 1.45  # inches of a panel: spectra make large pictures
LEAST_WIDTH = 5.5  # inches: the title needs them
PEAK = f"{COMPARISON.min_peak_ratio:g}"


def describe_compared(compared: Compared) -> str:
    """Return what is seen, as tables in Markdown."""
    parts = (_modes, _others, _shares, _shapes, _decays, _combinations)
    first = one_structure([observed.name for observed in compared.recordings], compared.left)
    return "\n\n".join([first, *("\n".join(part(compared)) for part in parts)])


def one_structure(names: list[str], left: FloatArray) -> str:
    """Say whether recordings of these ``names`` are of one structure.

    ``left`` (model, recording): the share of a recording's energy that the modes of each leave.
    """
    if len(names) < 2:
        return "There is one recording: whether several are of one structure cannot be asked."
    most = AGREEMENT.max_unexplained_share
    unclear = [name for name, own in zip(names, np.diag(left), strict=True) if own >= most]
    if unclear:
        found = f"the modes found in {', '.join(unclear)} leave more than {most:.0%} of its own energy"
        return f"Whether the recordings are of one structure cannot be told: {found}."
    group = largest_agreeing_group(left)
    if len(group) == len(names):
        worst = left[np.ix_(group, group)].max()
        return f"The recordings are of one structure: the modes of each leave at most {worst:.1%} of another's energy."
    agreeing, odd = [names[n] for n in group], [name for n, name in enumerate(names) if n not in group]
    known = f"{', '.join(agreeing)} agree, {', '.join(odd)} do not" if len(group) > 1 else "no two agree"
    return (
        f"The recordings are not all of one structure: {known} (the modes of one leave more than {most:.0%} of the"
        " other's energy)."
    )


def _modes(compared: Compared) -> list[str]:
    names = [observed.name for observed in compared.recordings]
    lines = [
        "Modes: frequency (Hz) of the nominal model and of each recording's mode of that shape, its deviation, damping",
        "ratio, MAC of the shapes at the sensors; -: no such mode among the strongest; too short: the recording holds",
        f"fewer than {COMPARISON.min_periods:g} periods of it",
        "",
        f"| mode | nominal | {' | '.join(names)} |",
        f"|---|---|{'---|' * len(names)}",
    ]
    for mode, frequency in enumerate(compared.nominal):
        cells = [_cell(observed, mode, float(frequency)) for observed in compared.recordings]
        lines.append(f"| {mode + 1} | {frequency:.3f} | {' | '.join(cells)} |")
    return lines


def _others(compared: Compared) -> list[str]:
    """Return the strong modes whose shape is none of the nominal ones."""
    lines = ["Other modes (Hz, share of the recording's energy, where it moves most):"]
    for observed in compared.recordings:
        own = observed.identified
        others = [
            f"{own.frequencies[i]:.2f} ({own.energy[i]:.1%}, "
            f"{compared.sensors[int(np.argmax(np.abs(own.shapes[:, i])))]})"
            for i in observed.shown
            if i not in observed.chosen and own.energy[i] >= COMPARISON.min_reported_energy_share
        ]
        lines.append(f"- {observed.name}: {'; '.join(others) or 'none'}")
    return lines


def _shares(compared: Compared) -> list[str]:
    names = [observed.name for observed in compared.recordings]
    lines = ["Energy that all modes together leave of a recording: noise, and what changes while the motion decays"]
    lines += [f"- {observed.name}: {observed.identified.left:.1%}" for observed in compared.recordings]
    caption = "Share of energy that the modes of one recording (row) leave of another (column)"
    lines += ["", f"{caption}, windows of {compared.window:.3g} s", ""]
    lines += [f"| | {' | '.join(names)} |", f"|---|{'---|' * len(names)}"]
    for name, row in zip(names, compared.left, strict=True):
        lines.append(f"| {name} | {' | '.join(f'{share:.1%}' for share in row)} |")
    return lines


def _shapes(compared: Compared) -> list[str]:
    lines = ["Shapes (of displacements) of the strongest modes at the sensors", ""]
    lines += [f"| mode | recording | {' | '.join(compared.sensors)} |", f"|---|---|{'---|' * len(compared.sensors)}"]
    for mode in compared.followed:
        rows = [("nominal", compared.shapes[:, mode])]
        rows += [(each.name, each.shapes[:, each.chosen[mode]]) for each in compared.recordings]
        for name, shape in rows:
            lines.append(f"| {mode + 1} | {name} | {' | '.join(f'{value:.2f}' for value in _upright(shape))} |")
    return lines


def _decays(compared: Compared) -> list[str]:
    lines = [
        "While the motion decays (first and last span of time: amplitude, Hz, damping ratio, +- a standard deviation;",
        f"spans whose frequency has a standard deviation of more than {BACKBONE.max_frequency_error:.1%} are left out)",
        "",
        "| recording | mode | large | small | change of frequency |",
        "|---|---|---|---|---|",
    ]
    for observed in compared.recordings:
        for mode, curve in zip(compared.followed, observed.backbones, strict=True):
            ends = ["too short to tell, or too noisy", "-", "-"]
            if len(curve.frequency) > 1:
                change = curve.frequency[-1] / curve.frequency[0] - 1
                error = np.hypot(curve.deviation[0], curve.deviation[-1]) / curve.frequency[0]
                ends = [_end(curve, 0), _end(curve, -1), f"{100 * change:+.2f} +- {100 * error:.2f} %"]
            lines.append(f"| {observed.name} | {mode + 1} | {' | '.join(ends)} |")
    return lines


def _combinations(compared: Compared) -> list[str]:
    a, b = compared.followed[0] + 1, compared.followed[-1] + 1
    which = f"Sums and differences of f{a} and f{b}" if a != b else f"Multiples of f{a}"
    words = [
        f"{_term(c.first, a)} {_term(c.second, b, more=True)}".strip() for c in compared.recordings[0].combinations
    ]
    lines = [
        f"{which}: power there over what is round it; a force that is not linear raises peaks there, {PEAK} and more",
        "",
        f"| recording | {' | '.join(words)} |",
        f"|---|{'---|' * len(words)}",
    ]
    for observed in compared.recordings:
        lines.append(f"| {observed.name} | {' | '.join(map(_combined, observed.combinations))} |")
    return lines


def _upright(shape: FloatArray) -> FloatArray:
    """Return a shape (sensor,) scaled to a largest entry of one; of two that are nearly as large the first counts."""
    size = np.abs(shape)
    first = int(np.flatnonzero(size >= COMPARISON.same_sign_share * size.max())[0])
    return np.asarray(shape / size.max() * np.sign(shape[first]))


def _cell(observed: Observed, mode: int, nominal: float) -> str:
    own = observed.chosen[mode]
    if own < 0:
        return "too short" if nominal * observed.lasts < COMPARISON.min_periods else "-"
    frequency = observed.identified.frequencies[own]
    ratio, criterion = observed.identified.ratios[own], observed.criterion[mode, own]
    return f"{frequency:.3f} ({frequency / nominal - 1:+.1%}), {ratio:.2%}, {criterion:.3f}"


def _end(curve: Backbone, place: int) -> str:
    frequency = f"{curve.frequency[place]:.3f} +- {curve.deviation[place]:.3f}"
    ratio = f"{100 * curve.ratio[place]:.2f} +- {100 * curve.ratio_deviation[place]:.2f} %"
    return f"{curve.amplitude[place]:.3g}, {frequency}, {ratio}"


def _combined(combination: Combination) -> str:
    expected = f"{combination.expected:.2f} Hz expected"
    if np.isnan(combination.found):
        return f"{expected}, above what the recording holds"
    if combination.natural >= 0:
        return f"{expected}, where mode {combination.natural + 1} has its own peak"
    return f"{expected}, {combination.found:.2f} found: {combination.over:.0f}"


def _term(factor: int, mode: int, more: bool = False) -> str:
    sign = "- " if factor < 0 else "+ " if more else ""
    size = "" if abs(factor) == 1 else f"{abs(factor)} "
    return f"{sign}{size}f{mode}" if factor else ""


def draw_backbones(path: Path, dataset: Dataset, compared: Compared) -> Path:
    """Draw frequency against amplitude, a panel a mode, with bars of two standard deviations to either side."""
    title = "Frequency while the motion decays\n(bars: two standard deviations of the fit)"
    panels = len(compared.followed)
    with figure(path, panels, panels, title) as (sheet, axes):
        sheet.set_size_inches(max(4.5 * panels, LEAST_WIDTH), 4.0)
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
            axis.set(
                xlabel=f"amplitude where it moves most ({_unit(dataset, compared, mode)})", ylabel="frequency (Hz)"
            )
            axis.set_title(f"mode {mode + 1}, nominal {compared.nominal[mode]:.3f} Hz", fontsize=9)
        count = len(compared.recordings)
        sheet.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=count, frameon=False)
    return path


def _unit(dataset: Dataset, compared: Compared, mode: int) -> str:
    """Return the unit of a mode's amplitudes: that of the channel with the largest entry of the identified shape."""
    largest = {
        int(np.argmax(np.abs(each.identified.real_shapes[:, each.chosen[mode]]))) for each in compared.recordings
    }
    units = {dataset.sensors[sensor].unit for sensor in largest}
    return units.pop() if len(units) == 1 else "of each recording's own channel"


def draw_spectra(path: Path, dataset: Dataset, compared: Compared) -> Path:
    """Draw the power of all channels of each recording, with the nominal frequencies and the combinations."""
    singles = [data for recording in dataset.recordings for data in recording.data]
    highest = min(dataset.lowpass or np.inf, dataset.sampling_rate / 2)
    which = "peaks at sums and differences" if len(compared.followed) > 1 else "peaks at multiples"
    with figure(path, len(singles), 1, "Power of all channels together, over its largest value") as (sheet, axes):
        sheet.set_size_inches(PANEL_WIDTH, PANEL_HEIGHT * len(singles))
        for axis, data, observed in zip(axes, singles, compared.recordings, strict=True):
            frequencies, power = _power(data, dataset.sampling_rate)
            axis.semilogy(frequencies, power, color="#555555", linewidth=0.8)
            for frequency in compared.nominal:
                axis.axvline(frequency, color=COLOURS[1], linewidth=0.8, linestyle=":", label="nominal modes")
            for combination in (each for each in observed.combinations if each.is_peak):
                place = (combination.found, 3 * combination.level)
                axis.plot(*place, "v", color=COLOURS[0], markersize=4, label=which)
            axis.set(ylabel=observed.name, xlim=(0, highest), ylim=(1e-9, 3))
        axes[-1].set_xlabel("frequency (Hz)")
        labelled = [pair for axis in axes for pair in zip(*reversed(axis.get_legend_handles_labels()), strict=True)]
        handles = dict(labelled)
        sheet.legend(handles.values(), handles.keys(), loc="outside lower center", ncols=2, frameon=False)
    return path


def _power(data: FloatArray, rate: float) -> tuple[FloatArray, FloatArray]:
    power = power_spectrum(data).sum(axis=1)
    return line_frequencies(len(data), rate), np.asarray(power / power.max())
