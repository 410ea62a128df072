"""What answers the tasks of a certificate in tests, in place of a diagnosis: quick, slow, or breaking down."""

import os
import signal
import time

from benchmarks.blind.cases import BlindResult, Task
from benchmarks.certificate.code import Code
from benchmarks.certificate.plan import Column
from tests.blind_results import CUBIC, EXPLAINED, case_of, diagnosis, finding, result

CODE = Code("0123456789abcdef0123456789abcdef01234567")
FIRST = 5000  # no seed of the certificate
COLUMNS = (Column("four_dof", "exact", 4, FIRST), Column("four_dof", "off", 2, FIRST + 100))


def right(task: Task) -> BlindResult:
    """The cubic spring that was hidden is named; the task's own word stays."""
    found = result(case_of(CUBIC), diagnosis(EXPLAINED, finding(CUBIC, 0.99)), None, task.seed, task.config)
    return BlindResult(task, found.judgement, {})


def slow(task: Task) -> BlindResult:
    time.sleep(1.0)
    return right(task)


def breaking(task: Task) -> BlindResult:
    """The first case's process is killed, as by a system out of memory; the second ends in an exception."""
    if task.seed == FIRST:
        os.kill(os.getpid(), signal.SIGKILL)
    if task.seed == FIRST + 1:
        raise MemoryError
    return right(task)


def endless(task: Task) -> BlindResult:
    if task.seed == FIRST:
        time.sleep(600)
    return right(task)
