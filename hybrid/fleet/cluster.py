"""Work on a Dask cluster. Its machines have this program, and see the same files under the same names."""

from collections.abc import Callable, Iterable
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fe_models.errors import InputError
from fe_models.progress import nothing
from hybrid.fleet.engine import TICK, Answers, Result, Task

if TYPE_CHECKING:
    from distributed import Client

MISSING = (
    "--scheduler: the library for clusters is not installed; pip install 'hybrid-modal[fleet]' brings it, here and on"
    " every machine of the cluster"
)
ANSWER_WITHIN = 30.0  # s, of a scheduler, and until it has a worker


def on_cluster(
    wanted: Iterable[Task],
    address: str,
    work: Callable[[Task], Result],
    *,
    waiting: Callable[[], object] = nothing,
) -> Answers[Task, Result]:
    """Give each task with the result of the ``work`` on it, whichever is ready first, from the workers of a scheduler.

    ``address``: "tcp://HOST:PORT", "HOST:PORT", or the file that the scheduler wrote. A task whose worker dies is given
    to another one; the result raises `distributed.KilledWorker` where several died of it, and else what the work
    raised. The next task is asked for when a thread of a worker is free for it. ``waiting`` is called every second in
    which nothing is ready. `InputError` where no scheduler answers, or none of its workers.
    """
    client = _client(address)
    coming = iter(wanted)
    running: dict[Any, Task] = {}
    try:
        from distributed import wait

        while True:
            free = max(1, sum(client.nthreads().values())) - len(running)
            for task in islice(coming, max(0, free)):
                running[client.submit(work, task, pure=False)] = task
            if not running:
                return
            try:
                found = wait(list(running), timeout=TICK, return_when="FIRST_COMPLETED").done
            except TimeoutError:
                waiting()
                continue
            for ready in found:
                yield running.pop(ready), ready
    finally:
        client.cancel(list(running))
        client.close()


def _client(address: str) -> "Client":
    """Return a client of the scheduler at an ``address`` that has workers."""
    try:
        from distributed import Client
    except ImportError as error:
        raise InputError(MISSING) from error
    if address.endswith(".json") and not Path(address).is_file():
        raise InputError(f"--scheduler {address}: no such file; give the one that 'dask scheduler' wrote")
    try:
        client = Client(scheduler_file=address) if address.endswith(".json") else Client(address, timeout=ANSWER_WITHIN)
    except (OSError, ValueError) as error:
        reason = " ".join(str(error).split())
        raise InputError(
            f"--scheduler {address}: no scheduler answers there ({reason}); give the address that 'dask scheduler'"
            " prints, such as tcp://192.168.0.7:8786"
        ) from error
    try:
        client.wait_for_workers(1, timeout=ANSWER_WITHIN)
    except TimeoutError as error:
        client.close()
        raise InputError(
            f"--scheduler {address}: it has no workers; start some, with 'dask worker {address} --nthreads 1'"
        ) from error
    return client
