"""How much a file may hold: what is claimed beyond that is refused before any of it is read."""

from pathlib import Path
from stat import S_ISDIR, S_ISREG

from fe_models.errors import InputError

MAX_VALUES = 2**27
"""Numbers of one file that are read: 1 GiB in memory, 16 channels at 100 Hz for nearly a day; copies fit into 4 GB."""
MAX_BYTES = 8 * MAX_VALUES
REMEDY = "cut it into parts, or keep fewer channels, or resample it to a lower rate"


def check_values(count: int, where: str | Path) -> None:
    """Raise `InputError` where a file claims to hold more than `MAX_VALUES` numbers."""
    if count > MAX_VALUES:
        raise InputError(f"{where}: announces {count:.3g} numbers, and at most {MAX_VALUES:.3g} are read: {REMEDY}")


def check_bytes(count: int, where: str | Path) -> None:
    """Raise `InputError` where a file has, or claims to unpack to, more than `MAX_BYTES`."""
    if count > MAX_BYTES:
        gib = 2**30
        raise InputError(
            f"{where}: holds {count / gib:.3g} GiB, and at most {MAX_BYTES / gib:.3g} GiB are read: {REMEDY}"
        )


NO_FILE = "no such file"


def require_file(path: Path) -> None:
    """Raise `InputError` unless ``path`` is a plain file: a pipe or a device may never end."""
    fault = file_fault(path)
    if fault:
        raise InputError(f"{path}: {fault}")


def file_fault(path: Path) -> str:
    """Return why ``path`` is no file that can be read, nothing where it is one."""
    try:
        mode = path.stat().st_mode
    except (FileNotFoundError, NotADirectoryError, ValueError):  # of a name with a NUL
        return NO_FILE
    except OSError as error:
        return f"cannot be read ({error.strerror})"
    if S_ISREG(mode):
        return ""
    return f"cannot be read (is {'a folder' if S_ISDIR(mode) else 'no plain file'})"
