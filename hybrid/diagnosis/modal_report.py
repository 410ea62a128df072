"""The report of a diagnosis by modes: as JSON in the contract's words, in lines for an engineer, as a picture."""

from typing import Any

import numpy as np

from fe_models.causes.force_law import ForceLaw
from hybrid.diagnosis.learned.gain import Gain
from hybrid.diagnosis.modal.config import LISTED
from hybrid.diagnosis.modes_and_motion.conclusion import ModalDiagnosis
from hybrid.diagnosis.modes_and_motion.paired_modes import PairedMode
from hybrid.diagnosis.outcome.extend_matrices import ExtendedMatrices
from hybrid.diagnosis.outcome.findings import Finding
from hybrid.diagnosis.outcome.verdict import Verdict
from hybrid.diagnosis.report import (
    ERROR_ENERGY,
    calibration_table,
    explained_in_words,
    finding_lines,
    finding_table,
    hybrid_lines,
    left_lines,
    next_lines,
    next_table,
    score_lines,
    with_gain,
)
from hybrid.figures import Sheet, figure

HEADLINES = {
    Verdict.NOTHING_WRONG: "Nothing is wrong that modes would show: the structure is as drawn, within its uncertainty.",
    Verdict.EXPLAINED: "The simulation is wrong, and what is named below explains the measured modes.",
    Verdict.PARTLY_EXPLAINED: "The simulation is wrong; what is named below explains the measured modes in part.",
    Verdict.UNEXPLAINED: "The simulation is wrong, and nothing on the list of causes explains the measured modes.",
}
VALUES_OFF = (
    "The simulation is wrong: its stiffnesses or masses are off by more than was stated, and these modes do not tell"
    " which ones, or which cause they stand for."
)
BY_MODES = "by modes alone: force laws, drifts and harmonic forces, which modes do not show, were not looked for"
BY_LISTED_MODES = f"{BY_MODES}, and no forecasts were made"
BY_MODES_AND_MOTION = "by modes and motion: drifts and harmonic forces were not looked for"
MISFIT = "the modes' misfit (chi-square)"
DISCREPANCY_ENERGY = "the energy of the motion's discrepancy"  # from that of a structure with constant values
GAIN = (
    "In the recordings where it acts, it removes {gain:.0%} of the forecast error's energy beyond noise (each is"
    " forecast from its first fifth, by a model that was fitted to the others)"
)
MIN_SAID_GAIN = 0.005  # which is 0 % in words
NO_GAIN = (
    "Forecasts of the recordings where it acts are no better for it (each is forecast from its first fifth, by a model"
    " that was fitted to the others): what tells it are their modes"
)
DRAWN_COLOUR, EXTENDED_COLOUR = "#E69F00", "#0072B2"  # Okabe & Ito, as in the other pictures


def modal_table(found: ModalDiagnosis, gain: Gain | None = None) -> dict[str, Any]:
    """Return the report as plain data, ready for JSON; ``gain``: what was learned on top, where it was."""
    return with_gain(_table(found), gain)


def _table(found: ModalDiagnosis) -> dict[str, Any]:
    return {
        "schema": 1,
        "verdict": found.verdict.value,
        "headline": headline(found),
        "findings": [finding_table(finding) for finding in found.findings],
        "calibration": calibration_table(found.calibration),
        "unexplained_fraction": found.unexplained,
        "scores": found.scores,
        "noise_floor": found.noise_floor,
        "seconds": round(found.seconds, 2),
        "states": [
            {
                "recordings": list(state.recordings),
                "frequencies": list(state.frequencies),
                "frequency_std": list(state.errors),
                "damping_ratios": list(state.ratios),
            }
            for state in found.states
        ],
        "modes": [vars(mode) for mode in found.modes],
        **next_table(found.next_measurement),
        "notes": [scope_of(found), *found.notes],
    }


def headline(found: ModalDiagnosis) -> str:
    """Return the answer in one sentence."""
    return VALUES_OFF if found.values_off else HEADLINES[found.verdict]


def describe_modal(found: ModalDiagnosis, gain: Gain | None = None) -> str:
    """Return the report in lines: modes, then the `modal_summary`."""
    lines = ["| recording | measured (Hz) | drawn | MAC | with what was found | MAC | damping ratio |"]
    lines.append("|---|---|---|---|---|---|---|")
    lines += [_row(mode) for mode in found.modes]
    return "\n".join([*lines, "", modal_summary(found, gain)])


