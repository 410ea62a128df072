"""What a command holds while it runs: the folders that it alone may write into, and the digests of what it read.

A lock is the operating system's own, on a file beside no one's results: it goes with the process, however that ends.
"""

import fcntl
import hashlib
import os
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass, field
from pathlib import Path

from fe_models.errors import InputError
from fe_models.files.result_list import digest


@dataclass
class RunGuard:
    """Open lock files by folder, and the digest of each input when the run began."""

    locks: dict[Path, int] = field(default_factory=dict)
    digests: dict[Path, str] = field(default_factory=dict)

    def changed(self) -> list[Path]:
        """Return the inputs that are no longer what they were."""
        return [path for path, known in self.digests.items() if digest(path) != known]


_guard: ContextVar[RunGuard | None] = ContextVar("guard", default=None)


@contextmanager
def guarded() -> Iterator[RunGuard]:
    """Hold, until the block ends, what `lock_folder` and `remember` are told."""
    guard = RunGuard()
    token = _guard.set(guard)
    try:
        yield guard
    finally:
        _guard.reset(token)
        for lock in guard.locks.values():
            os.close(lock)


def lock_folder(folder: Path) -> None:
    """Keep other runs from writing into ``folder``; `InputError` where one does. Nothing outside `guarded`."""
    guard, own = _guard.get(), folder.absolute().resolve()
    if guard is None or own in guard.locks:
        return
    try:
        home = Path(tempfile.gettempdir(), f"hybrid-modal-{os.getuid()}")
        home.mkdir(mode=0o700, exist_ok=True)
        lock = os.open(home / hashlib.sha256(os.fsencode(own)).hexdigest()[:32], os.O_RDWR | os.O_CREAT, 0o600)
    except OSError:  # where no locks can be kept, folders have none
        return
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(lock)
        raise InputError(
            f"{folder}: another run writes into this folder now; wait for its end, or give another folder"
        ) from None
    except OSError:
        os.close(lock)
        return
    guard.locks[own] = lock


def remember(inputs: Iterable[Path]) -> None:
    """Note what ``inputs`` hold now. Nothing outside `guarded`."""
    guard = _guard.get()
    if guard is None:
        return
    for path in inputs:
        with suppress(OSError, ValueError):  # whoever reads it says what is wrong
            guard.digests.setdefault(path, digest(path))


def remembered(path: Path) -> str | None:
    """Return the digest that a file had when the run began, None where it is not known."""
    guard = _guard.get()
    return None if guard is None else guard.digests.get(path)
