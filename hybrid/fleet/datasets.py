"""Of which datasets a fleet is, and how they are called."""

import tomllib
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

from fe_models.errors import InputError, raise_faults

PARTS = {"sensors", "recordings", "modes"}
"""Tables of which a dataset has one at least, and no file of a structure any."""


def is_fleet(paths: Sequence[Path]) -> bool:
    """Return whether paths ask for a fleet: several, or a folder."""
    return len(paths) > 1 or any(path.is_dir() for path in paths)


def dataset_files(paths: Iterable[Path], out: Path) -> list[Path]:
    """Return the dataset files among ``paths``, and those of folders and all folders within, each once.

    What was written into ``out`` is left alone. A file in a folder that is not valid TOML is taken for a dataset, whose
    fault is then told. `InputError` names the paths that are not there, and folders without any dataset.
    """
    found, faults = dict[Path, Path](), list[str]()
    for path in paths:
        if not path.exists():
            faults.append(f"{path}: no such file or folder")
            continue
        own = _in_folder(path, out.resolve()) if path.is_dir() else [path]
        if not own:
            faults.append(f"{path}: no dataset in this folder or those within it; a dataset file names sensors")
        for file in own:
            found.setdefault(file.resolve(), file)
    raise_faults(faults)
    return list(found.values())


def names_of(files: Sequence[Path]) -> list[str]:
    """Return a name for each file, by its own path as far as that tells it from the others.

    A file ``dataset.toml`` is called as its folder. Where two would be called alike, the folders above join in.
    """
    parts = [_parts(file) for file in files]
    depth = [1] * len(files)
    while True:
        names = ["-".join(own[-count:]) for own, count in zip(parts, depth, strict=True)]
        alike = {name for name, times in Counter(names).items() if times > 1}
        longer = [
            count + (name in alike and count < len(own)) for own, count, name in zip(parts, depth, names, strict=True)
        ]
        if longer == depth:
            return _numbered(names)
        depth = longer


def _parts(file: Path) -> list[str]:
    """Return the words that tell a file, the most telling last."""
    whole = file.resolve()
    folders = [part for part in whole.parent.parts if part != whole.anchor]
    return folders if whole.stem == "dataset" and folders else [*folders, whole.stem]


def _numbered(names: Sequence[str]) -> list[str]:
    """Return names of which each is another: "a/b.toml" and "a-b.toml" are alike whatever joins in."""
    seen, found = Counter[str](), list[str]()
    for name in names:
        seen[name] += 1
        found.append(name if seen[name] == 1 else f"{name}-{seen[name]}")
    if len(set(found)) < len(found):
        raise InputError("datasets whose names differ by numbers alone: rename their folders")
    return found


def _in_folder(folder: Path, out: Path) -> list[Path]:
    files = sorted(folder.rglob("*.toml"))
    return [file for file in files if not _is_hidden(file.relative_to(folder)) and _is_dataset(file, out)]


def _is_hidden(path: Path) -> bool:
    return any(part.startswith(".") for part in path.parts)


def _is_dataset(file: Path, out: Path) -> bool:
    if not file.is_file() or file.resolve().is_relative_to(out):
        return False
    try:
        with file.open("rb") as opened:
            content = tomllib.load(opened)
    except (OSError, ValueError, RecursionError):
        return True
    return bool(PARTS & content.keys())
