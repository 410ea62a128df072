"""The one exception for bad input: it carries every fault of that input, one line each."""

import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")

BAD_INPUT_STATUS = 2


class InputError(ValueError):
    """Input that cannot be used. ``faults`` holds one sentence a fault: what is wrong, where, what was expected."""

    def __init__(self, faults: str | Iterable[str]) -> None:
        self.faults: tuple[str, ...] = (faults,) if isinstance(faults, str) else tuple(faults)
        super().__init__("\n".join(self.faults))


def raise_faults(faults: Iterable[str]) -> None:
    """Raise one `InputError` with all ``faults``, or nothing when there are none."""
    lines = tuple(faults)
    if lines:
        raise InputError(lines)


def noting(faults: list[str], where: str, read: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T | None:
    """Return ``read(...)``; where it raises an `InputError`, note its faults, led by ``where``, and return None."""
    try:
        return read(*args, **kwargs)
    except InputError as error:
        faults.extend(f"{where}: {fault}" if where else fault for fault in error.faults)
        return None


@contextmanager
def bad_input_exits() -> Iterator[None]:
    """Turn an `InputError` inside the block into one ``error: ...`` line a fault on stderr and exit status 2.

    What was added to it (`BaseException.add_note`) follows as ``note: ...``.
    """
    try:
        yield
    except InputError as error:
        for fault in error.faults:
            print("error:", " ".join(fault.splitlines()), file=sys.stderr)
        for note in getattr(error, "__notes__", ()):
            print("note:", note, file=sys.stderr)
        raise SystemExit(BAD_INPUT_STATUS) from None
