"""Which hypotheses are left to tell apart: the most probable one, and those with another cause in the place of one."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes.candidate import Candidate
from fe_models.causes.wording import at_place, kind_words

DOUBTFUL = 0.01  # least probability of a hypothesis, beside the best, that is worth telling apart
MOST = 5  # hypotheses: the time to compare them grows with the square


@dataclass(frozen=True)
class Cause:
    """A ``kind`` of cause at a ``location``, in the words of a report, and its ``probability``."""

    kind: str
    location: dict[str, Any]
    probability: float

    @property
    def words(self) -> str:
        """The cause for a sentence."""
        return f"the {kind_words(self.kind)} {at_place(self.location)}"


@dataclass(frozen=True, eq=False)
class Rivals:
    """Hypotheses, by their ``numbers`` among all fits, most probable first, with their ``weights`` (hypothesis,), which
    add up to one, and the ``share`` of all probability that they have. ``causes`` (hypothesis,): the cause in which
    each differs from the first; of that the one that most of them replace. ``twins``: places at which the first one's
    cause would do the same, whatever is measured.
    """

    numbers: tuple[int, ...]
    weights: FloatArray
    share: float
    causes: tuple[Cause, ...]
    twins: tuple[Cause, ...]


def rivals_among(candidates: Sequence[tuple[Candidate, ...]], probability: FloatArray) -> Rivals | None:
    """Return what is left to tell apart of the fits with these ``candidates`` and ``probability`` (fit,), the best one
    first; None where it has no rival.
    """
    best = {candidate.key: candidate for candidate in candidates[0]}
    total, first, replaced = dict[frozenset[str], float](), dict[frozenset[str], int](), dict[frozenset[str], str]()
    instead = dict[frozenset[str], Candidate]()
    for number, (own, p) in enumerate(zip(candidates, probability, strict=True)):
        keys = frozenset(candidate.key for candidate in own)
        gone, come = best.keys() - keys, [candidate for candidate in own if candidate.key not in best]
        if len(keys) != len(best) or len(gone) > 1:
            continue
        first.setdefault(keys, number)  # of one cause in other recordings the likelier ones
        total[keys] = total.get(keys, 0.0) + float(p)
        if come:
            instead[keys], (replaced[keys],) = come[0], gone
    own = frozenset(best)
    others = sorted((keys for keys in total if keys != own and total[keys] >= DOUBTFUL), key=lambda k: -total[k])
    others = others[: MOST - 1]
    lost = max(replaced.values(), key=lambda key: sum(total[k] for k in replaced if replaced[k] == key), default="")
    lost = lost or next(iter(best), "")
    twins = best[lost].twins if lost else ()
    if not (others or twins):
        return None
    kept = [own, *others]
    found = [best[lost], *(instead[keys] for keys in others)]
    share = sum(total[keys] for keys in kept)
    causes = tuple(
        Cause(item.kind, item.reported_location, total[keys] / (1 + len(item.twins)))
        for item, keys in zip(found, kept, strict=True)
    )
    alike = tuple(Cause(causes[0].kind, twin, causes[0].probability) for twin in twins)
    weights = np.array([total[keys] for keys in kept]) / share
    return Rivals(tuple(first[keys] for keys in kept), weights, share, causes, alike)
