"""The comparison of recordings as text: tables in Markdown."""

from collections.abc import Callable

import numpy as np
from scipy.stats import beta

from fe_models.arrays import FloatArray
from hybrid.identification.backbone import Backbone
from hybrid.identification.combinations import Combination, sums_of_stronger
from hybrid.identification.config import BACKBONE, COMPARISON
from hybrid.identification.recording_comparison import Compared, Observed
from hybrid.identification.structure_states import structure_states

LEAVE = "noise, what changes while the motion decays, and what moves the structure again"
MANY_SIGMA = 10.0  # from where on tenths of a standard deviation tell nothing
OFTEN = 0.04  # of cases, in which shapes agree by chance
PEAK = f"{COMPARISON.min_peak_ratio:g}"


def describe_compared(compared: Compared) -> str:
    """Return what is seen, as tables in Markdown."""
    parts: list[Callable[[Compared], list[str]]] = [_taken, _modes, _others, _sums, _suspects]
    parts += [_changes, _coordinates, _shapes]
    if any(not observed.found.is_ambient for observed in compared.recordings):
        parts += [_shares, _decays, _combinations]
    texts = ["\n".join(part(compared)) for part in parts]
    return "\n\n".join([structure_states(compared).sentence, *(text for text in texts if text)])


def _taken(compared: Compared) -> list[str]:
    """Return how each recording was taken, where any is no free decay."""
    if not compared.has_ambient:
        return []
    lines = ["How the recordings were taken (ambient: unknown forces; shapes have no scale then, and masses are open):"]
    for observed in compared.recordings:
        kind = "ambient" if observed.found.is_ambient else "free decay"
        lines.append(f"- {observed.name}: {kind}{', ' if observed.found.note else ''}{observed.found.note}")
        lines += [
            f"- {observed.name}: a machine's line at {line.frequency:.3f} Hz, no mode ({line.share:.1%} of the energy,"
            f" largest at {compared.sensors[observed.largest(line)]}: {line.amplitude[observed.largest(line)]:.3g})"
            for line in observed.found.harmonics
        ]
    return lines


def _modes(compared: Compared) -> list[str]:
    names = [observed.name for observed in compared.recordings]
    lines = [
        "Modes: frequency (Hz) of the nominal model and of each recording's mode of that shape, its deviation, damping",
        "ratio, MAC of the shapes at the sensors (+-: a standard deviation); -: no such mode among the strongest; too",
        f"short: the recording holds fewer than {COMPARISON.min_periods:g} periods of it",
        "",
        f"| mode | nominal | {' | '.join(names)} |",
        f"|---|---|{'---|' * len(names)}",
    ]
    told = by_chance(len(compared.sensors))
    if told:
        lines.insert(3, told)
    for mode, frequency in enumerate(compared.nominal):
        cells = [_cell(observed, mode, float(frequency)) for observed in compared.recordings]
        lines.append(f"| {mode + 1} | {frequency:.3f} | {' | '.join(cells)} |")
    return lines


def by_chance(sensors: int) -> str:
    """Return in a sentence how often shapes agree by chance at so many sensors, "" where that is rare."""
    if sensors == 1:
        return "One sensor has no shape: MAC and coordinate MAC are one there, whatever the mode."
    share = float(beta.sf(COMPARISON.min_mac, 0.5, (sensors - 1) / 2))
    if share < OFTEN:
        return ""
    return f"At {sensors} sensors unlike shapes have a MAC of {COMPARISON.min_mac:g} or more in {share:.0%} of cases."


def _others(compared: Compared) -> list[str]:
    """Return the strong modes whose shape is none of the nominal ones."""
    lines = ["Other modes (Hz, share of the recording's energy, where it moves most):"]
    for observed in compared.recordings:
        own = observed.identified
        others = [
            f"{own.frequencies[i]:.2f} ({own.energy[i]:.1%}, "
            f"{compared.sensors[int(np.argmax(np.abs(observed.shapes[:, i])))]})"
            for i in observed.shown
            if i not in observed.chosen and own.energy[i] >= COMPARISON.min_reported_energy_share
        ]
        lines.append(f"- {observed.name}: {'; '.join(others) or 'none'}")
    return lines


def _sums(compared: Compared) -> list[str]:
    """Return the modes at multiples, sums and differences of stronger ones."""
    lines = [
        "Modes at a multiple, sum or difference of stronger ones (Hz): a motion that is not linear shows there, too"
    ]
    for observed in compared.recordings:
        sums, frequencies = sums_of_stronger(observed.identified), observed.identified.frequencies
        told = [f"{frequencies[number]:.4g} ({sums[number]})" for number in observed.shown if number in sums]
        lines += [f"- {observed.name}: {'; '.join(told)}"] * bool(told)
    return lines if len(lines) > 1 else []


def _suspects(compared: Compared) -> list[str]:
    """Return what speaks against a sensor."""
    found = compared.suspects()
    return ["Sensors that do not go with the others:", *(f"- {line}" for line in found)] if found else []


