"""Blind cases with fresh seeds: drawn, diagnosed, answered by the peers, and only then held against the truth."""

import time
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from functools import partial

from threadpoolctl import threadpool_limits

from benchmarks.blind.judging import Judgement, judge
from benchmarks.blind_cases import FAR_KINDS, OUTSIDE, BlindConfig, Excitation, StructureName, blind_case
from benchmarks.blind_cases.kinds import kinds_of, outside_of
from benchmarks.peers.answer import Peer, PeerMark, mark
from benchmarks.peers.exhaustive import name_by_aic
from benchmarks.peers.sparse import name_by_regression
from fe_models.causes import TimeIntegration
from fe_models.errors import InputError
from hybrid.diagnosis.config import THREADS
from hybrid.diagnosis.diagnosis import diagnose
from hybrid.fleet.processes import in_processes

NOTHING = "nothing"  # the word for a clean case
CERTIFICATE_SEED = 20_000_000  # seeds from here on are the certificate's alone, so that nobody works towards them
CLEAN_CASES = 3  # clean cases beside one of every kind
PEERS: dict[str, Peer] = {"exhaustive AIC": name_by_aic, "sparse regression": name_by_regression}


@dataclass(frozen=True)
class Task:
    """What to hide, ``hidden`` ("a+b" for two at once), in the case of a ``seed``, all else as in ``config``."""

    seed: int
    hidden: str
    config: BlindConfig


@dataclass(frozen=True)
class BlindResult:
    """A task done: how right the diagnosis was (``judgement``), and each peer by its name."""

    task: Task
    judgement: Judgement
    peers: dict[str, PeerMark]

    @property
    def is_clean(self) -> bool:
        """Whether nothing was hidden."""
        return self.task.hidden == NOTHING

    @property
    def is_outside(self) -> bool:
        """Whether something was hidden that is none of the list."""
        return any(word in OUTSIDE for word in self.task.hidden.split("+"))

    @property
    def is_single(self) -> bool:
        """Whether one cause of the list was hidden."""
        return not (self.is_clean or self.is_outside or self.is_pair)

    @property
    def is_pair(self) -> bool:
        """Whether several causes of the list were hidden."""
        return "+" in self.task.hidden and not self.is_outside

    @property
    def is_immaterial(self) -> bool:
        """Whether forecasts do not need what was hidden: where it acts in all recordings, and they are forecast."""
        config = self.task.config
        return config.acts == "all" and config.excitation != "ambient" and self.judgement.is_immaterial

    @property
    def line(self) -> str:
        """What was hidden and what was named, in a line."""
        found = self.judgement
        names = ", ".join(
            f"{name} ({probability:.3f})"
            for name, (probability, _) in zip(found.named, found.probabilities, strict=True)
        )
        truth = ", ".join(found.truth) or NOTHING
        return f"seed {self.task.seed}: {truth}: {found.verdict.value}, named {names or 'nothing'}"


def words_of(structure: StructureName, excitation: Excitation = "free") -> tuple[str, ...]:
    """Return what is hidden in turn: every kind that a structure can have, clean cases, what is outside the list."""
    return (*kinds_of(structure, excitation), *[NOTHING] * CLEAN_CASES, *outside_of(excitation))


def default_words(config: BlindConfig) -> tuple[str, ...]:
    """Return what is hidden in turn in cases like ``config``, where nobody says.

    In a structure that is far from its drawing only what has a linear effect: there is always something wrong with its
    groups, so that no case is clean. In one recording only what can act in one.
    """
    words = words_of(config.structure, config.excitation)
    if config.tier == "far":
        words = tuple(word for word in words if word in FAR_KINDS)
    return tuple(word for word in words if config.acts == "all" or word != TimeIntegration.kind)


def tasks(count: int, seed: int, words: Sequence[str], config: BlindConfig) -> list[Task]:
    """Return ``count`` tasks with the seeds from ``seed`` on, the ``words`` in turn.

    `InputError` where the seeds are the certificate's.
    """
    if seed + count > CERTIFICATE_SEED:
        raise InputError(
            f"seed {seed + count - 1}: seeds from {CERTIFICATE_SEED} on are for --certificate alone; choose lower ones"
        )
    return [Task(seed + number, words[number % len(words)], config) for number in range(count)]


def done(task: Task, peers: tuple[str, ...] = ()) -> BlindResult:
    """Return the result of a task, with as many threads for the peers as for the diagnosis.

    Times are of the processor, all threads together.
    """
    hidden = () if task.hidden == NOTHING else tuple(task.hidden.split("+"))
    marks = {}
    with threadpool_limits(THREADS.linear_algebra, "blas"):
        case = blind_case(task.seed, replace(task.config, kinds=hidden))
        begun = time.process_time()  # which says the same beside other work
        try:
            answered = diagnose(case.dataset)
            judgement = replace(judge(case, answered), seconds=time.process_time() - begun)
        except Exception as error:
            error.add_note(f"while the blind case of seed {task.seed} was diagnosed: {task.hidden} hidden")
            raise
        for name in peers:
            begun = time.process_time()
            answer = PEERS[name](case.dataset)
            marks[name] = mark(case, answer, time.process_time() - begun)
    return BlindResult(task, judgement, marks)


def all_done(
    wanted: Sequence[Task],
    peers: tuple[str, ...] = (),
    jobs: int = 1,
    finished: Callable[[list[BlindResult]], object] = lambda _: None,
) -> list[BlindResult]:
    """Return the results in the order of the tasks, from ``jobs`` processes.

    ``finished`` is given those at hand, the newest last, after each.
    """
    found: list[BlindResult] = []
    if jobs == 1:
        for task in wanted:
            found.append(done(task, peers))
            finished(found)
        return found
    work = partial(done, peers=peers)
    with closing(in_processes(wanted, jobs, work)) as coming:  # where a task fails, the processes end
        for _, ready in coming:
            found.append(ready.result())
            finished(found)
    return sorted(found, key=lambda result: wanted.index(result.task))
