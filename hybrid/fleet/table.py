"""The answers of a fleet in one table: as a page, as JSON, and for a terminal."""

from collections import Counter
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path
from textwrap import shorten
from typing import Any
from urllib.parse import quote

from fe_models.files.atomic import write_json, write_text
from fe_models.files.result_set import ResultSet
from hybrid.diagnosis.probability import per_cent, two_decimals
from hybrid.fleet.rows import Row
from hybrid.report.page import Block, Bullets, Cell, Page, Paragraph, Section, Table, Tone
from hybrid.report.rendering import rendered
from hybrid.report.values import NOTHING, fixed, number, percentage, typeset
from hybrid.result_sets import PAGE

FLEET_PAGE, FLEET_TABLE = "fleet.html", "fleet.json"
COLUMNS = ("dataset", "verdict", "answer", "probability", "error before", "error after", "gain", "time (s)")
NOT_YET, NONE = "Not diagnosed yet", "Could not be diagnosed"
ORDER = ("unexplained", "partly_explained", "explained", "nothing_wrong")  # of verdicts: what asks for most comes first
NOTE = (
    "Errors: NRMSE of forecasts of recordings that were never fitted, by the structure as drawn and by that with what"
    " was found; gain: the share of it that is gone, of what acts in some recordings alone in these. Each name leads to"
    " the report."
)
Named = Sequence[tuple[str, Row | None]]
"""The names of all datasets, with their rows; None of those that have not been diagnosed yet."""


def table_in(folder: Path) -> ResultSet:
    """Return what a fleet leaves in ``folder`` beside the folders of its datasets."""
    return ResultSet(folder, "fleet", (FLEET_PAGE, FLEET_TABLE))


def save_table(results: ResultSet, rows: Named) -> None:
    """Write the page and the table for programs."""
    with results.replacing() as new:
        write_json(new / FLEET_TABLE, content(rows))
        write_text(new / FLEET_PAGE, rendered(page(rows)))


def content(rows: Named) -> dict[str, Any]:
    """Return the table as plain data."""
    return {
        "schema": 1,
        "planned": len(rows),
        "diagnosed": sum(row is not None and row.told is not None for _, row in rows),
        "cases": [_content(name, row) for name, row in rows],
    }


def _content(name: str, row: Row | None) -> dict[str, Any]:
    if row is None:
        return {"name": name, "state": "not_yet"}
    told = row.told
    if told is None:
        return {"name": name, "state": "failed", "dataset": row.file, "faults": list(row.faults)}
    return {
        "name": name,
        "state": "diagnosed",
        "dataset": row.file,
        "report": f"{name}/{PAGE}",
        "verdict": told.verdict,
        "sentence": told.sentence,
        "probability": told.probability,
        "forecast_error": {"before": told.before, "after": told.after, "noise_floor": told.noise_floor},
        "gain": row.gain,
        "seconds": told.seconds,
        "notes": list(told.notes),
    }


def page(rows: Named) -> Page:
    """Return the page of a fleet."""
    done = [row for _, row in rows if row is not None and row.told is not None]
    failed = [row for _, row in rows if row is not None and row.told is None]
    waiting = len(rows) - len(done) - len(failed)
    verdicts = Counter(row.told.words for row in done if row.told is not None)
    sentence = f"{len(done)} of {len(rows)} datasets are diagnosed"
    sentence += f", {len(failed)} could not be." if failed else "."
    sections = [Section("answers", "All answers", (_table(rows),))]
    if failed:
        sections.append(Section("failed", NONE, tuple(_faults(failed))))
    return Page(
        title=f"Diagnoses of {len(rows)} datasets",
        verdict="Not all are done" if waiting else "All are done",
        tone=Tone.OPEN if waiting or failed else Tone.GOOD,
        sentence=sentence,
        summary="The same command goes on with the others." if waiting else "",
        facts=tuple((words, str(count)) for words, count in verdicts.most_common()),
        next=(),
        sections=tuple(sections),
        footer=f"Written {datetime.now():%d %B %Y, %H:%M}. This page loads nothing and reports to nobody; its links"
        " lead to the folders beside it.",
    )


def _table(rows: Named) -> Table:
    ordered = sorted(rows, key=lambda item: _urgency(item[1]))
    return Table("The answers, what asks for most first.", COLUMNS, tuple(_cells(*item) for item in ordered), NOTE)


def _urgency(row: Row | None) -> tuple[int, float]:
    if row is None:
        return len(ORDER) + 1, 0.0
    if row.told is None:
        return -1, 0.0
    place = ORDER.index(row.told.verdict) if row.told.verdict in ORDER else len(ORDER)
    return place, -(row.told.probability or 0.0)


def _cells(name: str, row: Row | None) -> tuple[Cell, ...]:
    empty = Cell(NOTHING)
    if row is None:
        return Cell(name), Cell(NOT_YET), *[empty] * (len(COLUMNS) - 2)
    told = row.told
    if told is None:
        return Cell(name), Cell(NONE), Cell(row.faults[0] if row.faults else ""), *[empty] * (len(COLUMNS) - 3)
    return (
        Cell(name, href=f"{quote(name)}/{PAGE}"),
        Cell(told.words),
        Cell(told.sentence),
        empty if told.probability is None else Cell(per_cent(told.probability), told.probability),
        fixed(told.before, 4),
        fixed(told.after, 4),
        empty if row.gain is None else Cell(_gain(row.gain), row.gain),
        number(told.seconds, 3),
    )


def _gain(gain: float) -> str:
    return percentage(gain) if gain >= 0 else f"−{percentage(-gain)}"


def _faults(failed: Sequence[Row]) -> list[Block]:
    blocks = list[Block]()
    for row in failed:
        blocks += [Paragraph(f"{row.name} ({row.file}):"), Bullets(tuple(typeset(fault) for fault in row.faults))]
    return blocks


def in_terminal(rows: Named, width: int) -> str:
    """Return the table in lines that are ``width`` characters wide."""
    cells = [[name, *_line(row)] for name, row in rows]
    heads = ["dataset", "probability", "gain", "answer"]
    sizes = [max(len(line[k]) for line in [heads, *cells]) for k in range(3)]
    room = max(20, width - sum(sizes) - 2 * 3)
    lines = [[*line[:3], shorten(line[3], room, placeholder=" ...")] for line in [heads, *cells]]
    return "\n".join(
        f"{name:<{sizes[0]}}  {sure:>{sizes[1]}}  {gain:>{sizes[2]}}  {answer}".rstrip()
        for name, sure, gain, answer in lines
    )


def _line(row: Row | None) -> tuple[str, str, str]:
    if row is None:
        return "", "", NOT_YET.lower()
    if row.told is None:
        return "", "", f"error: {'; '.join(row.faults)}"
    sure = "" if row.told.probability is None else two_decimals(row.told.probability)
    return sure, "" if row.gain is None else f"{100 * row.gain:.0f} %", row.told.sentence
