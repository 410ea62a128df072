"""Arrays of numbers from files: .npz, .mat (MATLAB 5) and .csv. Nothing in a file is executed: no pickles."""

import struct
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray
from scipy.io import loadmat
from scipy.io.matlab import MatReadError

from fe_models.arrays import FloatArray
from fe_models.errors import InputError, raise_faults

READABLE_SUFFIXES = (".npz", ".mat", ".csv")
SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs"}  # the first where a header has as many of several
MAX_FAULTY_LINES = 5  # of a file, each with its fault
BROKEN_FILE = (
    BadZipFile,
    MatReadError,
    ValueError,
    TypeError,
    LookupError,
    ArithmeticError,
    EOFError,
    MemoryError,
    zlib.error,
    struct.error,
)
"""What NumPy and SciPy raise on files that are truncated, corrupt or of another format."""


def load_arrays(path: Path) -> dict[str, NDArray[np.generic]]:
    """Return the arrays of an .npz or .mat file by name; those of Python objects or MATLAB structs are left out."""
    check_exists(path)
    try:
        content = _load_npz(path) if path.suffix == ".npz" else loadmat(path)
    except NotImplementedError:
        raise InputError(f"{path}: MATLAB 7.3 file (HDF5), which is not read; save it with '-v7'") from None
    except BROKEN_FILE as error:
        raise InputError(f"{path}: not a readable {path.suffix} file ({_first_line(error)})") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or _first_line(error)})") from None
    arrays = {name: value for name, value in content.items() if isinstance(value, np.ndarray)}
    return {name: value for name, value in arrays.items() if not value.dtype.hasobject}


def pick_array(arrays: dict[str, NDArray[np.generic]], key: str | None, where: str) -> FloatArray:
    """Return one of ``arrays`` as floats; `InputError` names those present."""
    names = list(arrays)
    if not names:
        raise InputError(f"{where}: holds no plain array (pickled Python objects and MATLAB structs are not read)")
    if key is None and len(names) > 1:
        raise InputError(f"{where}: holds several arrays ({', '.join(names)}); say which with key")
    name = names[0] if key is None else key
    if name not in arrays:
        raise InputError(f"{where}: holds no plain array {name!r}; it has {', '.join(names)}")
    array = arrays[name]
    if array.dtype.kind not in "iuf":
        raise InputError(f"{where}: array {name!r} holds {array.dtype}, not real numbers")
    return array.astype(float)


@dataclass(frozen=True)
class CsvTable:
    """The cells of a .csv file: the ``header`` of its columns; line number and cells of each of its rows.

    ``form``: in words, how it is not one of commas and decimal points alone.
    """

    path: Path
    header: list[str]
    rows: list[tuple[int, list[str]]]
    form: str = ""

    def numbers(self, columns: Sequence[int]) -> FloatArray:
        """Return the numbers (row, column) of ``columns``, counted from 0; `InputError` names the lines without one."""
        cells = [(line, [row[column] for column in columns]) for line, row in self.rows]
        words = [(line, cell) for line, row in cells for cell in row if not _is_number(cell)]
        _raise_faults_of_lines(self.path, [f"line {line}: {cell!r} is not a number" for line, cell in words])
        return np.array([[float(cell) for cell in row] for _, row in cells])


