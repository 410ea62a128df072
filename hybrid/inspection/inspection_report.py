"""What was found in a recording file, in words, as JSON and as a picture."""

import warnings
from dataclasses import replace
from math import isfinite
from typing import Any

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.quiet_start import quiet_words
from hybrid.figures import COLOURS, PANEL_HEIGHT, PANEL_WIDTH, Sheet, figure
from hybrid.inspection.channel_facts import ChannelFacts, spectrum
from hybrid.inspection.inspection import Inspection
from hybrid.inspection.likely_excitation import Moved

MAX_PANELS = 12  # of a picture that one can read
MAX_DRAWN = 4000  # points a curve
FLOOR = 1e-12  # of a spectrum's largest value

ADVICE = {
    Moved.FREE: 'excitation = "free", or leave it out',
    Moved.DECAYS: "give each decay as a recording of its own",
    Moved.MEASURED: "name the force in loads",
    Moved.BASE: "name it in base",
    Moved.EARTHQUAKE: "if the ground's acceleration was measured, name it in base",
    Moved.AMBIENT: 'excitation = "ambient"',
    Moved.STEADY: "nothing is learned of damping from it; give a decay, or a recording without the machine",
    Moved.UNCLEAR: "look at the picture, and say what moved it in excitation",
}


def describe(found: Inspection) -> str:
    """Return the inspection for a terminal."""
    signals, rate = found.signals, found.signals.sampling_rate
    samples, channels = signals.values.shape
    lasts = f", {found.duration:.4g} s" if found.duration is not None else ""
    at_rate = f" at {rate:g} Hz ({signals.rate_from})" if rate else "; the file does not say its sampling rate"
    many = f" (the first of {signals.motions} motions)" if signals.motions > 1 else ""
    lines = [f"{signals.path.name}: {channels} channels of {samples} samples{at_rate}{lasts}{many}", ""]
    lines += [*_table(found), ""]
    for channel, fact in enumerate(found.facts):
        rests = channel in found.guess.channels  # a force does, most of the time
        lines += [f"  {fact.name}: {fault}" for fault in faults_of(replace(fact, stuck=0) if rests else fact, rate)]
    peaks = ", ".join(f"{peak:.4g}" for peak in found.common_peaks)
    lines += [
        f"  {name}: shows none of the peaks of the other channels ({peaks}{' Hz' * bool(rate)}): not connected, or"
        " where nothing moves"
        for name in found.apart
    ]
    if lines[-1]:
        lines.append("")
    lines += [f"Note: {note}." for note in signals.notes]
    which = ", ".join(signals.names[channel] for channel in found.guess.channels)
    driven = f" ({which})" if which else ""
    lines.append(f"It looks like {found.guess.moved.value}{driven}: {ADVICE[found.guess.moved]}.")
    if found.quiet:
        words = quiet_words(found.quiet / rate) if rate else quiet_words(found.quiet, "samples")
        lines.append(f"{words[0].upper()}{words[1:]}.")
    return "\n".join(lines)


def faults_of(fact: ChannelFacts, rate: float | None) -> list[str]:
    """Return what may be wrong with a channel, in words."""
    if fact.is_dead:
        return ["dead: it never changes" if isfinite(fact.mean) else "dead: it has no sample at all"]
    unit, faults = f" {fact.unit}" if fact.unit else "", []
    if fact.lost:
        gaps = f" in {fact.gaps} gaps, the longest of {_length(fact.longest_gap, rate)}" if fact.gaps > 1 else ""
        faults.append(f"{fact.lost} samples are lost{gaps}")
    if fact.clipped:
        ends = f"{fact.lowest:.4g} to {fact.highest:.4g}{unit}"
        faults.append(f"clipped: {fact.clipped} samples rest at an end of its range, {ends}")
    if fact.stuck:
        faults.append(f"stuck: it does not change for {_length(fact.stuck, rate)}")
    if fact.drift:
        faults.append(f"drifts: its mean moves by {fact.drift:.3g}{unit} from begin to end")
    return faults


