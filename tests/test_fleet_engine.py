"""The engine of fleets: every task once, whatever dies; and an end at once when it is asked for."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from pebble import ProcessExpired

from hybrid.fleet.engine import Answer, Answers, completed
from hybrid.fleet.failures import failure_of
from hybrid.fleet.processes import in_processes
from tests.fleet_work import BAD, DEADLY, ENDLESS, breaking, process, slow, square, threads

ROOT = Path(__file__).parents[1]


class Given:
    """An answer that is there."""

    def __init__(self, value: int) -> None:
        self.value = value

    def result(self) -> int:
        return self.value


def here(tasks: Iterator[int]) -> Answers[int, int]:
    """Work in this process."""
    for task in tasks:
        yield task, Given(square(task))


# What is done, and what is not


def test_what_is_kept_is_not_done_again_and_what_is_new_is_kept_as_it_comes() -> None:
    kept: list[int] = []
    heard: list[tuple[int, int]] = []

    def keep(task: int, answer: Answer[int]) -> str:
        kept.append(task)
        return str(answer.result())

    found = completed([3, 1, 2], {1: "old", 9: "of another plan"}, here, keep, advance=lambda *own: heard.append(own))
    assert found == {1: "old", 3: "9", 2: "4"}
    assert kept == [3, 2]
    assert heard == [(1, 3), (2, 3), (3, 3)]


def test_out_of_time_nothing_is_begun() -> None:
    assert completed([1, 2], {}, here, lambda task, answer: answer.result(), minutes=0.0) == {}


def test_what_cannot_be_kept_ends_the_work() -> None:
    ended: list[bool] = []

    def answers(tasks: Iterator[int]) -> Answers[int, int]:
        try:
            yield from here(tasks)
        finally:
            ended.append(True)

    def keep(task: int, answer: Answer[int]) -> int:
        raise OSError("disk full")

    with pytest.raises(OSError, match="disk full"):
        completed([1, 2], {}, answers, keep)
    assert ended == [True]


# Processes


def told(answer: Answer[int]) -> str:
    try:
        return str(answer.result())
    except Exception as error:
        return failure_of(error)


def test_what_ended_a_task_is_told_as_an_engineer_reads_it() -> None:
    assert failure_of(ProcessExpired("Abnormal termination", code=-9)) == (
        "its process was ended by the system (signal 9): too little memory? Use fewer --jobs"
    )
    assert failure_of(ProcessExpired("Abnormal termination", code=-11)).endswith("(signal 11, Segmentation fault)")
    assert failure_of(ProcessExpired("Abnormal termination", code=3)).endswith("(exit status 3)")
    assert failure_of(TimeoutError("Task timeout", 21600.0)) == "it was given up after 6 h"
    assert failure_of(TimeoutError("no answer")) == "TimeoutError: no answer"
    assert failure_of(ValueError("of its\nown")) == "ValueError: of its own"


@pytest.mark.slow
def test_one_that_raises_dies_or_never_ends_stops_no_other() -> None:
    tasks = [BAD, 2, DEADLY, 3, ENDLESS, 4]
    found = {task: told(answer) for task, answer in in_processes(tasks, 2, breaking, limit=6.0)}
    wanted = {2: "4", 3: "9", 4: "16", BAD: "ValueError"}
    wanted |= {DEADLY: "its process was ended by the system (signal 9)", ENDLESS: "it was given up after 6 s"}
    assert {task: own.split(": ")[0] for task, own in found.items()} == wanted


def test_each_process_has_one_thread_and_gives_way_to_a_fresh_one() -> None:
    (_, answer), *_ = in_processes([0], 1, threads)
    told_to_libraries, taken = answer.result()
    assert set(told_to_libraries) == {"1"}
    assert taken and set(taken) == {1}
    processes = [answer.result() for _, answer in in_processes(range(4), 1, process, fresh_after=2)]
    assert len(set(processes)) == 2
    assert os.getpid() not in processes


def test_a_task_is_asked_for_when_a_process_is_free_for_it() -> None:
    asked: list[int] = []

    def tasks() -> Iterator[int]:
        for task in range(5):
            asked.append(task)
            yield task

    ticks: list[int] = []
    coming = in_processes(tasks(), 2, slow, waiting=lambda: ticks.append(len(asked)))
    ahead = [len(asked) - done for done, _ in enumerate(coming)]
    assert len(ahead) == 5
    assert max(ahead) <= 2
    assert max(ticks, default=2) <= 5  # who waits is told so; how often depends on the machine


# Interrupts, in processes of their own


def started(folder: Path, work: str, count: int) -> "subprocess.Popen[str]":
    """Return a process, of a session of its own, that goes through so many tasks and leaves a file of each."""
    script = (
        "import sys\n"
        "from functools import partial\n"
        "from pathlib import Path\n"
        "from hybrid.fleet.engine import completed\n"
        "from hybrid.fleet.processes import in_processes\n"
        "from tests import fleet_work\n"
        f"folder = Path({str(folder)!r})\n"
        "(folder / 'parent').touch()\n"
        "def keep(task, answer):\n"
        "    (folder / f'{task[1]}.done').write_text(str(answer.result()))\n"
        f"tasks = [(str(folder / 'log'), number) for number in range({count})]\n"
        "there = {task: None for task in tasks if (folder / f'{task[1]}.done').exists()}\n"
        f"completed(tasks, there, partial(in_processes, jobs=2, work=fleet_work.{work}), keep)\n"
    )
    return subprocess.Popen(
        [sys.executable, "-c", script], cwd=ROOT, stderr=subprocess.PIPE, text=True, start_new_session=True
    )


def wait_for(condition: object, seconds: float = 120.0) -> None:
    """Wait until a condition holds: a busy machine takes its time to start processes."""
    assert callable(condition)
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.02)


def alive(group: int) -> list[str]:
    """Return the processes of a session that are not dead."""
    found = []
    for status in Path("/proc").glob("[0-9]*/stat"):
        try:
            state, _, own_group, session = status.read_text().rsplit(")", 1)[1].split()[:4]
        except (OSError, IndexError):  # gone meanwhile
            continue
        if session == str(group) and state != "Z" and own_group:
            found.append(status.parent.name)
    return found


@pytest.mark.slow
def test_every_task_is_done_once_however_often_the_run_is_killed(tmp_path: Path) -> None:
    """As 60 diagnoses on two cores would be, killed five times: only those in work are begun again."""
    log, rounds = tmp_path / "log", 0
    for kills in range(5):
        enough = len(list(tmp_path.glob("*.done"))) + 2 + kills % 3
        run = started(tmp_path, "with_log", 60)
        wait_for(lambda enough=enough: len(list(tmp_path.glob("*.done"))) >= enough)
        run.kill()
        run.communicate()
        wait_for(lambda run=run: not alive(run.pid))  # processes end with their parent
        rounds += 1
    last = started(tmp_path, "with_log", 60)
    _, said = last.communicate(timeout=300)
    assert (last.returncode, said) == (0, "")
    done = {int(path.stem): path.read_text() for path in tmp_path.glob("*.done")}
    assert done == {number: str(number**2) for number in range(60)}
    begun = [int(line) for line in log.read_text().split()]
    again = {number for number in begun if begun.count(number) > 1}
    assert len(begun) - 60 <= 2 * rounds, again  # two workers: two in work at each kill


@pytest.mark.slow
def test_an_interrupt_ends_compiled_work_within_a_second(tmp_path: Path) -> None:
    """Sent to all processes, as a terminal does; the children say nothing of it."""
    run = started(tmp_path, "busy_with_log", 4)
    wait_for(lambda: (tmp_path / "log").exists() and len((tmp_path / "log").read_text().split()) == 2)
    begun = time.monotonic()
    os.killpg(run.pid, signal.SIGINT)
    _, said = run.communicate(timeout=60)
    took = time.monotonic() - begun
    assert said.count("Traceback") == 1  # the parent's own
    assert said.strip().endswith("KeyboardInterrupt")
    wait_for(lambda: alive(run.pid) == [])  # the last of them may be a moment behind
    assert took < 3.0  # 0.2 s; those that do not end by themselves are killed after 3 s each
