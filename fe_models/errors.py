"""The one exception for bad input: it carries every fault of that input, one line each.

Whatever a file or an option holds, a message stays short, and holds nothing that a terminal would obey.
"""

import sys
import unicodedata
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")

BAD_INPUT_STATUS = 2
FAILED_STATUS = 1
MOST_FAULTS = 50  # that one error lists: nobody reads more at once
MOST_CHARACTERS = 1200  # of a fault; the longest that this program writes by itself has half of that
LEFT_OUT = " [...] "


class InputError(ValueError):
    """Input that cannot be used. ``faults`` holds one sentence a fault: what is wrong, where, what was expected.

    Of very many faults the first are kept, and how many more there are; each is made `printable`.
    """

    status = BAD_INPUT_STATUS

    def __init__(self, faults: str | Iterable[str]) -> None:
        lines = (faults,) if isinstance(faults, str) else tuple(faults)
        more = len(lines) - MOST_FAULTS
        kept = tuple(printable(line) for line in lines[:MOST_FAULTS])
        self.faults: tuple[str, ...] = (*kept, f"and {more} more faults") if more > 0 else kept
        super().__init__("\n".join(self.faults))

    def __reduce__(self) -> tuple[type["InputError"], tuple[tuple[str, ...]]]:
        return type(self), (self.faults,)  # on its way from another process


class OutputError(InputError):
    """Results that could not be written, whatever the input: a full disk, say."""

    status = FAILED_STATUS


def printable(text: str, most: int = MOST_CHARACTERS) -> str:
    """Return ``text`` in one line of at most ``most`` characters, its middle left out, and control codes spelt out."""
    text = _shortened(text, most)
    if text.isprintable():
        return text
    return _shortened("".join(_spelt_out(character) for character in " ".join(text.splitlines())), most)


def _shortened(text: str, most: int) -> str:
    if len(text) <= most:
        return text
    end = (most - len(LEFT_OUT)) // 3  # where a message says what was expected
    return text[: most - len(LEFT_OUT) - end] + LEFT_OUT + text[len(text) - end :]


def _spelt_out(character: str) -> str:
    return repr(character)[1:-1] if unicodedata.category(character).startswith("C") else character


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
    """Turn an `InputError` inside the block into one ``error: ...`` line a fault on stderr and its exit status, 2.

    What was added to it (`BaseException.add_note`) follows as ``note: ...``.
    """
    try:
        yield
    except InputError as error:
        for fault in error.faults:
            print("error:", fault, file=sys.stderr)
        for note in getattr(error, "__notes__", ()):
            print("note:", note, file=sys.stderr)
        raise SystemExit(error.status) from None
