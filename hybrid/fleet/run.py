"""A fleet of diagnoses: each dataset once, its row kept as soon as it is there, one page of all."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from time import monotonic

from fe_models.files.result_set import ResultSet
from hybrid.fleet.case import Case, Told, digest_of
from hybrid.fleet.engine import Answer, Answers, completed
from hybrid.fleet.failures import failure_of
from hybrid.fleet.rows import Row, keep_row, kept_rows
from hybrid.fleet.table import save_table, table_in

PAGE_EVERY = 10.0  # s: a page of many rows takes a part of a second, and diagnoses of chains a few
CHANGED = "the files that it reads were changed while it was diagnosed; run the same command again"

Outcome = Told | tuple[str, ...]


def run_fleet(
    cases: Sequence[Case],
    folder: Path,
    answers: Callable[[Iterator[Case]], Answers[Case, Outcome]],
    advance: Callable[[int, int], object] = lambda done, planned: None,
) -> list[Row | None]:
    """Diagnose the ``cases`` that ``folder`` has no answer of, by what gives ``answers``; return the row of each.

    The page in the folder is written now and then, and at the end. None: of a case that was not begun.
    """
    results, shown = table_in(folder), [monotonic()]
    there = kept_rows(folder, cases)
    made: dict[Case, Row] = dict(there)

    def keep(case: Case, answer: Answer[Outcome]) -> Row:
        row = made[case] = row_of(case, answer)
        keep_row(folder, row)
        if monotonic() - shown[0] > PAGE_EVERY:
            _show(results, cases, made)
            shown[0] = monotonic()
        return row

    try:
        completed(cases, there, answers, keep, advance=advance)
    finally:
        rows = _show(results, cases, made)
    return rows


def row_of(case: Case, answer: Answer[Outcome]) -> Row:
    """Return what to keep of a dataset; whatever ended its diagnosis stands in its row."""
    row = Row(case.name, case.file, case.digest, None)
    try:
        outcome = answer.result()
    except Exception as error:  # of any kind, in the work or the process: the other datasets go on
        trace = f"{error.__cause__ or ''}"
        return replace(row, faults=(failure_of(error),), trace=trace)
    if not isinstance(outcome, Told):
        return replace(row, faults=tuple(outcome))
    if digest_of(Path(case.file), case.options) != case.digest:
        return replace(row, faults=(CHANGED,))
    return replace(row, told=outcome)


def _show(results: ResultSet, cases: Sequence[Case], made: dict[Case, Row]) -> list[Row | None]:
    rows = [made.get(case) for case in cases]
    save_table(results, [(case.name, row) for case, row in zip(cases, rows, strict=True)])
    return rows