def load_csv(path: Path) -> CsvTable:
    """Return the cells of a .csv file; `InputError` carries all faults.

    It is separated by commas, or by semicolons or tabs where its header has more of these; only then numbers may have
    decimal commas. Empty lines are skipped, and comments, which begin with "#". So are empty columns and rows at its
    end, which spreadsheets and loggers leave there.
    """
    check_exists(path)
    try:
        text = path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: not UTF-8 text (byte {error.start})") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror})") from None
    written = [(number, line) for number, line in enumerate(text.splitlines(), start=1) if line.strip()]
    lines = [(number, line) for number, line in written if not line.lstrip().startswith("#")]
    mark = _separator(lines[0][1] if lines else "")
    cells = [(number, [cell.strip().strip('"') for cell in line.split(mark)]) for number, line in lines]
    form = ["with lines of comment, which are skipped"] if len(lines) < len(written) else []
    if mark != ",":
        form.insert(0, f"separated by {SEPARATORS[mark]}")
        if _has_decimal_commas(cells[1:]):
            cells[1:] = [(number, [cell.replace(",", ".") for cell in row]) for number, row in cells[1:]]
            form.insert(1, "with decimal commas")
    while cells and not any(cells[-1][1]):
        cells.pop()
    if len(cells) < 2:
        raise InputError(f"{path}: expected a header line and rows of numbers, found {len(cells)} lines")
    raise_faults(_without_header(path, *cells[0]))
    width = max(_filled(row) for _, row in cells)
    (_, header), *rows = [(number, row[:width]) for number, row in cells]
    uneven = [(number, len(row)) for number, row in rows if len(row) != len(header)]
    faults = [f"line {number} has {values} values, the header {len(header)}" for number, values in uneven]
    _raise_faults_of_lines(path, faults)
    return CsvTable(path, header, rows, ", ".join(form))


def _separator(header: str) -> str:
    """Return what separates the names of a header: a comma, or the other mark of which it has more."""
    return max(SEPARATORS, key=header.count)


def _has_decimal_commas(rows: Sequence[tuple[int, list[str]]]) -> bool:
    """Whether cells have commas in their numbers and none has a point, which might part thousands."""
    cells = [cell for _, row in rows for cell in row]
    return any("," in cell for cell in cells) and not any("." in cell for cell in cells)


def _filled(row: list[str]) -> int:
    """Return the number of cells up to the last that holds something."""
    return max((column for column, cell in enumerate(row, start=1) if cell), default=0)


def _raise_faults_of_lines(path: Path, faults: list[str]) -> None:
    """Raise those of a file's lines, a whole column of which may have one: the first few, and how many more."""
    lines = [f"{path}: {fault}" for fault in faults[:MAX_FAULTY_LINES]]
    more = len(faults) - len(lines)
    raise_faults(lines + ([f"{path}: and {more} more of that kind"] if more else []))


def _without_header(path: Path, number: int, first: list[str]) -> list[str]:
    """Return what is wrong with a first line, of that number, that names no columns."""
    if all(map(_is_number, first[: _filled(first)])):
        return [
            f"{path}: line {number} holds numbers; expected a header line with a name for each column before them (a "
            "number that is a name needs a letter)"
        ]
    return []


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def check_exists(path: Path) -> None:
    """Raise `InputError` unless ``path`` is a file of a readable kind."""
    if path.suffix not in READABLE_SUFFIXES:
        raise InputError(f"{path}: unknown kind of file {path.suffix!r}; expected {', '.join(READABLE_SUFFIXES)}")
    if not path.is_file():
        raise InputError(f"{path}: {'is a folder' if path.is_dir() else 'no such file'}{_neighbours(path)}")


def _neighbours(path: Path) -> str:
    """Return a hint with the files of that kind that are there instead."""
    names = sorted(other.name for other in path.parent.glob(f"*{path.suffix}")) if path.parent.is_dir() else []
    return f"; the folder has {', '.join(names[:5])}{', ...' if len(names) > 5 else ''}" if names else ""


def _load_npz(path: Path) -> dict[str, NDArray[np.generic]]:
    """Return the arrays of an archive, without those that only unpickling, and so running code, could read."""
    arrays: dict[str, NDArray[np.generic]] = {}
    with path.open("rb") as file:  # opened here, so that it is closed where NumPy gives up
        archive = np.load(file, allow_pickle=False)
        if isinstance(archive, np.ndarray):
            raise ValueError("a single .npy array; save it with numpy.savez")
        for name in archive.files:
            try:
                arrays[name] = archive[name]
            except ValueError as error:
                if "allow_pickle" not in str(error):
                    raise
    return arrays


def _first_line(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]
