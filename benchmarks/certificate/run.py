"""The certificate's run: cases in processes of their own, each kept as soon as it is done, and the page at the end."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future
from contextlib import closing
from datetime import UTC, datetime
from pathlib import Path
from time import monotonic

from pebble import ProcessExpired

from benchmarks.blind.cases import BlindResult, Task, done, in_processes
from benchmarks.certificate import counts, page
from benchmarks.certificate.code import Code, code_of
from benchmarks.certificate.counts import Certificate, certificate
from benchmarks.certificate.machine import machine
from benchmarks.certificate.plan import Column, interleaved
from benchmarks.certificate.record import Record, begin, keep, kept
from fe_models.errors import InputError
from fe_models.files.atomic import write_json, write_text

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
    records = kept(folder, tasks)
    advance(len(records), len(tasks))
    missing = [task for task in tasks if task not in records]
    with closing(in_processes(_until(missing, minutes), jobs, work, LIMIT)) as coming:
        for task, ready in coming:
            record = _record(ready, jobs)
            if code() != own:
                raise InputError(f"the code changed while cases of {own.words} ran; check that commit out to go on")
            keep(folder, task, record)
            records[task] = record
            advance(len(records), len(tasks))
    return certificate(own, columns, records)


def write(found: Certificate, folder: Path) -> tuple[Path, Path]:
    """Write the numbers and the page into a folder; return where they are."""
    numbers, text = folder / "certificate.json", folder / "certificate.md"
    write_json(numbers, counts.content(found))
    write_text(text, page.page(found))
    return numbers, text


def _until(tasks: Iterable[Task], minutes: float | None) -> Iterator[Task]:
    """Give tasks until so many minutes have passed."""
    begun = monotonic()
    for task in tasks:
        if minutes is not None and monotonic() - begun >= 60 * minutes:
            return
        yield task


def _record(ready: Future[BlindResult], jobs: int) -> Record:
    """Return what to keep of a case; whatever ended it without a report is counted by its name."""
    judgement, failure = None, ""
    try:
        judgement = ready.result().judgement
    except ProcessExpired as error:  # a signal, as of a system out of memory, or a crash of compiled code
        failure = f"process ended ({error.exitcode})"
    except Exception as error:  # a certificate counts every fault, whatever it is
        failure = type(error).__name__
    return Record(judgement, failure, machine(jobs), datetime.now(UTC).date().isoformat())
