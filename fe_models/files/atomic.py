"""Files written whole: into a temporary file beside the target, which then takes its place in one step.

Whatever interrupts the writing, the target holds either its old content or all of the new.
"""

import hashlib
import json
import os
import platform
import re
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from errno import ENAMETOOLONG
from pathlib import Path
from secrets import token_hex
from shutil import rmtree
from tempfile import mkdtemp
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from fe_models.errors import InputError, OutputError

MACHINE = hashlib.sha256(platform.node().encode()).hexdigest()[:4]
"""This machine in names of temporary files: others may write into a folder on a shared disk, too."""
TEMPORARY = re.compile(r"\..+-(\d{1,10})-([0-9a-f]{4})[0-9a-f]{4}(\.\w+)?$")
"""Names of the files that `writing` gives: the process that writes them is in them, and its machine."""
FORGOTTEN = 86_400.0  # s: what another machine has not touched for so long, no run of it is at
LONGEST_NAME = "x" * 48  # of a file among results, a temporary one


@contextmanager
def writing(path: Path) -> Iterator[Path]:
    """Give a temporary path to write to; it replaces ``path`` when the block ends well, and vanishes when it does not.

    The temporary path has the suffix of ``path``, from which figure and animation writers take the format. Folders are
    made as needed. Raises `InputError` where ``path`` cannot be written.
    """
    temporary = path.with_name(f".{path.stem}-{os.getpid()}-{own_token()}{path.suffix}")
    if path.is_dir():
        raise InputError(f"{path}: is a folder; give the name of a file to write")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{path}: its folder cannot be made ({error.strerror}); choose another") from error
    try:
        yield temporary
        with temporary.open("r+b") as file:
            os.fsync(file.fileno())
        temporary.replace(path)
    except OSError as error:
        reason = error.strerror or str(error)
        raise OutputError(f"{path}: cannot be written ({reason}); an older file of that name is as it was") from error
    finally:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)


def own_token() -> str:
    """Return eight letters for the name of a temporary file or folder: the first four are this `MACHINE`."""
    return MACHINE + token_hex(2)


def remove_left(folder: Path) -> None:
    """Remove from ``folder`` the temporary files of runs that were killed while they wrote."""
    for path in folder.glob(".*-*-*") if folder.is_dir() else ():
        left = TEMPORARY.match(path.name)
        with suppress(OSError):
            if left and is_of_no_other(path, left[2]) and (left[2] != MACHINE or not _is_alive(int(left[1]))):
                path.unlink()


def is_of_no_other(path: Path, token: str) -> bool:
    """Return whether something temporary, whose `own_token` is ``token``, is this machine's, or forgotten."""
    return token[:4] == MACHINE or time.time() - path.stat().st_mtime > FORGOTTEN


def _is_alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    except (OSError, OverflowError):  # it is somebody else's, or no process
        return True
    return True


def check_folder(path: Path) -> None:
    """Raise `InputError` where no results could be written into a folder ``path``, which need not be there yet."""
    if "\0" in str(path):
        raise InputError(f"{path}: is no name of a folder")
    there = path
    try:
        there = next((folder for folder in (path, *path.absolute().parents) if folder.exists()), path)
        if not there.is_dir():
            raise InputError(f"{path}: {there} is a file; give a folder for the results")
        missing = path.absolute().relative_to(there.absolute()).parts
        trial = Path(mkdtemp(prefix=".new-", dir=there))  # its rights say too little: think of /proc
        try:
            like_it = trial.joinpath(*missing)
            like_it.mkdir(parents=True, exist_ok=True)
            (like_it / LONGEST_NAME).touch()
        finally:
            rmtree(trial, ignore_errors=True)
    except OSError as error:
        if error.errno == ENAMETOOLONG:
            raise InputError(f"{path}: its name is too long; choose a shorter one") from None
        raise InputError(f"{path}: nothing can be written into {there}; choose another folder") from None


def write_text(path: Path, text: str) -> None:
    """Write ``text`` as UTF-8 with line ends as given."""
    with writing(path) as temporary:
        temporary.write_bytes(text.encode(errors="backslashreplace"))  # names of files need not be Unicode


def write_json(path: Path, content: Any) -> None:
    """Write ``content`` as indented JSON; NaN and infinity, which JSON lacks, raise `ValueError`."""
    write_text(path, json.dumps(content, indent=2, allow_nan=False, ensure_ascii=False) + "\n")


def write_npz(path: Path, arrays: Mapping[str, ArrayLike]) -> None:
    """Write named arrays, compressed; arrays of Python objects, which only pickle could store, raise `TypeError`."""
    plain = {name: np.asarray(array) for name, array in arrays.items()}
    objects = [name for name, array in plain.items() if array.dtype.hasobject]
    if objects:
        raise TypeError(f"arrays of Python objects cannot be saved: {', '.join(objects)}")
    with writing(path) as temporary, temporary.open("wb") as file:
        np.savez_compressed(file, allow_pickle=False, **plain)