def as_json(found: Inspection) -> dict[str, Any]:
    """Return the inspection for other programs; null stands for what is unknown."""
    signals = found.signals
    return {
        "schema": 1,
        "file": signals.path.name,
        "key": signals.key,
        "samples": len(signals.values),
        "motions": signals.motions,
        "sampling_rate": signals.sampling_rate,
        "duration": found.duration,
        "looks_like": found.guess.moved.name.lower(),
        "quiet_samples": found.quiet,
        "without_common_peaks": list(found.apart),
        "driving_channels": [signals.names[channel] for channel in found.guess.channels],
        "channels": [
            {name: _known(value) for name, value in vars(fact).items()} | {"dead": fact.is_dead} for fact in found.facts
        ],
        "notes": list(signals.notes),
    }


def draw(found: Inspection) -> Sheet:
    """Draw each channel over time and its spectrum beside it."""
    signals, rate = found.signals, found.signals.sampling_rate or 1.0
    words = ("time (s)", "frequency (Hz)") if signals.sampling_rate else ("sample", "cycles a sample")
    shown = found.facts[:MAX_PANELS]
    title = f"{signals.path.name}: {found.guess.moved.value}"
    with figure(2 * len(shown), 2, title, widths=(1.2 * PANEL_WIDTH, 0.8 * PANEL_WIDTH)) as (sheet, axes):
        sheet.figure.set_size_inches(2 * PANEL_WIDTH, PANEL_HEIGHT * len(shown) + 0.9)
        for number, fact in enumerate(shown):
            values = signals.values[:, number]
            course, power = axes[2 * number], axes[2 * number + 1]
            course.plot(*_drawn(values, rate), color=COLOURS[0], linewidth=0.5)
            course.set(ylabel=f"{fact.name} ({fact.unit})" if fact.unit else fact.name)
            frequencies, density = spectrum(values, signals.sampling_rate)
            largest = float(density.max(initial=0.0))
            if largest > 0:
                relative = np.maximum(density[1:] / largest, FLOOR)
                power.semilogy(frequencies[1:], relative, color="#555555", linewidth=0.8)
                for peak in fact.peaks:
                    power.axvline(peak, color=COLOURS[1], linewidth=0.8, linestyle=":")
            power.set(xlim=(0, rate / 2))
        axes[-2].set_xlabel(words[0])
        axes[-1].set_xlabel(words[1])
        axes[1].set_title("power, over its largest value", fontsize=9)
    return sheet


def _drawn(values: FloatArray, rate: float) -> tuple[FloatArray, FloatArray]:
    """Return times and values of a curve; of a long one the extremes of each short span, which no step would skip."""
    every = 2 * max(1, len(values) // MAX_DRAWN)
    if every <= 2:
        return np.arange(len(values)) / rate, values
    spans = values[: len(values) // every * every].reshape(-1, every)
    begin = np.arange(len(spans)) * every / rate
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of spans that are lost throughout, which stay blank
        extremes = np.stack([np.nanmin(spans, axis=1), np.nanmax(spans, axis=1)], axis=1)
    return np.repeat(begin, 2) + np.tile([0.0, every / (2 * rate)], len(begin)), extremes.ravel()


def _table(found: Inspection) -> list[str]:
    word = "peaks (Hz)" if found.signals.sampling_rate else "peaks (cycles a sample)"
    head = ("channel", "unit", "lowest", "highest", "mean", "std", word)
    rows = [
        (
            fact.name,
            fact.unit or "?",
            *(f"{value:.4g}" for value in (fact.lowest, fact.highest, fact.mean, fact.deviation)),
            ", ".join(f"{peak:.4g}" for peak in fact.peaks) or "-",
        )
        for fact in found.facts
    ]
    widths = [max(len(row[column]) for row in (head, *rows)) for column in range(len(head))]
    return [_aligned(row, widths) for row in (head, *rows)]


def _aligned(row: tuple[str, ...], widths: list[int]) -> str:
    """Return a line of a table, words to the left and numbers to the right."""
    cells = [
        cell.rjust(width) if 2 <= column < len(row) - 1 else cell.ljust(width)
        for column, (cell, width) in enumerate(zip(row, widths, strict=True))
    ]
    return ("  " + "  ".join(cells)).rstrip()


def _length(samples: int, rate: float | None) -> str:
    return f"{samples / rate:.3g} s" if rate else f"{samples} samples"


def _known(value: Any) -> Any:
    if isinstance(value, float):
        return value if isfinite(value) else None
    return list(value) if isinstance(value, tuple) else value
