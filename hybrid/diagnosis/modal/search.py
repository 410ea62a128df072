"""The search over claims: sets of causes, each with its recordings, by the modal evidence; one score, one loop.

Begun with nothing wrong and with an unknown change in some recordings. In each round every cause that is not yet in a
claim is scanned beside the best claims (`scan`), the most promising are fitted, and the best go on to the next round.
At last each cause of the best claim is taken out, and others are sought in its place.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes.candidate import Candidate
from hybrid.diagnosis.contest.odds import Odds, log_of_groups
from hybrid.diagnosis.modal.config import SCAN
from hybrid.diagnosis.modal.errors import ErrorSizes
from hybrid.diagnosis.modal.evidence import Claim, Measured, ModalFit, fit_claim, refitted_errors
from hybrid.diagnosis.modal.scan import Recordings, Trial, scan, shows_in_modes

NOTHING = 0.5  # prior probability that nothing (more) is wrong


@dataclass(frozen=True)
class Search:
    """What is searched: ``candidates`` beside the nominal structure of ``measured``; ``odds`` of each beforehand."""

    measured: Measured
    candidates: tuple[Candidate, ...]
    odds: Odds

    @classmethod
    def of(cls, measured: Measured, candidates: Sequence[Candidate]) -> "Search":
        """Return the search over those ``candidates`` that modes can tell."""
        own = tuple(candidate for candidate in candidates if shows_in_modes(candidate))
        return cls(measured, own, Odds.among(own, 1.0))

    @property
    def count(self) -> int:
        """Number of recordings."""
        return len(self.measured.recordings)

    @property
    def everywhere(self) -> Recordings:
        """All recordings."""
        return tuple(range(self.count))

    @property
    def groups(self) -> list[Recordings]:
        """Groups of recordings in which a cause may act: all; each; those from one on, and those before it."""
        every = self.everywhere
        splits = [part for k in range(1, self.count) for part in (every[k:], every[:k])]
        return list(dict.fromkeys([every, *[(r,) for r in every], *splits]))

    def score(self, item: ModalFit) -> float:
        """Return the log posterior of a fit's claim, but for what all have in common."""
        claim, prior = item.claim, 0.0
        for candidate, acts in zip(claim.hypothesis.candidates, claim.acts, strict=True):
            prior += float(np.log(1 - NOTHING)) + self.odds.log(candidate) + self._log_of(acts)
        if claim.changed:
            prior += float(np.log(1 - NOTHING)) - float(np.log(1 + len(self.odds.weights))) + self._log_of(claim.changed)
        return item.evidence + prior

    def _log_of(self, acts: Recordings) -> float:
        return log_of_groups(np.isin(np.arange(self.count), acts))

    def ranked(self, fits: Sequence[ModalFit]) -> list[ModalFit]:
        """Return the best fit of each claim, most probable first."""
        best: dict[object, ModalFit] = {}
        for item in fits:
            known = best.get(item.claim.key)
            if known is None or known.evidence < item.evidence:
                best[item.claim.key] = item
        return sorted(best.values(), key=lambda item: -self.score(item))

    def run(self, null: ModalFit, tell: Callable[[str], object]) -> list[ModalFit]:
        """Return the fits of all claims that were tried, most probable first; ``null``: that of no cause."""
        tell("changes between recordings")
        fits = [null, *self._changed(null)]
        frontier = self.ranked(fits)[: SCAN.kept]
        for number in range(SCAN.max_causes):
            tell(f"cause {number + 1}")
            before = self.score(self.ranked(fits)[0])
            fits += self._extended(frontier)
            frontier = [item for item in self.ranked(fits) if len(item.claim.acts) == number + 1][: SCAN.kept]
            if not frontier or self.score(frontier[0]) <= before + SCAN.min_gain:
                break
        tell("other causes in their place")
        fits += self._replaced(self.ranked(fits)[0])
        return self.ranked(fits)

    def _changed(self, null: ModalFit) -> list[ModalFit]:
        """Return fits with an unknown change in some recordings: where they differ at all."""
        if self.count < 2:
            return []
        groups = [group for group in self.groups if len(group) < self.count]
        guessed = [refitted_errors(self.measured, null, Claim(null.claim.hypothesis, (), group)) for group in groups]
        best = self.ranked(guessed)[: SCAN.kept]
        found = [fit_claim(self.measured, item.claim, item.theta, item.sizes) for item in best]
        return [item for item in found if item is not None]

    def _extended(self, frontier: Sequence[ModalFit]) -> list[ModalFit]:
        """Return fits with a cause more than those of the ``frontier``: of each of these the most promising."""
        found, seen = list[ModalFit](), set[object]()
        for base in frontier:
            for trials in self._scanned(base):
                ranked = sorted(trials, key=lambda trial: -self._promise(trial))
                claims = [(_with(base.claim, trial), trial) for trial in ranked[: SCAN.fitted]]
                for claim, trial in claims:
                    if claim.key not in seen:
                        seen.add(claim.key)
                        item = fit_claim(self.measured, claim, np.append(base.theta, trial.size), base.sizes)
                        found += [] if item is None else [item]
        return found

    def _promise(self, trial: Trial) -> float:
        """Return what a trial may gain of the log posterior."""
        return trial.gain + self.odds.log(trial.candidate) + self._log_of(trial.acts)

    def _scanned(self, base: ModalFit) -> list[list[Trial]]:
        """Return what scans beside a fit promise: beside an unknown change, of causes everywhere and in its place."""
        changed = base.claim.changed
        if not changed:
            return [scan(self.measured, base, self.candidates, self.groups)]
        little = replace(base.sizes, change=SCAN.remaining_change * base.sizes.change)
        almost = refitted_errors(self.measured, replace(base, sizes=little), base.claim, 0)
        return [
            scan(self.measured, base, self.candidates, [self.everywhere]),
            scan(self.measured, almost, self.candidates, [changed]),
        ]

    def _replaced(self, best: ModalFit) -> list[ModalFit]:
        """Return fits in which one of the best claim's several causes is another, or has another place."""
        claim = best.claim
        if len(claim.acts) < 2:
            return []
        fits = []
        for number in range(len(claim.acts)):
            less = _without(claim, number)
            kept = best.claim.hypothesis.parameters_of((number,))
            base = fit_claim(self.measured, less, best.theta[kept], best.sizes)
            fits += [] if base is None else [base, *self._extended([base])]
        return fits


def _with(claim: Claim, trial: Trial) -> Claim:
    """Return a claim with a cause more, in the place of an unknown change of the same recordings."""
    changed = () if trial.acts == claim.changed else claim.changed
    return Claim(claim.hypothesis.adding(trial.candidate), (*claim.acts, trial.acts), changed)


def _without(claim: Claim, number: int) -> Claim:
    """Return a claim less one of its causes."""
    acts = tuple(own for position, own in enumerate(claim.acts) if position != number)
    return Claim(claim.hypothesis.less((number,)), acts, claim.changed)


def probabilities(search: Search, fits: Sequence[ModalFit]) -> FloatArray:
    """Return how probable each fit's claim is among all of them (fit,)."""
    scores = np.array([search.score(item) for item in fits])
    weights = np.exp(scores - scores.max())
    return np.asarray(weights / weights.sum())


def null_fit(measured: Measured) -> ModalFit | None:
    """Return the fit of the nominal structure, its values as far off as the modes say."""
    return fit_claim(measured, measured.null, -measured.offset, ErrorSizes(), 14)
