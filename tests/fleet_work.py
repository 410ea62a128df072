"""What fleets of cheap tasks do in tests, in processes of their own: squares, slow ones, ones that break down."""

import os
import signal
import time
from pathlib import Path

from fe_models.progress import progress_bar, silent
from hybrid.fleet.processes import THREADS

BAD, DEADLY, ENDLESS = -1, -2, -3


def square(number: int) -> int:
    return number**2


def breaking(number: int) -> int:
    """Raise, die or never end where the number says so."""
    if number == BAD:
        raise ValueError("no square of this")
    if number == DEADLY:
        os.kill(os.getpid(), signal.SIGKILL)
    if number == ENDLESS:
        time.sleep(600)
    return square(number)


def slow(number: int) -> int:
    time.sleep(0.3)
    return square(number)


def process(_: int) -> int:
    return os.getpid()


def threads(_: int) -> tuple[list[str | None], list[int]]:
    """What libraries are told of threads, and what those that are loaded take."""
    import numpy  # noqa: F401  its linear algebra is what takes threads
    from threadpoolctl import threadpool_info

    return [os.environ.get(name) for name in THREADS], [own["num_threads"] for own in threadpool_info()]


def with_log(task: tuple[str, int]) -> int:
    """Square slowly, and leave a line of it in a file."""
    path, number = task
    with Path(path).open("a") as file:
        file.write(f"{number}\n")
    with silent(), progress_bar("squaring", 1) as bar:
        time.sleep(0.2)
        bar.update()
    return square(number)


def busy_with_log(task: tuple[str, int]) -> int:
    """Leave a line in a file, then compute for minutes in compiled code, which hears no handler of Python's."""
    path, number = task
    with Path(path).open("a") as file:
        file.write(f"{number}\n")
    return sum(range(10**11))
