"""The page of a comparison of recordings: whether they are of one structure, its modes, and what changed."""

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from fe_models.linear import LinearModel
from fe_models.pictures.structure_drawing import structure_picture
from fe_models.recordings import Dataset
from hybrid.figures import NO_SHEETS, Sheets
from hybrid.identification.comparison_report import LEAVE, by_chance
from hybrid.identification.config import COMPARISON
from hybrid.identification.dataset_comparison import DatasetComparison
from hybrid.identification.frequency_response import FrequencyResponse
from hybrid.identification.recording_comparison import Compared, Observed
from hybrid.identification.structure_states import Outcome, structure_states
from hybrid.report.assumed_section import what_was_assumed
from hybrid.report.comparison_figures import figures_of, response_figure
from hybrid.report.drawings import pictured
from hybrid.report.mode_shapes import mode_shapes
from hybrid.report.page import Block, Bullets, Cell, Heading, Page, Paragraph, Section, Table, Tone
from hybrid.report.provenance import Provenance, provenance_of, written_by
from hybrid.report.values import NOTHING, fixed, measured, off, percentage, share
from hybrid.report.where import WIDTHS

SEED = "none are used"
FAR = 0.02  # of a frequency: beyond it a model is worth a diagnosis
NEXT = (
    "Where modes are farther off the model than it may be, run hybrid-modal diagnose on the same dataset: it names the"
    " cause."
)
AGREES = "The model's frequencies are as near as a model's usually are; a diagnosis (hybrid-modal diagnose) says more."
BEYOND_CHANCE = (
    "Frequencies of their modes differ beyond chance, as temperature and the size of the motion make them differ."
)
WITHIN_CHANCE = "The frequencies of their modes agree within chance."
TONES = {Outcome.ONE: Tone.GOOD, Outcome.SEVERAL: Tone.FOUND, Outcome.OPEN: Tone.OPEN}
CHANGED = "Look for what was done to the structure between recordings of different states."
RESPONSES_ALONE = "Known forces drove all recordings: held against the model are its frequency response functions."


def comparison_page(found: DatasetComparison, provenance: Provenance, sheets: Sheets = NO_SHEETS) -> Page:
    """Return the page of a comparison; ``sheets``: those that are drawn already."""
    dataset, compared, responses = found.dataset, found.compared, found.responses
    name = "imported matrices" if isinstance(dataset.model, LinearModel) else dataset.model.name
    sentence, tone = _answer(compared)
    sections = (
        _where(dataset, compared),
        Section("why", "Why believe it", tuple(_evidence(found, sheets))),
        Section("unknown", "What is not known", tuple(_unknown(compared))),
        what_was_assumed(dataset, provenance),
    )
    return Page(
        title=f"Comparison of recordings with {name}",
        verdict="What the recordings show by themselves",
        tone=tone,
        sentence=sentence,
        summary=_summary(compared),
        facts=tuple(_facts(compared, responses)),
        next=tuple(_next(compared)),
        sections=sections,
        footer=written_by(provenance),
    )


def page_from_files(found: DatasetComparison, command: Sequence[str], file: Path, sheets: Sheets) -> Page:
    """Return the page of a comparison of the dataset of a ``file``, by the words of a ``command``.

    ``sheets``: what `save_comparison` drew.
    """
    return comparison_page(found, provenance_of(command, file, SEED, found.seconds), sheets)


def _answer(compared: Compared | None) -> tuple[str, Tone]:
    """Return whether the recordings are of one structure, in a sentence, and how good that is."""
    if compared is None:
        return RESPONSES_ALONE, Tone.GOOD
    told = structure_states(compared)
    return told.sentence, TONES[told.outcome]


def _summary(compared: Compared | None) -> str:
    """Return how frequencies of free decays differ, of which the sentence does not speak."""
    if compared is None or compared.has_ambient or len(compared.recordings) < 2:
        return ""
    return BEYOND_CHANCE if any(own.is_plain for own in compared.changes) else WITHIN_CHANCE


def _farthest(compared: Compared) -> float:
    """Return the largest relative difference of a measured frequency from the model's."""
    return max(
        (
            abs(float(own.identified.frequencies[k] / compared.nominal[mode] - 1))
            for own in compared.recordings
            for mode, k in compared.pairs(own)
        ),
        default=0.0,
    )


def _facts(compared: Compared | None, responses: FrequencyResponse | None) -> Iterator[tuple[str, str]]:
    if compared is not None:
        yield "recordings", str(len(compared.recordings))
        yield "modes of the model that are seen", str(sum(_is_seen(compared, n) for n in range(len(compared.nominal))))
        yield "frequencies are off by up to", f"{100 * _farthest(compared):.2g} %"
    if responses is not None:
        yield "coherence (median)", f"{np.median(responses.coherence):.3f}"


def _next(compared: Compared | None) -> Iterator[str]:
    if compared is not None and structure_states(compared).outcome is Outcome.SEVERAL:
        yield CHANGED
    yield NEXT if compared is None or _farthest(compared) > FAR else AGREES


def _where(dataset: Dataset, compared: Compared | None) -> Section:
    names = ", ".join(sensor.name for sensor in dataset.sensors)
    drawing = pictured(
        structure_picture(dataset.model, dataset.sensors, WIDTHS),
        "The structure with the numbers of nodes and elements; arrows are sensors, along what they measure.",
        f"Drawing of the structure with sensors {names}.",
    )
    blocks: list[Block] = [drawing]
    if compared is not None and compared.has_ambient:
        blocks.append(Bullets(tuple(_taken(own, compared) for own in compared.recordings)))
    return Section("where", "Where", tuple(blocks))


