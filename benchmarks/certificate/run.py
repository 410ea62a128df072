"""The certificate's run: cases in processes of their own, each kept as soon as it is done, and the page at the end."""

from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

from pebble import ProcessExpired

from benchmarks.blind.cases import BlindResult, Task, done
from benchmarks.certificate import counts, page
from benchmarks.certificate.code import Code, code_of
from benchmarks.certificate.counts import Certificate, certificate
from benchmarks.certificate.machine import machine
from benchmarks.certificate.plan import Column, interleaved
from benchmarks.certificate.record import Record, begin, keep, kept
from fe_models.errors import InputError
from fe_models.files.atomic import write_json, write_text
from hybrid.fleet.engine import Answer, completed
from hybrid.fleet.processes import in_processes

LIMIT = 7200.0  # s, on a machine that may do other work as well; a case beyond is ended and counts as having no report


def run(
    columns: Sequence[Column],
    folder: Path,
    *,
    jobs: int,
    minutes: float | None = None,
    changed: bool = False,
    code: Callable[[], Code] = code_of,
    work: Callable[[Task], BlindResult] = done,
    advance: Callable[[int, int], object] = lambda done, planned: None,
) -> Certificate:
    """Do the cases that ``folder`` lacks, ``jobs`` at a time, and return the numbers of all that are there.

    After so many ``minutes`` no new case is begun. ``changed``: code that is not committed may run. ``work`` answers a
    task. ``advance`` is given how many cases are there, of how many. Raises `InputError` where the ``code`` is not
    committed, is not that of the cases in the folder, or changes meanwhile.
    """
    own = code()
    if own.changes and not changed:
        raise InputError(f"{own.words}: commit or stash them, or give --dirty, which the page then states")
    begin(folder, own, columns)
    tasks = interleaved(columns)

    def keep_record(task: Task, ready: Answer[BlindResult]) -> Record:
        record = _record(ready, jobs)
        if code() != own:
            raise InputError(f"the code changed while cases of {own.words} ran; check that commit out to go on")
        keep(folder, task, record)
        return record

    answers = partial(in_processes, jobs=jobs, work=work, limit=LIMIT)
    records = completed(tasks, kept(folder, tasks), answers, keep_record, minutes=minutes, advance=advance)
    return certificate(own, columns, records)


def write(found: Certificate, folder: Path) -> tuple[Path, Path]:
    """Write the numbers and the page into a folder; return where they are."""
    numbers, text = folder / "certificate.json", folder / "certificate.md"
    write_json(numbers, counts.content(found))
    write_text(text, page.page(found))
    return numbers, text


def _record(ready: Answer[BlindResult], jobs: int) -> Record:
    """Return what to keep of a case; whatever ended it without a report is counted by its name."""
    judgement, failure = None, ""
    try:
        judgement = ready.result().judgement
    except ProcessExpired as error:  # a signal, as of a system out of memory, or a crash of compiled code
        failure = f"process ended ({error.exitcode})"
    except Exception as error:  # a certificate counts every fault, whatever it is
        failure = type(error).__name__
    return Record(judgement, failure, machine(jobs), datetime.now(UTC).date().isoformat())
