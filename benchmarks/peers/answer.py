"""What a peer answers about a dataset, and how right that is once the truth is opened."""

from collections.abc import Callable
from dataclasses import dataclass

from benchmarks.blind.judging import CONFIDENT_PROBABILITY, key_of
from benchmarks.blind_cases import BlindCase
from fe_models.recordings import Dataset


@dataclass(frozen=True)
class Answer:
    """What a peer ``named``, each "kind place", most important first; empty where nothing is wrong.

    ``probability`` of the first name, None where the peer gives none.
    """

    named: tuple[str, ...]
    probability: float | None = None


Peer = Callable[[Dataset], Answer]


@dataclass(frozen=True)
class PeerMark:
    """An ``answer`` and its marks: ``first`` is right as in `benchmarks.blind.judging.Judgement`, and so is the other.

    A peer has no verdict "unexplained". On a case from outside of the list it is right where it names nothing at a
    probability of 0.9 or, if it gives none, nothing at all.
    """

    answer: Answer
    first: bool
    confidently_wrong: bool
    seconds: float


def mark(case: BlindCase, answer: Answer, seconds: float) -> PeerMark:
    """Return the marks of an answer about ``case``; without a probability it is never confidently wrong."""
    truth = tuple(key_of(cause) for cause in case.truth)
    sure = bool(answer.named) and (answer.probability is None or answer.probability >= CONFIDENT_PROBABILITY)
    if case.outside:
        first = not sure
    elif len(truth) == 1:
        first = answer.named[:1] == truth
    else:
        first = set(answer.named) == set(truth)
    wrong = bool(answer.named) and answer.named[0] not in truth
    confidently = wrong and answer.probability is not None and answer.probability >= CONFIDENT_PROBABILITY
    return PeerMark(answer, first, confidently, seconds)
