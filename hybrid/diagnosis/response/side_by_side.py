"""Work on independent items on two cores: compiled code and linear algebra let threads run side by side."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")

THREADS = 2  # each holds a core only while it works


def side_by_side(function: Callable[[Item], Result], items: Iterable[Item]) -> list[Result]:
    """Return the results for all ``items``, in their order; NumPy's error state is the caller's."""
    known = list(items)
    if len(known) < 2:
        return [function(item) for item in known]
    with ThreadPoolExecutor(THREADS) as pool:
        return [task.result() for task in [pool.submit(copy_context().run, function, item) for item in known]]


def by_twos(items: Sequence[Item]) -> Iterator[Sequence[Item]]:
    """Yield the items as many at a time as go side by side."""
    for first in range(0, len(items), THREADS):
        yield items[first : first + THREADS]
