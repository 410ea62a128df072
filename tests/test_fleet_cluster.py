"""Fleets on a Dask cluster: workers of which some are killed, tasks that raise, no cluster at all."""

import builtins
import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from fe_models.errors import InputError
from hybrid.fleet import cluster
from hybrid.fleet.cluster import on_cluster
from hybrid.fleet.engine import completed
from tests.fleet_work import BAD, breaking, with_log


@pytest.fixture
def two_workers() -> Iterator[Any]:
    """A cluster of two processes of one thread each on this machine."""
    distributed = pytest.importorskip("distributed", reason="needs pip install 'hybrid-modal[fleet]'")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, worker_dashboard_address=None
    ) as made:
        yield made


def pids(running: Any) -> list[int]:
    return [worker.process.pid for worker in running.workers.values() if worker.process is not None]


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")  # Dask's own, of sockets of workers that were killed
def test_a_killed_worker_loses_no_task(two_workers: Any, tmp_path: Path) -> None:
    """The scheduler gives its task to another worker, and the nanny starts one in its place."""
    log = tmp_path / "log"
    tasks = [(str(log), number) for number in range(20)]
    killed: list[int] = []

    def keep(task: tuple[str, int], answer: Any) -> int:
        if not killed:
            killed.append(pids(two_workers)[0])
            os.kill(killed[0], signal.SIGKILL)
        return answer.result()

    def answers(waiting: Iterator[tuple[str, int]]) -> Any:
        return on_cluster(waiting, two_workers.scheduler_address, with_log)

    found = completed(tasks, {}, answers, keep)
    assert found == {task: task[1] ** 2 for task in tasks}
    begun = [int(line) for line in log.read_text().split()]
    assert set(begun) == set(range(20))
    assert len(begun) - 20 <= 2  # what the dead one had in work, and what waited for it, at most


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_what_a_task_raises_stops_no_other(two_workers: Any) -> None:
    told = dict[int, str]()
    for task, answer in on_cluster([BAD, 2, 3], two_workers.scheduler_address, breaking):
        try:
            told[task] = str(answer.result())
        except ValueError as error:
            told[task] = str(error)
    assert told == {BAD: "no square of this", 2: "4", 3: "9"}


def test_without_the_library_one_line_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    real = builtins.__import__

    def without(name: str, *rest: Any, **named: Any) -> Any:
        if name.split(".")[0] == "distributed":
            raise ImportError(name)
        return real(name, *rest, **named)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(InputError, match=r"pip install 'hybrid-modal\[fleet\]'"):
        list(on_cluster([1], "tcp://127.0.0.1:1", breaking))


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_where_no_scheduler_answers_one_line_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed", reason="needs pip install 'hybrid-modal[fleet]'")
    monkeypatch.setattr(cluster, "ANSWER_WITHIN", 2.0)
    begun = time.monotonic()
    with pytest.raises(InputError, match=r"no scheduler answers there .*such as tcp://"):
        list(on_cluster([1], "tcp://127.0.0.1:1", breaking))
    assert time.monotonic() - begun < 60
