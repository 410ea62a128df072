"""A fleet of diagnoses as the command runs it: a bar with an end, the page, and what could not be diagnosed."""

import shutil
import sys
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fe_models.errors import InputError, noting, raise_faults
from hybrid.fleet.diagnosed_file import Options

if TYPE_CHECKING:
    from hybrid.fleet.case import Case
    from hybrid.fleet.rows import Row

FRESH_AFTER = 20  # diagnoses of one process: what libraries hold on to stays bounded
LIMIT = 6 * 3600.0  # s: a diagnosis of a large frame takes minutes, a training on top less than an hour
INCOMPLETE = 1  # exit status where some datasets could not be diagnosed


def diagnose_fleet(paths: Sequence[Path], out: Path, options: Options, jobs: int | None, scheduler: str | None) -> int:
    """Diagnose all datasets among ``paths`` that ``out`` has no answer of; return the exit status.

    ``jobs``: processes on this machine; ``scheduler``: of a Dask cluster that does the work instead.
    """
    from hybrid.fleet.run import run_fleet
    from hybrid.fleet.table import FLEET_PAGE, in_terminal

    if jobs is not None and scheduler is not None:
        raise InputError("--jobs is for this machine, and --scheduler for a cluster: give one of them")
    cases = _cases(paths, out, options)
    bars: list[Any] = []
    try:
        rows = run_fleet(cases, out, _answers(jobs, scheduler, bars), partial(_advance, bars))
    except KeyboardInterrupt:
        print(f"\nWhat is done is kept in {out}; the same command goes on from there.", file=sys.stderr)
        raise
    finally:
        for bar in bars:
            bar.close()
    named = [(case.name, row) for case, row in zip(cases, rows, strict=True)]
    print(in_terminal(named, shutil.get_terminal_size((120, 24)).columns))
    failed = [row for row in rows if row is not None and row.told is None]
    _say(rows, failed)
    print(f"Results: {out / FLEET_PAGE}")
    return INCOMPLETE if failed else 0


def _cases(paths: Sequence[Path], out: Path, options: Options) -> "list[Case]":
    """Return what is to be done, once it is clear that results can be written."""
    from fe_models.progress import progress_bar
    from hybrid.fleet.case import case_of
    from hybrid.fleet.datasets import dataset_files, names_of
    from hybrid.fleet.table import table_in

    faults = list[str]()
    files = noting(faults, "", dataset_files, paths, out) or []
    noting(faults, "--out", table_in(out).check, files)
    raise_faults(faults)
    cases = []
    with progress_bar("Reading inputs", len(files), "dataset") as bar:
        for name, file in zip(names_of(files), files, strict=True):
            cases.append(case_of(name, file, out, options))
            bar.update()
    return cases


def _answers(jobs: int | None, scheduler: str | None, bars: list[Any]) -> Any:
    """Return what works on cases; the bar stays alive while it does."""
    from hybrid.fleet.case import diagnosed_case
    from hybrid.fleet.cluster import on_cluster
    from hybrid.fleet.processes import in_processes, usable_cores

    def waiting() -> None:
        for bar in bars:
            bar.refresh()

    if scheduler is not None:
        return partial(on_cluster, address=scheduler, work=diagnosed_case, waiting=waiting)
    return partial(
        in_processes,
        jobs=jobs or usable_cores(),
        work=diagnosed_case,
        limit=LIMIT,
        fresh_after=FRESH_AFTER,
        waiting=waiting,
    )


def _advance(bars: list[Any], done: int, planned: int) -> None:
    """Begin the bar at what an earlier run did, which takes no time of this one."""
    from fe_models.progress import progress_bar

    if bars:
        bars[0].update()
    else:
        bars.append(progress_bar("Diagnoses", planned, "dataset", done=done))


def _say(rows: "Sequence[Row | None]", failed: "Sequence[Row]") -> None:
    """Say on stderr what could not be diagnosed, and what could not be made beside the reports."""
    for row in rows:
        for note in row.told.notes if row is not None and row.told is not None else ():
            print(f"note: {row.name if row else ''}: {note}", file=sys.stderr)
    for row in failed:
        for fault in row.faults:
            print(f"error: {row.name}: {' '.join(fault.splitlines())}", file=sys.stderr)
