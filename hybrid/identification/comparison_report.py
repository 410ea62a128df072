"""The comparison of recordings as text: tables in Markdown."""

import numpy as np

from fe_models.arrays import FloatArray
from hybrid.identification.agreement import largest_agreeing_group
from hybrid.identification.backbone import Backbone
from hybrid.identification.combinations import Combination
from hybrid.identification.config import AGREEMENT, BACKBONE, COMPARISON
from hybrid.identification.recording_comparison import Compared, Observed

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