def _changes(compared: Compared) -> list[str]:
    """Return what changed in each mode between recordings: between each two of a few, from the first of many."""
    every = len(compared.recordings) <= COMPARISON.max_pairs_of
    changes = [change for change in compared.changes if every or change.recordings[0] == 0]
    if not changes:
        return []
    lines = [
        "Changes of modes from one recording to another (+-: a standard deviation, and how many of them a change of",
        "frequency is; temperature and the size of the motion change frequencies by some tenths of a per cent, too)",
        "",
        "| from | to | mode | frequency | damping ratio | MAC |",
        "|---|---|---|---|---|---|",
    ]
    for change in changes:
        first, last = (compared.recordings[number] for number in change.recordings)
        if not change.modes:
            lines.append(f"| {first.name} | {last.name} | none is seen in both | - | - | - |")
        for mode in change.modes:
            own, digits = mode.numbers[0], 1 if abs(mode.sigma) < MANY_SIGMA else 0
            name = f"{first.chosen.index(own) + 1}" if own in first.chosen else "other"
            lines.append(
                f"| {first.name} | {last.name} | {name}, {first.identified.frequencies[own]:.3f} Hz"
                f" | {100 * mode.change:+.2f} +- {100 * mode.error:.1g} % ({abs(mode.sigma):.{digits}f})"
                f" | {100 * mode.ratio_change:+.2f} +- {100 * mode.ratio_error:.1g} % | {mode.mac:.3f} |"
            )
    return lines


def _coordinates(compared: Compared) -> list[str]:
    """Return the coordinate MAC of each sensor."""
    names = [observed.name for observed in compared.recordings]
    lines = [
        "Coordinate MAC of each sensor over all modes that are the model's (1: it moves as there; where it is low",
        "shapes differ, which need not be where the structure does)",
        "",
        f"| recording | {' | '.join(compared.sensors)} |",
        f"|---|{'---|' * len(compared.sensors)}",
    ]
    for name, observed in zip(names, compared.recordings, strict=True):
        lines.append(f"| {name} | {' | '.join(f'{value:.3f}' for value in compared.coordinate_mac(observed))} |")
    return lines


def _shares(compared: Compared) -> list[str]:
    names = [observed.name for observed in compared.recordings]
    lines = [f"Energy that all modes together leave of a recording: {LEAVE}"]
    lines += [f"- {observed.name}: {observed.identified.left:.1%}" for observed in compared.recordings]
    caption = "Share of energy that the modes of one recording (row) leave of another (column)"
    lines += ["", f"{caption}, windows of {compared.window:.3g} s", ""]
    lines += [f"| | {' | '.join(names)} |", f"|---|{'---|' * len(names)}"]
    for name, row in zip(names, compared.left, strict=True):
        lines.append(f"| {name} | {' | '.join('-' if np.isnan(share) else f'{share:.1%}' for share in row)} |")
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
        "| recording | mode, amplitude at | large | small | change of frequency |",
        "|---|---|---|---|---|",
    ]
    for observed in (each for each in compared.recordings if not each.found.is_ambient):
        for mode, curve in zip(compared.followed, observed.backbones, strict=True):
            ends = ["too short to tell, or too noisy", "-", "-"]
            if len(curve.frequency) > 1:
                change = curve.frequency[-1] / curve.frequency[0] - 1
                error = np.hypot(curve.deviation[0], curve.deviation[-1]) / curve.frequency[0]
                ends = [_end(curve, 0), _end(curve, -1), f"{100 * change:+.2f} +- {100 * error:.2f} %"]
            place = compared.sensors[observed.loudest(mode)]
            lines.append(f"| {observed.name} | {mode + 1}, {place} | {' | '.join(ends)} |")
    return lines


def _combinations(compared: Compared) -> list[str]:
    free = [each for each in compared.recordings if not each.found.is_ambient]
    a, b = compared.followed[0] + 1, compared.followed[-1] + 1
    which = f"Sums and differences of f{a} and f{b}" if a != b else f"Multiples of f{a}"
    words = [f"{_term(c.first, a)} {_term(c.second, b, more=True)}".strip() for c in free[0].combinations]
    lines = [
        f"{which}: power there over what is round it; a force that is not linear raises peaks there, {PEAK} and more",
        "",
        f"| recording | {' | '.join(words)} |",
        f"|---|{'---|' * len(words)}",
    ]
    for observed in free:
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
    modes, criterion = observed.identified, observed.criterion[mode, own]
    frequency = modes.frequencies[own]
    ratio = f"{100 * modes.ratios[own]:.2f} +- {100 * modes.ratio_errors[own]:.1g} %"
    told = f"{frequency:.3f} +- {modes.frequency_errors[own]:.1g} ({frequency / nominal - 1:+.1%})"
    return f"{told}, {ratio}, {criterion:.3f}"


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
