"""Arrays of numbers from .npz, .npy and .mat files (all versions). Nothing in a file is executed: no pickles."""

import struct
import zlib
from collections.abc import Mapping
from contextlib import suppress
from glob import escape
from pathlib import Path
from tokenize import TokenError
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray
from scipy.io.matlab import MatReadError

from fe_models.arrays import FloatArray
from fe_models.errors import InputError
from fe_models.files.matlab_files import load_mat
from fe_models.files.numpy_files import load_npy, load_npz
from fe_models.files.size_limit import NO_FILE, file_fault

LOADERS = {".npz": load_npz, ".npy": load_npy, ".mat": load_mat}
TEXT_SUFFIXES = (".csv", ".txt")
UNIVERSAL_SUFFIXES = (".uff", ".unv", ".bunv")
TDMS_SUFFIXES = (".tdms",)
READABLE_SUFFIXES = (*LOADERS, *TEXT_SUFFIXES, *UNIVERSAL_SUFFIXES, *TDMS_SUFFIXES)
BROKEN_FILE = (
    BadZipFile,
    MatReadError,
    NotImplementedError,
    RuntimeError,
    ValueError,
    TypeError,
    LookupError,
    ArithmeticError,
    EOFError,
    MemoryError,
    zlib.error,
    struct.error,
    RecursionError,
    SyntaxError,
    TokenError,
)
"""What NumPy, SciPy and h5py raise on files that are truncated, corrupt or of another format."""


class Arrays(dict[str, NDArray[np.generic]]):
    """The arrays of numbers in a file by name; ``others``: what the members are that it holds beside."""

    def __init__(self, arrays: Mapping[str, NDArray[np.generic]], others: Mapping[str, str]) -> None:
        super().__init__(arrays)
        self.others = dict(others)


def load_arrays(path: Path) -> Arrays:
    """Return the arrays of an .npz, .npy or .mat file by name; what else it holds is named, and not read."""
    check_exists(path, tuple(LOADERS))
    suffix = path.suffix.lower()
    try:
        return Arrays(*LOADERS[suffix](path))
    except InputError:
        raise
    except BROKEN_FILE as error:
        raise InputError(f"{path}: not a readable {suffix} file ({_first_line(error)})") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or _first_line(error)})") from None


def pick_array(arrays: Mapping[str, NDArray[np.generic]], key: str | None, where: str) -> FloatArray:
    """Return one of ``arrays`` as floats; `InputError` names those present."""
    names, others = list(arrays), getattr(arrays, "others", {})
    beside = "; ".join(f"{name!r} is {what}, which is not read" for name, what in others.items())
    if not names:
        raise InputError(f"{where}: holds no plain array{f' ({beside})' if beside else ''}")
    if key is None and len(names) > 1:
        raise InputError(f"{where}: holds several arrays ({', '.join(names)}); say which with key")
    name = names[0] if key is None else key
    if name in others:
        raise InputError(
            f"{where}: no plain array {name!r}: it is {others[name]}, which is not read; it has {', '.join(names)}"
        )
    if name not in arrays:
        raise InputError(f"{where}: holds no plain array {name!r}; it has {', '.join(names)}")
    array = arrays[name]
    if array.dtype.kind not in "iuf":
        raise InputError(f"{where}: array {name!r} holds {array.dtype}, not real numbers")
    return array.astype(float)


def check_exists(path: Path, suffixes: tuple[str, ...] = READABLE_SUFFIXES) -> None:
    """Raise `InputError` unless ``path`` is a file of a readable kind."""
    if path.suffix.lower() not in suffixes:
        raise InputError(f"{path}: unknown kind of file {path.suffix!r}; expected {', '.join(suffixes)}")
    fault = file_fault(path)
    if fault:
        raise InputError(f"{path}: {fault}{_neighbours(path) if fault == NO_FILE else ''}")


def _neighbours(path: Path) -> str:
    """Return a hint with the files of that kind that are there instead."""
    names = list[str]()
    with suppress(OSError, ValueError):
        names = sorted(other.name for other in path.parent.glob(f"*{escape(path.suffix)}"))
    return f"; the folder has {', '.join(names[:5])}{', ...' if len(names) > 5 else ''}" if names else ""


def _first_line(error: Exception) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]
