"""Progress of what takes long: bars for whoever sits at a terminal."""

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

from tqdm import tqdm

DELAY = 1.0  # s; what is done sooner shows no bar

_quiet: ContextVar[bool] = ContextVar("quiet", default=False)


def nothing() -> None:
    """Do nothing: the progress of who does not want to see any."""


@contextmanager
def silent() -> Iterator[None]:
    """Show no progress within the block."""
    token = _quiet.set(True)
    try:
        yield
    finally:
        _quiet.reset(token)


def progress_bar(
    what: str, total: int | None = None, unit: str = "step", *, done: int = 0, shown: bool | None = None
) -> Any:
    """Return a bar on stderr that goes with `update` to its ``total``, of which ``done`` are done already.

    A context manager, with tqdm's methods. It shows itself where stderr is a terminal, or as ``shown`` says, and never
    within `silent`. ``total`` is None where nobody knows when the end comes.
    """
    hidden = True if _quiet.get() else None if shown is None else not shown  # None: where there is no terminal
    form = None if total is not None else "{desc} [{elapsed}]"  # no end, no rate
    looks = {"desc": what, "unit": unit, "bar_format": form, "delay": DELAY, "leave": False}
    return tqdm(total=total, initial=done, disable=hidden, **looks)
