"""Progress of what takes long: bars for whoever sits at a terminal."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

from tqdm import tqdm

DELAY = 1.0  # s; what is done sooner shows no bar
STAGES = "{desc} |{bar:24}| {n_fmt} of {total_fmt} stages done [{elapsed}]"

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


def progress_bar(what: str, total: int, unit: str = "step", *, done: int = 0, shown: bool | None = None) -> Any:
    """Return a bar on stderr that goes with `update` to its ``total``, of which ``done`` are done already.

    A context manager, with tqdm's methods. It shows itself where stderr is a terminal, or as ``shown`` says, and never
    within `silent`.
    """
    return tqdm(total=total, initial=done, disable=_is_hidden(shown), desc=what, unit=unit, delay=DELAY, leave=False)


@contextmanager
def stage_bar(stages: Sequence[str], shown: bool | None = None) -> Iterator[Callable[[str], None]]:
    """Show a bar of ``stages`` that take very different times, so that it foretells none.

    Gives what hears the name of each as it begins, and any other words for a step within it.
    """
    with tqdm(total=len(stages), disable=_is_hidden(shown), desc=stages[0], bar_format=STAGES, leave=False) as bar:
        steps = -1  # what comes before the first stage is no step of one

        def begin(what: str) -> None:
            nonlocal steps
            steps += 1
            if what in stages:
                steps = 0
                bar.update(stages.index(what) - bar.n)
            bar.set_description_str(f"{what}, step {steps}" if steps else what)

        yield begin


def _is_hidden(shown: bool | None) -> bool | None:
    """Return tqdm's word for it, None: where there is no terminal."""
    return True if _quiet.get() else None if shown is None else not shown
