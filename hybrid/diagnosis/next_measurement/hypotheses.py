"""Which hypotheses are left to tell apart: the most probable one, and those with another cause in the place of one."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes.candidate import Candidate
from fe_models.causes.wording import at_place, kind_words
from hybrid.diagnosis.next_measurement.config import HYPOTHESES


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
    """Hypotheses, by their ``numbers`` among all fits, the most probable one first, with their ``weights``
    (hypothesis,), which add up to one, and the ``share`` of all probability that they have.

    ``causes`` (hypothesis,): the one of the first that is most in doubt, and what each of the others has in its place.
    ``alike`` (hypothesis,): at how many places that cause would do the same, whatever is measured; ``twins``: the other
    ones of the first.
    """

    numbers: tuple[int, ...]
    weights: FloatArray
    share: float
    causes: tuple[Cause, ...]
    alike: FloatArray
    twins: tuple[Cause, ...]


def rivals_among(candidates: Sequence[tuple[Candidate, ...]], probability: FloatArray) -> Rivals | None:
    """Return what is left to tell apart of the fits with these ``candidates`` and ``probability`` (fit,), the best one
    first; None where it has no rival.
    """
    best = {candidate.key: candidate for candidate in candidates[0]}
    found = dict[str, _Rival]()
    for number, (own, p) in enumerate(zip(candidates, probability, strict=True)):
        gone = best.keys() - {candidate.key for candidate in own}
        come = [candidate for candidate in own if candidate.key not in best]
        if len(gone) == len(come) == 1:
            known = found.get(come[0].key, _Rival(number, come[0], next(iter(gone)), 0.0))
            found[come[0].key] = replace(known, probability=known.probability + float(p))
    rivals = sorted(found.values(), key=lambda item: -item.probability)
    lost = max(best, key=lambda key: sum(item.probability for item in rivals if item.lost == key), default=None)
    others = [item for item in rivals if item.lost == lost and item.probability >= HYPOTHESES.min_probability][
        : HYPOTHESES.max_hypotheses - 1
    ]
    if lost is None or not (others or best[lost].twins):
        return None
    named = sum(float(p) for own, p in zip(candidates, probability, strict=True) if lost in {c.key for c in own})
    several = [_Rival(0, best[lost], lost, named), *others]
    weights = np.array([item.probability for item in several])
    alike = np.array([1.0 + len(item.candidate.twins) for item in several])
    causes = tuple(
        Cause(item.candidate.kind, item.candidate.reported_location, item.probability / count)
        for item, count in zip(several, alike.tolist(), strict=True)
    )
    twins = tuple(Cause(causes[0].kind, twin, causes[0].probability) for twin in best[lost].twins)
    numbers = tuple(item.number for item in several)
    return Rivals(numbers, weights / weights.sum(), float(weights.sum()), causes, alike, twins)


@dataclass(frozen=True)
class _Rival:
    """The ``number`` of the likeliest fit with a ``candidate`` in the place of the best one's that is ``lost``, by its
    key, and the ``probability`` of all such fits.
    """

    number: int
    candidate: Candidate
    lost: str
    probability: float