def modal_summary(found: ModalDiagnosis, gain: Gain | None = None) -> str:
    """Return the answer in lines: what is named with its rivals, states, forecasts, notes."""
    lines = [headline(found)]
    for finding in found.findings:
        lines += finding_lines(finding, _explained(finding), *_gained(finding))
    lines += next_lines(found.next_measurement)
    if len(found.states) > 1:
        lines.append(f"The recordings show {len(found.states)} states of the structure:")
        lines += [f"- {', '.join(state.recordings)}" for state in found.states]
    lines += left_lines(found.unexplained, measure_of_left(found))
    if found.forecasts is not None:
        lines += score_lines(found.scores, found.forecasts.floor, found.forecasts.tolerance, bool(found.findings))
    if gain is not None:
        lines += hybrid_lines(gain)
    notes = (scope_of(found), *found.notes, *(gain.notes if gain else ()))
    return "\n".join([*lines, *(f"Note: {note}." for note in notes)])


def _explained(finding: Finding) -> str:
    measure = DISCREPANCY_ENERGY if isinstance(finding.cause, ForceLaw) else MISFIT
    return explained_in_words(finding.explains, measure) if finding.explains else ""


def _gained(finding: Finding) -> list[str]:
    """Return what a change takes away where it acts, by forecasts of each recording that the others do not fit."""
    if finding.gain is None:
        return []
    return [GAIN.format(gain=finding.gain) if finding.gain > MIN_SAID_GAIN else NO_GAIN]


def measure_of_left(found: ModalDiagnosis) -> str:
    """Return of what a share is left: where forecasts reach the noise, they tell better what is than modes do."""
    by_forecasts = found.forecasts is not None and found.unexplained == found.forecasts.unexplained
    return ERROR_ENERGY if by_forecasts else MISFIT


def scope_of(found: ModalDiagnosis) -> str:
    """Return what was not looked for."""
    if not found.has_motion:
        return BY_LISTED_MODES
    return BY_MODES if isinstance(found.extended, ExtendedMatrices) else BY_MODES_AND_MOTION


def _row(mode: PairedMode) -> str:
    cells = [
        mode.recording,
        f"{mode.measured:.4g} +- {mode.error:.1g}",
        *_beside(mode.drawn, mode.mac_drawn, mode.measured),
        *_beside(mode.extended, mode.mac_extended, mode.measured),
        f"{mode.ratio:.2%} +- {mode.ratio_error:.2%}" if mode.ratio_error < LISTED.any_ratio else "-",
    ]
    return f"| {' | '.join(cells)} |"


def _beside(frequency: float | None, criterion: float | None, measured: float) -> tuple[str, str]:
    if frequency is None:
        return "-", "-"
    return f"{frequency:.4g} ({frequency / measured - 1:+.1%})", "-" if criterion is None else f"{criterion:.3f}"


def draw_modes(modes: tuple[PairedMode, ...]) -> Sheet:
    """Draw how far natural frequencies and shapes are off, as drawn and with what was found."""
    title = "Modes of the structure beside the measured ones"
    with figure(2, 1, title) as (sheet, (above, below)):
        sheet.figure.set_size_inches(max(6.2, 0.3 * len(modes) + 2.0), 5.2)
        place = np.arange(len(modes))
        sides = (("as drawn", DRAWN_COLOUR, -0.2), ("with what was found", EXTENDED_COLOUR, 0.2))
        for (label, colour, shift), before in zip(sides, (True, False), strict=True):
            known = [(mode.drawn, mode.mac_drawn) if before else (mode.extended, mode.mac_extended) for mode in modes]
            off = [
                np.nan if f is None else 100 * (f / mode.measured - 1)
                for (f, _), mode in zip(known, modes, strict=True)
            ]
            criterion = [np.nan if c is None else c for _, c in known]
            above.bar(place + shift, off, 0.38, color=colour, label=label)
            below.bar(place + shift, criterion, 0.38, color=colour)
        above.axhline(0.0, color="black", linewidth=0.8)
        above.set_ylabel("frequency off (%)")
        above.set_xticks([])
        names = above.get_legend_handles_labels()
        sheet.figure.legend(*names, loc="outside lower center", ncols=2, frameon=False, fontsize=8)
        below.set(ylabel="MAC", ylim=(0, 1.02))
        below.set_xticks(
            place, [f"{mode.recording}\n{mode.measured:.4g} Hz" for mode in modes], rotation=90, fontsize=7
        )
    return sheet
