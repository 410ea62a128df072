"""How a text file of columns is laid out: its encoding, what separates columns, decimal commas, header and units.

All is guessed from the file's first lines, and `TextDialect.form` says what was.
"""

import codecs
import csv
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from fe_models.errors import InputError
from fe_models.files.size_limit import require_file
from fe_models.files.unit_words import known_unit

HEAD_BYTES = 2**16  # from which a layout is guessed: a thousand lines of most loggers
MIN_LINES = 8  # as many alike below it tell that what stands above a header is no part of it
SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs"}  # the first where a header has as many of several
SPACES = " "
LOST = frozenset({"", "nan", "na", "n/a", "#n/a", "null", "-"})
"""What stands in place of a sample that was lost, in small letters."""
BOMS = {codecs.BOM_UTF8: "utf-8-sig", codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16"}
LIKE_A_NUMBER = re.compile(r"[-+]?(\d+[.,]?\d*|[.,]\d+|\d{1,3}([.,]\d{3})+[.,]\d+)([eE][-+]?\d+)?$")
"""With a decimal point or comma, or thousands parted by one and decimals by the other; a date is none."""

Line = tuple[int, str]


@dataclass(frozen=True)
class TextDialect:
    """``separator``: one character, " " for any number of spaces; ``header`` and ``units``: the cells of these lines,
    no units where there are none; ``first``: number of the first line below; ``form``: in words, what is not usual.
    """

    encoding: str
    separator: str
    decimal_commas: bool
    header: list[str]
    units: list[str]
    first: int
    form: str

    def cells(self, line: str) -> list[str]:
        """Return the cells of a line."""
        return split(line, self.separator)

    def number(self, cell: str) -> float:
        """Return the number in a cell, NaN for a lost sample; `ValueError` where it is neither."""
        if cell.lower() in LOST:
            return float("nan")
        return float(cell.replace(",", ".") if self.decimal_commas else cell)


def dialect_of(path: Path) -> TextDialect:
    """Return the layout of a text file; `InputError` where it has no header and rows below it."""
    encoding, text = _head(path)
    written = [(number, line) for number, line in enumerate(text.splitlines(), start=1) if line.strip()]
    lines = [(number, line) for number, line in written if not line.lstrip().startswith("#")]
    if len(lines) < 2:
        raise InputError(f"{path}: expected a header line and rows of numbers, found {len(lines)} lines")
    separator, above = _layout([line for _, line in lines])
    (number, header), *rows = [(number, split(line, separator)) for number, line in lines[above:]]
    header = header[: filled(header)]
    if not header or all(_is_number(cell) for cell in header):
        raise InputError(
            f"{path}: line {number} holds numbers; expected a header line with a name for each column before them (a "
            "number that is a name needs a letter)"
        )
    units = _units(rows[0][1]) if rows else []
    body = [cell for _, row in rows[bool(units) :] for cell in row if LIKE_A_NUMBER.match(cell)]
    points, commas = any("." in cell for cell in body), any("," in cell for cell in body)
    decimal_commas = separator != "," and not points  # with points, commas may part thousands
    words = [f"separated by {SEPARATORS.get(separator, 'spaces')}"] if separator != "," else []
    words += ["with decimal commas"] if decimal_commas and commas else []
    words += ["with lines of comment, which are skipped"] if len(lines) < len(written) or above else []
    words += ["with units below the names"] if units else []
    words += [f"in {encoding}"] if encoding == "cp1252" else []
    first = (rows[0][0] if units else number) + 1
    return TextDialect(encoding, separator, decimal_commas, header, units, first, ", ".join(words))


def split(line: str, separator: str) -> list[str]:
    """Return the cells of a line, without quotation marks and spaces around them."""
    if separator == SPACES:
        return line.split()
    cells = next(csv.reader([line], delimiter=separator)) if '"' in line else line.split(separator)
    return [cell.strip() for cell in cells]


def filled(row: Sequence[str]) -> int:
    """Return the number of cells up to the last that holds something."""
    return max((column for column, cell in enumerate(row, start=1) if cell), default=0)


def _head(path: Path) -> tuple[str, str]:
    """Return the encoding of a file and the text of its first lines, all of them whole."""
    require_file(path)
    try:
        with path.open("rb") as file:
            head = file.read(HEAD_BYTES)
            ends = len(head) < HEAD_BYTES
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None
    encoding = next((name for bom, name in BOMS.items() if head.startswith(bom)), "utf-8")
    if encoding != "utf-16" and b"\0" in head:
        raise InputError(f"{path}: holds no text: save it as .csv again, or give it the ending of its own format")
    try:
        text = codecs.getincrementaldecoder(encoding)().decode(head, final=ends)
    except UnicodeDecodeError:
        encoding, text = "cp1252", head.decode("cp1252", errors="replace")  # what Windows writes ° and ² in
    whole = text if ends else text[: text.rfind("\n") + 1]
    return encoding, whole


def _layout(lines: list[str]) -> tuple[str, int]:
    """Return what separates the columns and the number of lines above the header.

    The header is the first line; or, where many lines below have another number of cells, the first one that has it
    and names columns of numbers.
    """
    first = max(SEPARATORS, key=lines[0].count)
    for separator in dict.fromkeys([first if first in lines[0] else SPACES, *SEPARATORS, SPACES]):
        widths = [filled(split(line, separator)) for line in lines]
        usual, times = Counter(widths[len(widths) // 2 :]).most_common(1)[0]
        if widths[0] == usual and usual > 1:
            return separator, 0
        if usual == 1 or times < MIN_LINES:
            continue
        rows = [split(line, separator) for line in lines]
        for above, (row, below) in enumerate(pairwise(rows)):
            begins = any(map(_is_number, below)) or bool(_units(below))
            if filled(row) == filled(below) == usual and begins and not any(map(_is_number, row)):
                return separator, above
    return first, 0


def _units(row: list[str]) -> list[str]:
    """Return a row of units; none where a cell is a number or none is a unit."""
    if any(_is_number(cell) for cell in row) or not any(map(known_unit, row)):
        return []
    return row


def _is_number(cell: str) -> bool:
    try:
        float(cell.replace(",", "."))
    except ValueError:
        return False
    return True
