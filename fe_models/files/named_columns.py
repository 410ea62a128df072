"""The columns of a recording file that names them, whatever its format."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from fe_models.arrays import FloatArray
from fe_models.errors import InputError, raise_faults
from fe_models.files.time_column import time_column
from fe_models.files.unit_words import known_unit


class ReadColumns(Protocol):
    """Reads columns, counted from 0, as numbers (sample, column); a lost sample is NaN."""

    def __call__(self, columns: Sequence[int]) -> FloatArray: ...  # noqa: D102


@dataclass(frozen=True)
class NamedColumns:
    """What the columns of ``path`` are called, and how they are read.

    ``units``: one a column, "" where the file says none. ``others``: further names of a column, such as that without
    the group it is in. ``sampling_rate``: Hz, where the file says it. ``form``: in words, what was guessed of the file.
    ``numeric``: which columns begin with a number; () where all hold numbers.
    """

    path: Path
    names: tuple[str, ...]
    units: tuple[str, ...]
    read: ReadColumns
    others: tuple[tuple[str, ...], ...] = ()
    sampling_rate: float | None = None
    form: str = ""
    numeric: tuple[bool, ...] = ()

    def find(self, name: str) -> int | None:
        """Return the number of the column of that name, None where there is none; `InputError` where there are two."""
        for known in ([(own,) for own in self.names], self.others):
            found = [column for column, names in enumerate(known) if name in names]
            if len(found) > 1:
                raise InputError(f"{self.path}: column {name!r} appears {_times(len(found))}")
            if found:
                return found[0]
        return None

    def time(self, others: Collection[str]) -> int | None:
        """Return the number of the column of times, None where there is none; ``others`` name something else."""
        taken = {self.find(name) for name in others}
        spoken = [(name, *more) for name, more in zip(self.names, self.others or [()] * len(self.names), strict=True)]
        for column, names in enumerate(spoken):
            is_number = not self.numeric or self.numeric[column]  # a date is no time in seconds
            if is_number and column not in taken and time_column(list(names), []) is not None:
                return column
        return None

    def seconds(self, column: int) -> float:
        """Return what one of a column of times is in s."""
        unit = known_unit(self.units[column])
        return unit.factor if unit is not None and unit.si == "s" else 1.0

    def listed(self) -> str:
        """Return the names of all columns, for a message."""
        return ", ".join(repr(name) if name else "one without a name" for name in self.names)


def converting_factor(column: str, own: str, asked: str) -> float:
    """Return what brings a column from its ``own`` unit to the one ``asked`` for; 1 where either is unknown.

    `InputError` where the two are of different quantities.
    """
    have, want = known_unit(own), known_unit(asked)
    if have is None or want is None:
        return 1.0
    if have.si != want.si:
        raise InputError(f"column {column!r} is in {own}, which is no {asked}: name another, or correct the unit")
    return have.factor / want.factor


def required(table: NamedColumns, names: Sequence[str], what: str) -> list[int]:
    """Return the columns of ``names``; `InputError` with a fault for each that is missing. ``what`` they are of."""
    found = [table.find(name) for name in names]
    missing = [name for name, column in zip(names, found, strict=True) if column is None]
    raise_faults(f"{table.path}: there is no column {what}{name!r}; it has {table.listed()}" for name in missing)
    return [column for column in found if column is not None]


def _times(count: int) -> str:
    return "twice" if count == 2 else f"{count} times"
