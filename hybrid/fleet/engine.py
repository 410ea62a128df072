"""Tasks done once each, whatever interrupts: what is kept is not done again, what is new is kept as it comes.

Who is killed in between loses the tasks in work, one a worker, and nothing else.
"""

from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from time import monotonic
from typing import Protocol, TypeVar

TICK = 1.0  # s: how often who waits is told so

Task = TypeVar("Task")
Result = TypeVar("Result")
Given = TypeVar("Given", covariant=True)
Record = TypeVar("Record")


class Answer(Protocol[Given]):
    """What became of a task: a future that is done."""

    def result(self) -> Given:
        """Return the result, or raise what the work raised, or what ended it."""


Answers = Generator[tuple[Task, Answer[Result]], None, None]
"""Each task with its answer, whichever is ready first."""


def completed(
    tasks: Sequence[Task],
    there: Mapping[Task, Record],
    answers: Callable[[Iterator[Task]], Answers[Task, Result]],
    keep: Callable[[Task, Answer[Result]], Record],
    *,
    minutes: float | None = None,
    advance: Callable[[int, int], object] = lambda done, planned: None,
) -> dict[Task, Record]:
    """Return the record of each task: those that are ``there``, and what ``keep`` makes, and keeps, of each answer.

    ``answers`` works on the tasks that have no record yet, of which it takes one when it is free for it. After so many
    ``minutes`` none is begun, and those left have no record. ``advance`` is given how many records there are, of how
    many. What ``keep`` raises ends the work.
    """
    records = {task: there[task] for task in tasks if task in there}
    advance(len(records), len(tasks))
    missing = [task for task in tasks if task not in records]
    with closing(answers(_until(missing, minutes))) as coming:
        for task, answer in coming:
            records[task] = keep(task, answer)
            advance(len(records), len(tasks))
    return records


def _until(tasks: Iterable[Task], minutes: float | None) -> Iterator[Task]:
    """Give tasks until so many minutes have passed."""
    begun = monotonic()
    for task in tasks:
        if minutes is not None and monotonic() - begun >= 60 * minutes:
            return
        yield task
