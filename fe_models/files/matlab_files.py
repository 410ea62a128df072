"""Arrays of .mat files: of versions up to 7 by SciPy, of version 7.3, which are HDF5, by h5py.

Sizes are checked from what the file announces before anything is read. Nothing in it is executed: structs, cells,
objects and functions are named and left where they are.
"""

import struct
import zlib
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray
from scipy.io import loadmat, whosmat

from fe_models.files.size_limit import MAX_BYTES, check_bytes, check_values

INTEGERS = [f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)]
NUMERIC = frozenset({"double", "single", "logical", *INTEGERS})
"""MATLAB's classes of plain arrays."""
HDF5 = b"\x89HDF\r\n\x1a\n"
USER_BLOCK = 512  # bytes that MATLAB writes before HDF5's own beginning
HEADER_BYTES = 128  # of a file of version 5 to 7
TAG_BYTES = 8
COMPRESSED = 15  # the kind of an element that zlib has packed
CHUNK = 2**20

Found = tuple[dict[str, NDArray[np.generic]], dict[str, str]]


def load_mat(path: Path) -> Found:
    """Return the arrays of numbers in a .mat file by name, and what the others are."""
    with path.open("rb") as file:
        head = file.read(USER_BLOCK + len(HDF5))
    if head.startswith(HDF5) or head[USER_BLOCK:] == HDF5:
        return _load_hdf5(path)
    if not head:
        raise ValueError("it is empty")
    check_bytes(path.stat().st_size, path)
    if head[124:128] in (b"\x00\x01IM", b"\x01\x00MI"):
        with path.open("rb") as file:
            _check_unpacked(file, path, "<" if head[126:128] == b"IM" else ">")
    classes = {name: (shape, kind) for name, shape, kind in whosmat(path)}
    numeric = [name for name, (_, kind) in classes.items() if kind in NUMERIC]
    check_values(sum(int(np.prod(classes[name][0], dtype=object)) for name in numeric), path)
    content: dict[str, Any] = loadmat(path, variable_names=numeric) if numeric else {}
    arrays = {name: content[name] for name in numeric if isinstance(content.get(name), np.ndarray)}
    others = {name: f"a MATLAB {kind}" for name, (_, kind) in classes.items() if name not in arrays}
    return arrays, others


def _check_unpacked(file: BinaryIO, path: Path, order: str) -> None:
    """Raise `InputError` where the packed elements of a file hold more than `MAX_BYTES`, without keeping any of it."""
    total = 0
    file.seek(HEADER_BYTES)
    while len(tag := file.read(TAG_BYTES)) == TAG_BYTES:
        kind, size = struct.unpack(f"{order}II", tag)
        end = file.tell() + size
        if kind == COMPRESSED:
            unpack = zlib.decompressobj()
            while file.tell() < end and (packed := file.read(min(CHUNK, end - file.tell()))):
                while packed:
                    total += len(unpack.decompress(packed, CHUNK))
                    packed = unpack.unconsumed_tail
                    if total > MAX_BYTES:
                        check_bytes(total, path)
        file.seek(end)


def _load_hdf5(path: Path) -> Found:
    """Return the arrays at the top of an HDF5 file; as MATLAB stores columns first, they come turned."""
    import h5py  # nobody else waits for it

    arrays, others = dict[str, NDArray[np.generic]](), dict[str, str]()
    total = 0
    with h5py.File(path, "r") as file:
        for name in file:
            if name.startswith("#"):  # where MATLAB keeps what cells and structs refer to
                continue
            link = file.get(name, getlink=True)
            item = file.get(name) if isinstance(link, h5py.HardLink) else None
            if not isinstance(item, h5py.Dataset):
                others[name] = "a MATLAB struct" if isinstance(item, h5py.Group) else "a link to another file or place"
                continue
            kind = item.attrs.get("MATLAB_class", b"")
            word = kind.decode() if isinstance(kind, bytes) else str(kind)
            if item.dtype.kind not in "iufb" or (word and word not in NUMERIC):
                others[name] = f"a MATLAB {word or item.dtype}"
            elif item.is_virtual or item.external:
                others[name] = "data that stand in another file"
            else:
                total += item.size
                check_values(total, path)
                empty = bool(item.attrs.get("MATLAB_empty", 0))
                arrays[name] = np.zeros((0, 0)) if empty else np.asarray(item[()]).T
    return arrays, others
