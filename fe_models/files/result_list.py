"""The list of results that this program keeps in a folder: which command wrote which files, with their digests.

Only what stands there, unchanged, is ever replaced or removed (`result_set`); all else in a folder is the user's.
"""

import hashlib
import json
from pathlib import Path

from fe_models.errors import InputError
from fe_models.files.atomic import write_json

LIST_FILE = ".hybrid-modal.json"
UNFINISHED_FILE = ".unfinished.json"

Files = dict[str, str]
"""Names of files in a folder, each with the SHA-256 digest of its content."""


def read_list(folder: Path) -> dict[str, Files]:
    """Return the files that each command wrote into ``folder``; `InputError` where its list is none of ours."""
    path = folder / LIST_FILE
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        return {}
    except (OSError, ValueError) as error:
        raise _unusable(path) from error
    sets = content.get("results") if isinstance(content, dict) else None
    if not isinstance(sets, dict) or not all(_are_files(files) for files in sets.values()):
        raise _unusable(path)
    return sets


def write_list(folder: Path, sets: dict[str, Files], beside: Path) -> None:
    """Write the list of ``folder``, whole, by way of a file in ``beside``, where an interruption may leave it."""
    write_json(beside / UNFINISHED_FILE, {"schema": 1, "results": sets})
    (beside / UNFINISHED_FILE).replace(folder / LIST_FILE)


def digest(path: Path) -> str:
    """Return the SHA-256 digest of a file's content; of what is no file, nothing, which no list holds."""
    if not path.is_file():
        return ""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _are_files(files: object) -> bool:
    """Return whether these are plain names with digests: a name with a folder would reach beyond the list's own."""
    return isinstance(files, dict) and all(
        isinstance(value, str) and value and Path(name).name == name for name, value in files.items()
    )


def _unusable(path: Path) -> InputError:
    return InputError(f"{path}: is not the list of results that this program keeps; remove it, or give another folder")
