"""What is kept of each dataset of a fleet: its answer in a line, or why there is none; a file each, written whole."""

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from math import isfinite
from pathlib import Path

from pydantic import TypeAdapter, ValidationError

from fe_models.files.atomic import write_json
from hybrid.fleet.case import Case, Told
from hybrid.result_sets import REPORT

KEPT = ".fleet"
"""The folder, within that of the results, of what is kept."""


@dataclass(frozen=True)
class Row:
    """A dataset's ``name`` and ``file``, the ``digest`` of its inputs and options, and what was ``told`` of it; None
    where it could not be diagnosed, which ``faults`` say; ``trace``: where a fault of the program lies.
    """

    name: str
    file: str
    digest: str
    told: Told | None
    faults: tuple[str, ...] = ()
    trace: str = ""

    @property
    def gain(self) -> float | None:
        """The share of the forecast error that what was found takes away, where it acts; None where it is not known."""
        if self.told is not None and self.told.change_gain is not None:
            return self.told.change_gain
        if self.told is None or self.told.before is None or self.told.after is None or self.told.before <= 0:
            return None
        gain = 1 - self.told.after / self.told.before
        return gain if isfinite(gain) else None


def keep_row(folder: Path, row: Row) -> None:
    """Write what was told of a dataset."""
    write_json(_path(folder, row.name), {"schema": 1, **asdict(row)})


def kept_rows(folder: Path, cases: Iterable[Case]) -> dict[Case, Row]:
    """Return the rows of the cases that have been diagnosed, from the same inputs and with the same options.

    What could not be diagnosed is tried again, and so is what has lost its report.
    """
    found = dict[Case, Row]()
    for case in cases:
        row = _row(_path(folder, case.name))
        if row is None or row.told is None or not case.digest or row.digest != case.digest:
            continue
        if (Path(case.out) / REPORT).is_file():
            found[case] = row
    return found


def _path(folder: Path, name: str) -> Path:
    return folder / KEPT / f"{name}.json"


def _row(path: Path) -> Row | None:
    """Return what a file holds; None where it is not there, or holds something else: it is made again."""
    try:
        return TypeAdapter(Row).validate_json(path.read_bytes())
    except (OSError, ValidationError):
        return None
