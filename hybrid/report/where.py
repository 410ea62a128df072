"""Where what was found is: the drawn structure with sensors, what is wrong, and what may be so instead."""

from collections.abc import Iterator

from fe_models.causes.wording import kind_words, place_words
from fe_models.pictures.pointers import Pointer, pointer_to
from fe_models.pictures.structure_drawing import structure_picture
from fe_models.recordings import Dataset
from hybrid.diagnosis.answer import Answer, measure_of_explained
from hybrid.diagnosis.probability import per_cent
from hybrid.report.answer import fitted_names
from hybrid.report.drawings import pictured
from hybrid.report.page import Block, Cell, Paragraph, Section, Table
from hybrid.report.values import NOTHING, of_parameter, share

WIDTHS = (1600,)  # px in which a structure is drawn: numbers on a wider one are too small on a page
MAX_RIVALS = 5  # of a finding, on the drawing
MAX_NAMED = 4  # findings whose names the drawing has room for; of more it shows the numbers
LEAST_RIVAL = 0.01  # probability of a rival that is drawn
EVERYWHERE = "in all"
NAMES_NOTHING = "Nothing is named as wrong, so that nothing is marked on the structure."
MARKED = " What is wrong is marked, by its number in the table below; what is only possible instead is paler."
CAUSES = "What is wrong, most important first. ± is one standard deviation."


def where(found: Answer, dataset: Dataset) -> Section:
    """Return the drawing and the table of what was found."""
    pointers = tuple(_pointers(found, dataset))
    marked = [pointer.name for pointer in pointers]
    picture = structure_picture(dataset.model, dataset.sensors, WIDTHS, pointers)
    names = ", ".join(sensor.name for sensor in dataset.sensors)
    marks = f" Marked: {'; '.join(marked)}." if marked else ""
    drawing = pictured(
        picture,
        "The structure as it was drawn, with the numbers of nodes and elements; arrows are sensors, along what they"
        " measure." + (MARKED if marked else ""),
        f"Drawing of the structure with sensors {names}.{marks}",
    )
    blocks: list[Block] = [drawing]
    if found.findings:
        blocks.append(_table(found, dataset))
    else:
        blocks.insert(0, Paragraph(NAMES_NOTHING))
    drawn = dataset.model, dataset.sensors
    nowhere = [own for own in found.findings if pointer_to(own.cause.location, "", *drawn) is None]
    if nowhere:
        kinds = ", ".join(kind_words(finding.cause.kind) for finding in nowhere)
        blocks.append(Paragraph(f"Not marked, as it is at no single place: {kinds}."))
    return Section("where", "Where", tuple(blocks))


def _pointers(found: Answer, dataset: Dataset) -> Iterator[Pointer]:
    drawn = dataset.model, dataset.sensors
    taken = {str(finding.cause.location) for finding in found.findings}
    for number, finding in enumerate(found.findings, start=1):
        name = f"{number}: {kind_words(finding.cause.kind)}, {_briefly(finding.probability)}"
        name = name if len(found.findings) <= MAX_NAMED else str(number)
        pointer = pointer_to(finding.cause.location, name, *drawn)
        if pointer is not None:
            yield pointer
    for number, finding in enumerate(found.findings, start=1):
        rivals = [item for item in finding.alternatives if not item.is_remainder and item.probability >= LEAST_RIVAL]
        for rival in rivals[:MAX_RIVALS]:
            if str(rival.location) in taken and rival.kind == finding.cause.kind:
                continue
            name = f"or {kind_words(rival.kind)} instead of {number}, {_briefly(rival.probability)}"
            pointer = pointer_to(rival.location, name, *drawn, is_faint=True)
            if pointer is not None:
                yield pointer


def _briefly(value: float) -> str:
    return per_cent(value).replace("more than ", "> ").replace("less than ", "< ")


def _table(found: Answer, dataset: Dataset) -> Table:
    every = fitted_names(dataset)
    rows = []
    for number, finding in enumerate(found.findings, start=1):
        own = list(dict.fromkeys(finding.recordings))
        acts = EVERYWHERE if every <= set(own) or not own else ", ".join(own)
        sizes = "; ".join(f"{word} {of_parameter(item)}" for word, item in finding.parameters.items())
        explains = share(finding.explains) if finding.explains else Cell(NOTHING)
        rows.append(
            (
                Cell(str(number), number),
                Cell(kind_words(finding.cause.kind)),
                Cell(place_words(finding.cause.location)),
                Cell(sizes or NOTHING),
                Cell(per_cent(finding.probability), finding.probability),
                explains,
                Cell(acts),
            )
        )
    columns = ("No.", "cause", "place", "size", "probability", "explains", "recordings")
    note = f"Explains: the share that goes away with it, of {measure_of_explained(found)}."
    return Table(CAUSES, columns, tuple(rows), note)
