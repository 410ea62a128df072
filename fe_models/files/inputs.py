"""Which files a run reads, as named by a dataset or model file before it is checked."""

from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from fe_models.errors import InputError
from fe_models.files.tables import Table, read_toml


def files_read(*paths: Path) -> tuple[Path, ...]:
    """Return ``paths`` and every file that the TOML files among them name, directly or in turn.

    Every text in a TOML file that is the name of a file, relative to it, counts, whatever its key: the model, its
    matrices, recordings, loads, modal models. Faults are left to those who read the files.
    """
    found, waiting = dict[Path, None](), list(paths)
    while waiting:
        path = waiting.pop()
        if path in found:
            continue
        found[path] = None
        if path in paths or path.suffix.lower() == ".toml":
            waiting += [path.parent / text for text in _texts(_document(path)) if _is_file(path.parent, text)]
    return tuple(found)


def _document(path: Path) -> Table:
    with suppress(InputError):
        return read_toml(path)
    return {}


def _texts(content: object) -> Iterator[str]:
    if isinstance(content, str):
        yield content
    elif isinstance(content, dict | list):
        for item in content.values() if isinstance(content, dict) else content:
            yield from _texts(item)


def _is_file(folder: Path, text: str) -> bool:
    with suppress(OSError, ValueError):  # of texts that are no path, such as one too long, or with a NUL
        return (folder / text).is_file()
    return False
