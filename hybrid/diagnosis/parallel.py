"""Work on independent items on two cores: compiled code and linear algebra let threads run side by side."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from typing import TypeVar

from fe_models.progress import nothing
from hybrid.diagnosis.config import THREADS

Item = TypeVar("Item")
Result = TypeVar("Result")


def parallel_map(
    function: Callable[[Item], Result], items: Iterable[Item], advance: Callable[[], object] = nothing
) -> list[Result]:
    """Return the results for all ``items``, in their order; NumPy's error state is the caller's.

    ``advance`` is called, by the caller's thread, as each result comes.
    """
    known, found = list(items), []
    if len(known) == 1:  # which needs no thread
        found.append(function(known[0]))
        advance()
        return found
    pool = ThreadPoolExecutor(THREADS.motions)
    try:
        for task in [pool.submit(copy_context().run, function, item) for item in known]:
            found.append(task.result())
            advance()
    finally:
        pool.shutdown(cancel_futures=True)  # what fails, or Ctrl-C, must not wait for items that nobody has begun
    return found


def in_chunks(items: Sequence[Item]) -> Iterator[Sequence[Item]]:
    """Yield the items as many at a time as go side by side."""
    for first in range(0, len(items), THREADS.motions):
        yield items[first : first + THREADS.motions]
