"""Arrays of .npz and .npy files. Their headers are checked before anything is read, and no pickle is opened."""

import warnings
from pathlib import Path
from typing import IO
from zipfile import ZipFile

import numpy as np
from numpy.typing import NDArray

from fe_models.errors import InputError
from fe_models.files.size_limit import check_bytes, check_values

PICKLE = "an array of Python objects (a pickle, which may run code)"


def load_npz(path: Path) -> tuple[dict[str, NDArray[np.generic]], dict[str, str]]:
    """Return the arrays of an archive by name, and what the members are that hold none of numbers."""
    arrays, others = dict[str, NDArray[np.generic]](), dict[str, str]()
    with ZipFile(path) as archive:
        members = [member for member in archive.infolist() if member.filename.endswith(".npy")]
        check_bytes(sum(member.file_size for member in members), path)
        for member in members:
            name = member.filename.removesuffix(".npy")
            with archive.open(member) as file:
                found = _read(file, member.file_size, f"{path}: {name!r}")
            if found is None:
                others[name] = PICKLE
            else:
                arrays[name] = found
    return arrays, others


def load_npy(path: Path) -> tuple[dict[str, NDArray[np.generic]], dict[str, str]]:
    """Return the array of an .npy file under the file's own name."""
    with path.open("rb") as file:
        found = _read(file, path.stat().st_size, str(path))
    return ({}, {path.stem: PICKLE}) if found is None else ({path.stem: found}, {})


def _read(file: IO[bytes], size: int, where: str) -> NDArray[np.generic] | None:
    """Return the array in ``size`` bytes, None for one of objects; `InputError` where its header claims more."""
    shape, fortran, dtype = _header(file)
    if dtype.hasobject:
        return None
    count = int(np.prod(shape, dtype=object))
    check_values(count, where)
    held = size - file.tell()
    if count * dtype.itemsize > held:
        raise InputError(f"{where}: is cut off: {count * dtype.itemsize} bytes are announced, and {held} are there")
    values = np.frombuffer(bytearray(file.read(count * dtype.itemsize)), dtype)  # a bytearray, to be written to
    return values.reshape(shape, order="F" if fortran else "C")


def _header(file: IO[bytes]) -> tuple[tuple[int, ...], bool, np.dtype[np.generic]]:
    version = np.lib.format.read_magic(file)
    read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # of files that Python 2 wrote: they are read all the same
        return read(file)
