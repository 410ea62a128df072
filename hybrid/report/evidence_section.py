"""Why to believe it: measured against drawn against found, what was rejected, and what changed between recordings."""

from collections.abc import Iterator

import numpy as np

from fe_models.causes.wording import at_place, kind_words
from hybrid.diagnosis.answer import Answer
from hybrid.diagnosis.modal.config import LISTED
from hybrid.diagnosis.modal_report import draw_modes, scope_of
from hybrid.diagnosis.modes_and_motion.conclusion import ModalDiagnosis
from hybrid.diagnosis.modes_and_motion.modal_findings import State
from hybrid.diagnosis.modes_and_motion.paired_modes import PairedMode
from hybrid.diagnosis.observed.observations import Observations
from hybrid.diagnosis.outcome.conclusion import Diagnosis
from hybrid.diagnosis.outcome.findings import Finding
from hybrid.diagnosis.recorded.config import SPECTRA
from hybrid.report.comparison_figures import figures_of, response_figure
from hybrid.report.drawings import drawn
from hybrid.report.mode_shapes import mode_shapes
from hybrid.report.page import Block, Bullets, Cell, Heading, Paragraph, Section, Table
from hybrid.report.rejected import rejected
from hybrid.report.seen import Seen, extended_model, paired_modes_of
from hybrid.report.values import NOTHING, change, fixed, measured, number, off, sentence, share

MOST_ROWS = 40  # of a table of modes
NO_MODES = "No mode that a recording shows by itself could be paired with one of the structure."
OF_MODES = (
    "± is one standard deviation; in brackets how far the structure's frequency is off the measured one. MAC: how alike"
    " the shapes are at the sensors, 1 where they are the same."
)
ONE_STATE = {
    True: "All recordings are of one structure, as far as they tell.",
    False: "The recordings are not all alike.",
}


def why_believe_it(found: Answer, seen: Seen) -> Section:
    """Return what an answer rests on."""
    blocks: list[Block] = [Heading("Modes")]
    modes = paired_modes_of(found, seen)
    if modes:
        blocks.append(_modes(modes))
        if len(modes) <= MOST_ROWS:
            blocks.append(_drawn_modes(modes))
    else:
        blocks.append(Paragraph(NO_MODES))
    if isinstance(found, Diagnosis):
        blocks.append(_observed(found.observations))
    blocks += [Paragraph(note) for note in seen.notes]
    if seen.drawn is not None:
        blocks += figures_of(seen.drawn, seen.dataset, seen.extended)
    shapes = mode_shapes(seen.dataset, extended_model(found), seen.drawn)
    if shapes is not None:
        blocks += [Heading("Mode shapes"), shapes]
    if seen.responses is not None:
        blocks.append(response_figure(seen.responses))
    blocks += [Heading("What was rejected, and why"), *rejected(found)]
    blocks += [Heading("States of the structure"), *_states(found)]
    notes = (scope_of(found), *found.notes) if isinstance(found, ModalDiagnosis) else found.notes
    if notes:
        blocks += [Heading("Notes"), Bullets(tuple(sentence(note) for note in notes))]
    return Section("why", "Why believe it", tuple(blocks))


def _modes(modes: tuple[PairedMode, ...]) -> Table:
    rows = []
    for mode in modes[:MOST_ROWS]:
        known = mode.ratio_error < LISTED.any_ratio
        ratio = f"{measured(100 * mode.ratio, 100 * mode.ratio_error)} %" if known else NOTHING
        rows.append(
            (
                Cell(mode.recording),
                Cell(measured(mode.measured, mode.error), mode.measured),
                Cell(off(mode.drawn, mode.measured), mode.drawn),
                fixed(mode.mac_drawn, 3),
                Cell(off(mode.extended, mode.measured), mode.extended),
                fixed(mode.mac_extended, 3),
                Cell(ratio, mode.ratio if known else None),
            )
        )
    columns = ("recording", "measured (Hz)", "as drawn (Hz)", "MAC", "with what was found (Hz)", "MAC", "damping ratio")
    more = len(modes) - MOST_ROWS
    note = OF_MODES + (f" {more} further modes are in report.json." if more > 0 else "")
    caption = "Measured modes beside those of the structure as drawn and with what was found."
    return Table(caption, columns, tuple(rows), note)


def _drawn_modes(modes: tuple[PairedMode, ...]) -> Block:
    return drawn(
        draw_modes(modes),
        "modes",
        "How far natural frequencies are off, and the MAC, as drawn and with what was found.",
        "Bars for each measured mode: frequency error in per cent, and MAC, of both structures.",
    )


def _observed(shown: Observations) -> Table:
    """Return the modes of the linear model that follows the recordings best, beside the drawn ones."""
    rows = []
    count = min(len(own.frequencies) for own in (shown.nominal, shown.calibrated, shown.observed))
    for mode in range(count):
        seen = shown.motion_energy[mode] >= SPECTRA.min_energy_share
        observed = shown.observed
        rows.append(
            (
                Cell(str(mode + 1), mode),
                number(shown.nominal.frequencies[mode]),
                number(observed.frequencies[mode]) if seen else Cell(NOTHING),
                fixed(100 * shown.nominal.ratios[mode], 2),
                fixed(100 * observed.ratios[mode], 2) if seen else Cell(NOTHING),
                fixed(shown.mac[mode], 3),
                share(shown.motion_energy[mode]),
                share(shown.error_energy[mode]),
            )
        )
    columns = (
        "mode",
        "as drawn (Hz)",
        "observed (Hz)",
        "damping as drawn (%)",
        "damping observed (%)",
        "MAC",
        "of the motion",
        "of the error",
    )
    caption = "Modes of the linear model that follows all recordings best (observed), beside the drawn ones."
    note = (
        "Of the motion, of the error: each mode's share of the energy of the recordings, and of what the drawn"
        " structure leaves of them beyond noise. – : hardly seen."
    )
    return Table(caption, columns, tuple(rows), note)


def _states(found: Answer) -> Iterator[Block]:
    if isinstance(found, ModalDiagnosis):
        if len(found.states) > 1:
            yield _state_table(found.states)
        else:
            yield Paragraph(ONE_STATE[True])
        return
    if found.alike is None:
        yield Paragraph("Whether the recordings are of one structure was not told.")
        return
    yield Paragraph(ONE_STATE[found.alike])
    some = [own for own in found.findings if len(own.recordings) and not found.alike]
    if some:
        yield Bullets(tuple(_acting(own) for own in some))


def _acting(finding: Finding) -> str:
    names = ", ".join(dict.fromkeys(finding.recordings))
    return f"{kind_words(finding.cause.kind)} {at_place(finding.cause.location)}: in {names}"


def _state_table(states: tuple[State, ...]) -> Table:
    """Return the frequencies of each state, and how far they are from those of the first."""
    first, rows = states[0], []
    for frequency, error in zip(first.frequencies, first.errors, strict=True):
        cells = [Cell(measured(frequency, error), frequency)]
        for state in states[1:]:
            nearest = int(np.argmin(np.abs(np.log(np.array(state.frequencies) / frequency))))
            own = state.frequencies[nearest]
            told = f"{measured(own, state.errors[nearest])} ({change(own, frequency)})"
            cells.append(Cell(told, own / frequency))
        rows.append(tuple(cells))
    columns = tuple(f"{', '.join(state.recordings)} (Hz)" for state in states)
    caption = f"The recordings show {len(states)} states of the structure: the natural frequencies of each."
    return Table(caption, columns, tuple(rows), "In brackets: from the first state, beside its mode of that frequency.")
