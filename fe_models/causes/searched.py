"""Causes that a search looks for, each at all places that it can have."""

from abc import ABC, abstractmethod
from collections.abc import Sequence

from fe_models.causes.base import CAUSES
from fe_models.causes.candidate import Candidate
from fe_models.causes.known import Known


class Searched(ABC):
    """What a cause derives from, too, that recordings may show; others are found in a way of their own."""

    @classmethod
    @abstractmethod
    def candidates(cls, known: Known) -> Sequence[Candidate]:
        """Return the cause at every place that it can have, with its prior."""


def candidates_of(known: Known) -> tuple[Candidate, ...]:
    """Return every cause at every place that it can have: by cause, but laws of a place and faults of a sensor or
    a load go together.
    """
    found: list[Candidate] = []
    for cause in CAUSES.values():
        if issubclass(cause, Searched):
            found += cause.candidates(known)
    first: dict[str, int] = {}
    for number, candidate in enumerate(found):
        first.setdefault(candidate.listed_with, number)
    return tuple(sorted(found, key=lambda candidate: first[candidate.listed_with]))
