"""What is known of causes before any recording is looked at."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from fe_models.arrays import BoolArray
from fe_models.causes.candidate import Candidate


@dataclass(frozen=True)
class Odds:
    """Every kind is as probable as any other, and places of a kind by their weight.

    ``weights``: the sum over all places of a kind, divided by the largest of them where that is less than one, so that
    a kind that has but improbable places is no more probable than these.

    ``alike``: number of recorded values that are worth one independent value.
    """

    weights: dict[str, float]
    alike: float

    @classmethod
    def among(cls, candidates: Iterable[Candidate], alike: float) -> "Odds":
        """Return the odds of ``candidates``."""
        weights, largest = dict[str, float](), dict[str, float]()
        for candidate in candidates:
            kind, own = candidate.kind, candidate.weight
            weights[kind] = weights.get(kind, 0.0) + own * (1 + len(candidate.twins))
            largest[kind] = max(largest.get(kind, 0.0), own)
        return cls({kind: total / min(largest[kind], 1.0) for kind, total in weights.items()}, alike)

    def log(self, candidate: Candidate) -> float:
        """Return the log probability that what is wrong is this kind, at this place."""
        return float(np.log(candidate.weight / self.weights[candidate.kind] / len(self.weights)))

    def price(self, candidate: Candidate) -> float:
        """Return the fall in the sum of squares that a cause must bring to be as probable as one known beforehand."""
        return -2 * self.alike * self.log(candidate)


def log_of_groups(acting: BoolArray) -> float:
    """Return the log probability that a cause acts in these recordings (recording,), in the order they were made.

    It acts in all of them, or comes or goes once, or now and then: the last two as probable as each other, together
    as all that acts everywhere, and so is each group of either.
    """
    count, turns = len(acting), np.count_nonzero(np.diff(acting))
    if turns == 0:
        return 0.0
    return -float(np.log(2)) - float(np.log(2 * (count - 1)) if turns == 1 else count * np.log(2))