def _taken(own: Observed, compared: Compared) -> str:
    """Return how a recording was taken, with the lines of machines in it."""
    kind = "unknown forces" if own.found.is_ambient else "free decay"
    lines = [
        f"a machine's line at {line.frequency:.3f} Hz, no mode, largest at {compared.sensors[own.largest(line)]}"
        for line in own.found.harmonics
    ]
    note = [own.found.note] if own.found.note else []
    return f"{own.name}: {'; '.join([kind, *note, *lines])}."


def _evidence(found: DatasetComparison, sheets: Sheets) -> Iterator[Block]:
    compared, responses = found.compared, found.responses
    if compared is not None and found.free is not None:
        yield Heading("Modes")
        yield _modes(compared)
        shapes = mode_shapes(found.free, None, compared)
        if shapes is not None:
            yield shapes
        if compared.changes:
            yield Heading("What changed between recordings")
            yield _changes(compared)
        if np.isfinite(compared.left).any() and len(compared.recordings) > 1:
            yield _left(compared)
        yield Heading("Figures")
        yield from figures_of(compared, found.free, sheets=sheets)
    if responses is not None:
        yield Heading("Frequency response functions")
        yield response_figure(responses, sheets)


def _modes(compared: Compared) -> Table:
    rows = []
    for own in compared.recordings:
        modes = own.identified
        for k in own.shown:
            mode = own.chosen.index(k) if k in own.chosen else None
            nominal = None if mode is None else float(compared.nominal[mode])
            frequency = float(modes.frequencies[k])
            rows.append(
                (
                    Cell(own.name),
                    Cell("none of the model's") if mode is None else Cell(str(mode + 1), mode),
                    Cell(measured(frequency, float(modes.frequency_errors[k])), frequency),
                    Cell(off(nominal, frequency), nominal),
                    Cell(NOTHING) if mode is None else fixed(float(own.criterion[mode, k]), 3),
                    Cell(
                        f"{measured(100 * float(modes.ratios[k]), 100 * float(modes.ratio_errors[k]))} %",
                        float(modes.ratios[k]),
                    ),
                    share(float(modes.energy[k])),
                )
            )
    columns = ("recording", "mode", "measured (Hz)", "model (Hz)", "MAC", "damping ratio", "of the energy")
    note = "± is one standard deviation; in brackets how far the model's frequency is off the measured one."
    return Table("Modes of each recording beside the model's.", columns, tuple(rows), note)


def _changes(compared: Compared) -> Table:
    rows = []
    every = len(compared.recordings) <= COMPARISON.max_pairs_of
    for own in compared.changes:
        if not every and own.recordings[0] != 0:
            continue
        first, last = (compared.recordings[number] for number in own.recordings)
        if not own.modes:
            names = Cell(f"{first.name} to {last.name}")
            rows.append((names, *[Cell(NOTHING)] * 5, Cell("open: no mode in both")))
        for mode in own.modes:
            frequency = float(first.identified.frequencies[mode.numbers[0]])
            rows.append(
                (
                    Cell(f"{first.name} to {last.name}"),
                    Cell(f"{frequency:.4g}", frequency),
                    Cell(f"{measured(100 * mode.change, 100 * mode.error)} %", mode.change),
                    Cell(f"{abs(mode.sigma):.1f}", abs(mode.sigma)),
                    Cell(f"{measured(100 * mode.ratio_change, 100 * mode.ratio_error)} %", mode.ratio_change),
                    fixed(mode.mac, 3),
                    Cell("beyond chance" if own.is_plain else "within chance"),
                )
            )
    columns = ("recordings", "mode at (Hz)", "frequency", "standard deviations", "damping ratio", "MAC", "change is")
    note = (
        "Standard deviations: how many of its own the change of a frequency is. Temperature and the size of the motion"
        " change frequencies by some tenths of a per cent, too."
    )
    return Table("Changes of modes from one recording to another.", columns, tuple(rows), note)


def _left(compared: Compared) -> Table:
    names = [own.name for own in compared.recordings]
    rows = tuple((Cell(name), *map(share, row)) for name, row in zip(names, compared.left.tolist(), strict=True))
    caption = "Energy of each recording (column) that the modes of another (row) leave."
    return Table(caption, ("modes of", *names), rows)


def _unknown(compared: Compared | None) -> Iterator[Block]:
    if compared is None:
        yield Paragraph("Modes were not identified: known forces drove all recordings.")
        return
    missing = [str(mode + 1) for mode in range(len(compared.nominal)) if not _is_seen(compared, mode)]
    if missing:
        yield Paragraph(f"Seen in no recording: mode{'s' * (len(missing) > 1)} {', '.join(missing)} of the model.")
    told = by_chance(len(compared.sensors))
    if told:
        yield Paragraph(told)
    suspects = compared.suspects()
    if suspects:
        yield Paragraph("Sensors that do not go with the others:")
        yield Bullets(tuple(suspects))
    free = [own for own in compared.recordings if not own.found.is_ambient]
    if free:
        left = (f"{own.name}: {percentage(own.identified.left)} of its energy" for own in free)
        yield Paragraph(f"Left by all modes together: {LEAVE}.")
        yield Bullets(tuple(left))
    if compared.has_ambient:
        yield Paragraph("Under unknown forces shapes have no scale: masses and stiffnesses are open but for a factor.")


def _is_seen(compared: Compared, mode: int) -> bool:
    return any(own.chosen[mode] >= 0 for own in compared.recordings)
