"""What is watched: a folder into which recordings come, and a dataset file that says how they are to be read."""

import hashlib
import json
import os
from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from fe_models.errors import InputError
from fe_models.files.array_files import READABLE_SUFFIXES
from fe_models.files.atomic import write_text
from fe_models.files.dataset_file import load_dataset
from fe_models.files.inputs import files_read
from fe_models.files.models import load_model
from fe_models.files.tables import read_toml
from fe_models.files.toml_text import toml_text
from fe_models.recordings import Dataset

READ_BY = {  # keys of the dataset file, and what each says
    "sensors": "list of sensors",
    "sampling_rate": "sampling rate",
    "lowpass": "low-pass frequency",
}
OF_RECORDINGS = ("name", "role", "file")  # what each recording has of its own
Table = dict[str, Any]


@dataclass(frozen=True)
class Arrived:
    """A recording ``file`` in the folder, by its ``name``, written last at ``modified`` (ns since 1970)."""

    name: str
    file: Path
    modified: int


@dataclass(frozen=True)
class Station:
    """The ``folder`` that is watched, and the ``document`` of the dataset file, all files in it by absolute names."""

    folder: Path
    document: Table

    @property
    def digests(self) -> dict[str, str]:
        """The SHA-256 of each thing that recordings are read by, whatever folder it lies in."""
        name = str(self.document["model"])
        model = hashlib.sha256(b"" if Path(name).is_file() else name.encode())  # of a built-in one
        for file in files_read(Path(name)):
            if file.is_file():
                model.update(file.read_bytes())
        values = {name: self.document.get(key) for key, name in READ_BY.items()}
        texts = {name: json.dumps(value, sort_keys=True, default=str) for name, value in values.items()}
        return {
            "model": model.hexdigest(),
            **{name: hashlib.sha256(text.encode()).hexdigest() for name, text in texts.items()},
        }

    def key(self, file: Path) -> str:
        """Return how a ``file`` is known: relative to the folder where it is within, so that this may be moved."""
        return file.relative_to(self.folder).as_posix() if file.is_relative_to(self.folder) else str(file)

    def path(self, key: str) -> Path:
        """Return the file that is known by a ``key``."""
        return self.folder / key

    @property
    def listed(self) -> list[Arrived]:
        """The recordings that the dataset file names, in its order: the beginning of the history."""
        found = list[Arrived]()
        for table in self.document["recordings"]:
            file, name = Path(table["file"]), str(table["name"])
            try:
                found.append(_arrived(file, name))
            except InputError:  # archived, or not there yet: who reads it says so
                found.append(Arrived(name, file, 0))
        return found

    def arrived(self, settled: float, now: float) -> list[Arrived]:
        """Return the other recording files in the folder, the oldest first.

        Those that were written to in the last ``settled`` s before ``now`` (s since 1970) may not be whole yet.
        """
        known = {own.file for own in self.listed} | _files_of(self.document)
        found = list[Arrived]()
        for path in self.folder.iterdir():
            if path.suffix.lower() in READABLE_SUFFIXES and not path.name.startswith(".") and path.is_file():
                with suppress(InputError):  # renamed or removed meanwhile, as loggers do
                    found.append(_arrived(path.absolute(), path.stem))
        whole = [own for own in found if own.file not in known and now - own.modified / 1e9 >= settled]
        return sorted(whole, key=lambda own: (own.modified, own.name))

    def dataset(self, recordings: Sequence[Arrived]) -> Dataset:
        """Return the dataset of some recordings; `InputError` carries all faults."""
        with TemporaryDirectory() as folder:
            path = Path(folder) / "dataset.toml"
            self.write(path, recordings)
            return load_dataset(path)

    def write(self, path: Path, recordings: Iterable[Arrived]) -> None:
        """Write the dataset file of some recordings."""
        tables = {table["file"]: table for table in self.document["recordings"]}
        own = [tables.get(str(each.file)) or self._as_the_first(each) for each in recordings]
        own = [table | {"name": each.name, "role": "train"} for table, each in zip(own, recordings, strict=True)]
        write_text(path, toml_text(self.document | {"recordings": own}))

    def _as_the_first(self, own: Arrived) -> Table:
        """Return the table of a recording that is read as the first one listed is, with its loads in its own file."""
        first = self.document["recordings"][0]
        table = {key: value for key, value in first.items() if key not in OF_RECORDINGS}
        return _with(table, first["file"], str(own.file)) | {"file": str(own.file)}


def load_station(folder: Path, file: Path | None = None, has_begun: bool = False) -> Station:
    """Return what is to be watched in a ``folder``, by its ``dataset.toml`` or another ``file``.

    `InputError` where that does not say how to read a recording, or one that it names cannot be read, unless the watch
    ``has_begun``: recordings may be archived then.
    """
    path = file or folder / "dataset.toml"
    if not folder.is_dir():
        raise InputError(f"{folder}: no such folder; give the one into which recordings come")
    try:
        document = read_toml(path)
    except InputError as error:
        error.add_note("the dataset file says which sensors made the recordings; hybrid-modal inspect writes one")
        raise
    if has_begun:  # what else it says is as it was then, or its digests tell
        _check_still_there(document, path)
    else:
        load_dataset(path)  # which says all that is wrong with it
    if not document.get("recordings"):
        raise InputError(f"{path}: names no recordings; one at least shows how new ones are to be read")
    home = path.parent.absolute()
    whole = _with_whole_paths({key: value for key, value in document.items() if key != "modes"}, home)
    for table in whole["recordings"]:
        table["file"] = os.path.normpath(home / table["file"])  # also of one that is not there
    return Station(Path(os.path.normpath(folder.absolute())), whole)


def _check_still_there(document: Table, path: Path) -> None:
    """Raise `InputError` unless a dataset file names a model that can be read, and the name and file of recordings."""
    load_model(str(document.get("model", "")), path.parent)
    tables = document.get("recordings")
    rows = tables if isinstance(tables, list) else [tables]
    if not all(isinstance(row, dict) and {"name", "file"} <= row.keys() for row in rows):
        raise InputError(f"{path}: each of [[recordings]] needs a name and a file")


def _arrived(file: Path, name: str) -> Arrived:
    try:
        return Arrived(name, file, file.stat().st_mtime_ns)
    except OSError as error:
        raise InputError(f"{file}: cannot be read ({os.strerror(error.errno or 0)})") from error


def _with_whole_paths(value: Any, folder: Path) -> Any:
    """Return a value of a TOML file in ``folder``, texts in it that name files made absolute."""
    if isinstance(value, dict):
        return {key: own if key == "name" else _with_whole_paths(own, folder) for key, own in value.items()}
    if isinstance(value, list):
        return [_with_whole_paths(own, folder) for own in value]
    if isinstance(value, str) and len(value) < 1000 and "\0" not in value and (folder / value).is_file():
        return str(folder / value)
    return value


def _with(value: Any, old: str, new: str) -> Any:
    """Return a value in which texts that are ``old`` are ``new``."""
    if isinstance(value, dict):
        return {key: _with(own, old, new) for key, own in value.items()}
    if isinstance(value, list):
        return [_with(own, old, new) for own in value]
    return new if value == old else value


def _files_of(value: Any) -> set[Path]:
    """Return the paths of all files that a document names."""
    if isinstance(value, dict):
        return set().union(*(_files_of(own) for own in value.values()))
    if isinstance(value, list):
        return set().union(*(_files_of(own) for own in value))
    return {Path(value)} if isinstance(value, str) and value.startswith(os.sep) else set()
