"""What is not known: rivals that the sensors cannot rule out, what would decide, and where error is left."""

from itertools import pairwise

import numpy as np

from fe_models.arrays import TINY, FloatArray
from fe_models.causes.wording import kind_words, place_words
from fe_models.spectra import line_frequencies, power_spectrum
from hybrid.diagnosis.answer import Answer, measure_of_left
from hybrid.diagnosis.next_measurement.recommendation import NextMeasurement
from hybrid.diagnosis.observed.example import Example
from hybrid.diagnosis.outcome.findings import Finding
from hybrid.diagnosis.probability import per_cent
from hybrid.diagnosis.report import REMAINDERS
from hybrid.report.page import Block, Bullets, Cell, Heading, Paragraph, Section, Table
from hybrid.report.values import NOTHING, of_parameter, percentage, sentence, share

PARTS_OF_TIME = 5
NO_RIVALS = "No other cause on the list has a probability worth a line."
ELSEWHERE = "elsewhere"
LEFT = (
    "Error over motion: the root mean square of the forecast's error over that of the recording. Share: of all that is"
    " left of the error's energy, each channel over its size. At the noise floor all that is left is noise."
)

EXPECTED = (
    "Information: by how much the measurement is expected to lessen the doubt which of the causes above is right."
    " Probability: to expect, with it, of the cause that is then likeliest."
)


def what_is_not_known(found: Answer) -> Section:
    """Return rivals, advice, and what of the error is left: where, near which modes, when."""
    blocks: list[Block] = [Heading("What may be so instead")]
    tables = [
        _rivals(number, finding) for number, finding in enumerate(found.findings, start=1) if finding.alternatives
    ]
    blocks += tables or [Paragraph(NO_RIVALS)]
    if found.next_measurement is not None:
        blocks += _next(found.next_measurement)
    blocks.append(Heading("What is left unexplained"))
    if found.findings:
        blocks.append(Paragraph(sentence(f"{percentage(found.unexplained)} of {measure_of_left(found)}")))
    if found.example is not None:
        blocks += [_by_channel(found.example), _by_mode(found.example), _by_time(found.example)]
    return Section("unknown", "What is not known", tuple(blocks))


def _next(then: NextMeasurement) -> list[Block]:
    """Return what to measure next, and what is expected of each measurement."""
    blocks: list[Block] = [Heading("Measure this next"), Bullets(tuple(map(sentence, then.sentences[:1])))]
    if len(then.options) > 1:
        rows = tuple(
            (
                Cell(option.measurement.title),
                Cell(f"{option.information:.2f}", option.information),
                Cell(per_cent(option.probability), option.probability),
            )
            for option in then.options
        )
        caption = f"What is expected of each; now {per_cent(then.now)}."
        columns = ("measurement", "information (bits)", "probability of the right cause")
        blocks.append(Table(caption, columns, rows, EXPECTED))
    return blocks + ([Paragraph(sentence(then.sentences[-1]))] if then.options and then.open else [])


def _rivals(number: int, finding: Finding) -> Table:
    rows = []
    for item in finding.alternatives:
        sizes = "; ".join(f"{word} {of_parameter(own)}" for word, own in item.parameters.items())
        words = (kind_words(item.kind), place_words(item.location))
        words = (REMAINDERS[item.kind], NOTHING) if item.is_remainder else words
        rows.append((*map(Cell, words), Cell(sizes or NOTHING), Cell(per_cent(item.probability), item.probability)))
    what = f"{kind_words(finding.cause.kind)}, {place_words(finding.cause.location)}"
    caption = f"In the place of finding {number} ({what}, {per_cent(finding.probability)})."
    return Table(caption, ("cause", "place", "size", "probability"), tuple(rows))


def _scaled(example: Example) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return motion, and errors before and after, (time, sensor), each channel over its size."""
    size = np.maximum(example.measured.std(axis=0), TINY)
    own = example.measured - example.measured.mean(axis=0)
    before, after = (example.measured - one for one in (example.nominal, example.extended))
    return own / size, before / size, after / size


def _table(caption: str, first: str, names: list[str], sizes: FloatArray, note: str = "") -> Table:
    """Return the table of ``sizes`` (3, row): energies of the motion and of errors before and after."""
    total = max(float(sizes[2].sum()), TINY)
    rows = tuple(
        (
            Cell(name),
            share(float(np.sqrt(before / max(motion, TINY)))),
            share(float(np.sqrt(after / max(motion, TINY)))),
            share(after / total),
        )
        for name, motion, before, after in zip(names, *sizes.tolist(), strict=True)
    )
    columns = (first, "error over motion, as drawn", "with what was found", "share of what is left")
    return Table(caption, columns, rows, note)


def _by_channel(example: Example) -> Table:
    sizes = np.array([np.square(part).sum(axis=0) for part in _scaled(example)])
    names = [sensor.name + (", never fitted" if sensor.role == "held_out" else "") for sensor in example.sensors]
    return _table(f"By channel, in {example.recording}.", "channel", names, sizes, LEFT)


def _by_mode(example: Example) -> Table:
    """Return what lies nearest to each natural frequency, on a logarithmic scale, up to twice the highest."""
    lines = line_frequencies(len(example.measured), example.rate)
    known = np.sort(example.frequencies[(example.frequencies > 0) & (example.frequencies < example.rate / 2)])
    powers = np.array([power_spectrum(part).sum(axis=1) for part in _scaled(example)])  # (3, line)
    if not len(known):
        return _table(f"By frequency, in {example.recording}.", "frequency", ["all"], powers.sum(axis=1, keepdims=True))
    edges = np.concatenate([[known[0] / 2], np.sqrt(known[:-1] * known[1:]), [2 * known[-1]]])
    inside = [(lines >= low) & (lines < high) for low, high in pairwise(edges)]
    beyond = ~np.logical_or.reduce(inside)
    names = [f"{own:.4g} Hz" for own in known] + [ELSEWHERE]
    sizes = np.array([[power[part].sum() for part in [*inside, beyond]] for power in powers])
    return _table(f"By natural frequency (what lies nearest to it), in {example.recording}.", "near", names, sizes)


def _by_time(example: Example) -> Table:
    parts = [np.array_split(part, PARTS_OF_TIME) for part in _scaled(example)]
    ends = np.cumsum([0, *(len(part) for part in parts[0])]) / example.rate + example.first
    names = [f"{begin:.3g} to {end:.3g} s" for begin, end in pairwise(ends)]
    sizes = np.array([[float(np.square(own).sum()) for own in part] for part in parts])
    return _table(f"By time, in {example.recording}.", "from, to", names, sizes)
