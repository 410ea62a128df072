"""Text files of columns, .csv and .txt, read line by line, so that a long one needs no more memory than its numbers."""

from array import array
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain, islice
from pathlib import Path

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.errors import InputError, raise_faults
from fe_models.files.clock_times import clock_seconds
from fe_models.files.named_columns import NamedColumns
from fe_models.files.size_limit import check_values
from fe_models.files.text_dialect import SPACES, TextDialect, dialect_of, filled
from fe_models.files.time_column import is_time
from fe_models.files.unit_words import name_and_unit

MAX_FAULTY_LINES = 5  # of a file, each with its fault
FIRST_ROWS = 20  # that tell whether a column holds numbers
CHUNK = 50_000  # lines, after which the numbers read so far are counted


@dataclass(frozen=True)
class TextTable:
    """A text file with a ``header`` and rows below it. Comments, empty lines, and empty columns and rows at its end
    are none.
    """

    path: Path
    dialect: TextDialect

    @property
    def header(self) -> list[str]:
        """The names of the columns."""
        return self.dialect.header

    def lines(self) -> Iterator[tuple[int, str]]:
        """Yield the number and the text of each line below the header that is no comment."""
        try:
            with self.path.open(encoding=self.dialect.encoding, errors="replace", newline=None) as file:
                for number, line in enumerate(file, start=1):
                    if number >= self.dialect.first and line.strip() and not line.lstrip().startswith("#"):
                        yield number, line.rstrip("\r\n")
        except OSError as error:
            raise InputError(f"{self.path}: cannot be read ({error.strerror})") from None

    def rows(self) -> Iterator[tuple[int, list[str]]]:
        """Yield the number and the cells of each row up to the last that holds something."""
        empty: list[tuple[int, list[str]]] = []
        for number, line in self.lines():
            row = self.dialect.cells(line)
            if not any(row):
                empty.append((number, row))
                continue
            yield from empty
            empty.clear()
            yield number, row

    def numbers(self, columns: Sequence[int]) -> FloatArray:
        """Return the numbers (row, column) of ``columns``, NaN where one is lost; `InputError` names faulty lines."""
        if self._clocks().intersection(columns):
            return self._numbers(columns)
        try:
            return self._plain_numbers(columns)
        except ValueError:
            return self._numbers(columns)

    def _plain_numbers(self, columns: Sequence[int]) -> FloatArray:
        """Return the numbers of a file without a fault or a lost sample; `ValueError` for any other."""
        mark, commas = self.dialect.separator, self.dialect.decimal_commas
        count = len(self.header) - 1

        def plain() -> Iterator[str]:
            for number, (_, line) in enumerate(self.lines()):
                if '"' in line or (mark != SPACES and line.count(mark) != count):
                    raise ValueError
                if number % CHUNK == 0:
                    check_values(number * len(columns), self.path)
                yield line.replace(",", ".") if commas else line

        rows = plain()
        first = next(rows, None)
        if first is None:
            raise ValueError
        delimiter = None if mark == SPACES else mark
        return np.loadtxt(chain([first], rows), delimiter=delimiter, usecols=columns, comments=None, ndmin=2)

    def _numbers(self, columns: Sequence[int]) -> FloatArray:
        """Return the same row by row, with what is wrong with each."""
        values, words, uneven = array("d"), list[str](), list[str]()
        width, clocks = len(self.header), self._clocks()
        readers = [(column, clock_seconds if column in clocks else self.dialect.number) for column in columns]
        for number, row in self.rows():
            if len(row) < width or filled(row) > width:
                uneven.append(f"line {number} has {max(filled(row), min(len(row), width))} values, the header {width}")
                continue
            for column, read in readers:
                try:
                    values.append(read(row[column]))
                except ValueError:
                    words.append(f"line {number}: {row[column]!r} is not a number")
            check_values(len(values), self.path)
        faults = uneven or words
        more = len(faults) - MAX_FAULTY_LINES
        raise_faults(
            [f"{self.path}: {fault}" for fault in faults[:MAX_FAULTY_LINES]]
            + ([f"{self.path}: and {more} more of that kind"] if more > 0 else [])
        )
        return np.array(values).reshape(-1, len(columns))

    def columns(self) -> NamedColumns:
        """Return the table as columns with names and units."""
        spoken = [name_and_unit(name) for name in self.header]
        below = [*self.dialect.units, *[""] * len(self.header)]
        units = tuple(below[column] or unit for column, (_, unit) in enumerate(spoken))
        others = tuple((name,) if unit else () for name, unit in spoken)
        return NamedColumns(
            self.path, tuple(self.header), units, self.numbers, others, form=self.dialect.form, numeric=self._numeric()
        )

    def _clocks(self) -> frozenset[int]:
        """Return which columns are called times, and begin with the time of a clock."""
        first = next(self.rows(), None)
        cells = [] if first is None else first[1]
        called = zip(self.header, cells, strict=False)
        return frozenset(column for column, (name, cell) in enumerate(called) if is_time(name) and _is_clock(cell))

    def _numeric(self) -> tuple[bool, ...]:
        """Return which columns hold a number, the time of a clock, or nothing in the first rows."""
        found, clocks = [True] * len(self.header), self._clocks()
        for _, row in islice(self.rows(), FIRST_ROWS):
            for column, cell in enumerate(row[: len(found)]):
                try:
                    self.dialect.number(cell)
                except ValueError:
                    found[column] &= column in clocks
        return tuple(found)


def _is_clock(cell: str) -> bool:
    try:
        clock_seconds(cell)
    except ValueError:
        return False
    return not cell.strip().isdigit()  # "2024" is a number


def open_table(path: Path) -> TextTable:
    """Return a text file of columns; `InputError` where it has no header and rows of cells below it."""
    table = TextTable(path, dialect_of(path))
    if next(table.rows(), None) is None:
        raise InputError(f"{path}: expected a header line and rows of numbers, found 1 lines")
    return table
