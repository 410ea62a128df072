"""What is kept of each case: one file a case, written whole as soon as it is done."""

import json
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from benchmarks.blind.cases import BlindResult, Task
from benchmarks.blind.judging import Judgement, no_report
from benchmarks.certificate.code import Code
from benchmarks.certificate.plan import Column
from fe_models.errors import InputError, noting, raise_faults
from fe_models.files.atomic import write_json

SCHEMA = 1
RUN = "run.json"  # of what code, and of which columns, the folder holds cases


@dataclass(frozen=True)
class Record:
    """A case done: its ``judgement``, or the name of the ``failure`` where there was no report; where and when."""

    judgement: Judgement | None
    failure: str
    machine: str
    day: str

    def result(self, task: Task) -> BlindResult:
        """Return the result to count: without a report nothing is right."""
        return BlindResult(task, self.judgement or no_report(task.hidden), {})


def begin(folder: Path, code: Code, columns: Iterable[Column]) -> None:
    """Note in a new ``folder`` what its cases are of; `InputError` where it holds cases of something else."""
    listed = [{**asdict(column), "kinds": list(column.kinds)} for column in columns]  # JSON has no tuples
    wanted: dict[str, Any] = {"schema": SCHEMA, **asdict(code), "columns": listed}
    path = folder / RUN
    if not path.exists():
        write_json(path, wanted)
        return
    there = _content(path)
    held = Code(str(there.get("commit")), str(there.get("changes")))
    if held != code:
        raise InputError(
            f"{folder}: holds cases of {held.words}; the code is {code.words}. A certificate is of one code: "
            f"check that commit out to go on, or choose another folder"
        )
    if there != wanted:
        raise InputError(f"{folder}: holds cases of other columns; choose another folder")


def keep(folder: Path, task: Task, record: Record) -> None:
    """Write the record of a task."""
    own = None if record.judgement is None else record.judgement.as_json()
    content = {"schema": SCHEMA, "seed": task.seed, "hidden": task.hidden, **asdict(record), "judgement": own}
    write_json(_path(folder, task), content)


def kept(folder: Path, tasks: Iterable[Task]) -> dict[Task, Record]:
    """Return the records that are there; `InputError` names the files that are damaged."""
    found: dict[Task, Record] = {}
    faults: list[str] = []
    for task in tasks:
        path = _path(folder, task)
        if path.exists() and (record := noting(faults, "", _record, path)):
            found[task] = record
    raise_faults(faults)
    return found


def _path(folder: Path, task: Task) -> Path:
    return folder / "cases" / f"{task.seed}.json"


def _record(path: Path) -> Record:
    content = _content(path)
    own = content.get("judgement")
    try:
        judgement = None if own is None else Judgement.from_json(own)
        fields = {name: content.get(name) for name in ("failure", "machine", "day")}
        return TypeAdapter(Record).validate_python({**fields, "judgement": judgement})
    except (ValidationError, AttributeError) as error:
        raise InputError(f"{path}: is no record of a case; delete it to have it made again") from error


def _content(path: Path) -> dict[str, Any]:
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        content = None
    if not isinstance(content, dict):
        raise InputError(f"{path}: is damaged; delete it to have it made again")
    return content
