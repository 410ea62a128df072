"""Work in processes of this machine, one thread each: one may die, or never end, while the others go on.

Pebble rather than joblib: where a process dies, joblib ends all of them and cannot tell whose task it was, and it
knows no time limit of a single task.
"""

import os
import signal
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, wait
from contextlib import contextmanager
from itertools import islice
from multiprocessing import get_context, parent_process
from multiprocessing.connection import wait as ended
from threading import RLock, Thread

from pebble import ProcessPool

from fe_models.progress import nothing
from hybrid.fleet.engine import TICK, Answers, Result, Task

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
LOST = 1  # exit status of a process whose parent is gone


def in_processes(
    wanted: Iterable[Task],
    jobs: int,
    work: Callable[[Task], Result],
    limit: float | None = None,
    *,
    fresh_after: int = 0,
    waiting: Callable[[], object] = nothing,
) -> Answers[Task, Result]:
    """Give each task with the result of the ``work`` on it, whichever is ready first, from ``jobs`` processes.

    The result raises what the work raised, `TimeoutError` where it took more than ``limit`` (s), and
    `pebble.ProcessExpired` where its process died; the other tasks go on. The next task is asked for when a process is
    free for it. After ``fresh_after`` tasks a process gives its memory back and a new one takes its place (0: never).
    ``waiting`` is called every second in which nothing is ready. Processes end with this one, however it ends.
    """
    coming = iter(wanted)
    pool = ProcessPool(jobs, fresh_after, initializer=_begin, context=get_context("spawn"))
    running: dict[Future[Result], Task] = {}
    try:
        while True:
            with _interrupts_kept_from_children():  # the first call starts the processes
                for task in islice(coming, jobs - len(running)):
                    running[pool.schedule(work, (task,), timeout=limit)] = task
            if not running:
                return
            found = wait(running, TICK, FIRST_COMPLETED).done
            if not found:
                waiting()
            for ready in found:
                yield running.pop(ready), ready
    finally:
        pool.stop()
        pool.join()


def usable_cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextmanager
def _interrupts_kept_from_children() -> Iterator[None]:
    """Have threads and processes that begin within the block never see Ctrl-C, which is their parent's to answer."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _begin() -> None:
    """Prepare a process for its tasks: one thread, an end at once where it is stopped, and with its parent."""
    signal.signal(signal.SIGTERM, signal.SIG_DFL)  # compiled code would keep a handler of Python's waiting
    for name in THREADS:  # of libraries that are not loaded yet
        os.environ[name] = "1"
    from threadpoolctl import threadpool_limits
    from tqdm import tqdm

    threadpool_limits(1)  # of those that are
    tqdm.set_lock(RLock())  # its own is a semaphore of the system, about which who ends so is scolded
    Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    """End this process when its parent has ended, killed say: nobody would take its result."""
    parent = parent_process()
    if parent is not None:
        ended([parent.sentinel])
        os._exit(LOST)
