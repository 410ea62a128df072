"""The certificate as the command runs it: a bar with an end, the page in the documents, and what to do to go on."""

import sys
from pathlib import Path
from typing import Any

from benchmarks.certificate.code import INSTALLED, ROOT, Code, code_of
from benchmarks.certificate.counts import Certificate, content
from benchmarks.certificate.page import rates_table, sections
from benchmarks.certificate.plan import COLUMNS
from benchmarks.certificate.run import run, write
from fe_models.progress import progress_bar
from hybrid.diagnosis.track_record.certified import install

INTERRUPTED = 130  # the exit status of what the keyboard ended


def default_folder(code: Code) -> Path:
    """Return where the cases of a code are kept."""
    return Path("runs/certificate") / code.commit[:12]


def certify(out: Path | None, jobs: int, minutes: float | None, dirty: bool) -> Certificate:
    """Do the cases that are missing, write ``docs/certificate.md`` and ``.json`` and what reports are to say of them,
    and print the rates.
    """
    code = code_of()
    folder = out or default_folder(code)
    bars: list[Any] = []

    def advance(done: int, planned: int) -> None:
        """Begin the bar at what an earlier run did, which takes no time of this one."""
        if bars:
            bars[0].update()
        else:
            bars.append(progress_bar("Certificate", planned, "case", done=done))

    try:
        found = run(COLUMNS, folder, jobs=jobs, minutes=minutes, changed=dirty, advance=advance)
    except KeyboardInterrupt:
        print(f"\nWhat is done is kept in {folder}; the same command goes on from there.", file=sys.stderr)
        raise SystemExit(INTERRUPTED) from None
    finally:
        for bar in bars:
            bar.close()
    numbers, page = write(found, ROOT / "docs")
    install(content(found), ROOT / INSTALLED)
    for title, columns in sections(found):
        print("\n".join([title, "", *rates_table(columns), ""]))
    if found.done < found.planned:
        print(f"{found.done} of {found.planned} cases so far; the same command goes on from there")
    print(f"Cases: {folder}\nResults: {page}, {numbers}")
    return found
