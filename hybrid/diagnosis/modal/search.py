"""The search over claims: sets of causes, each with its recordings, by the modal evidence; one score, one loop.

Begun with nothing wrong and with an unknown change in some recordings. In each round every cause that is not yet in a
claim is scanned beside the best claims (`scan_claims`), the most promising are fitted, and the best go on to the next
round. Where nominal values are far off, the first round does so in the structure as drawn, too: one cause may be all.
No further cause is sought where a claim leaves no more than models that are right do. Each time others are sought in
the place of the best claim's last cause, and at last next to each of several; causes without which it is better are
taken out.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes import StiffnessChange
from fe_models.causes.candidate import Candidate, ModeCandidate
from hybrid.diagnosis.contest.odds import Odds, log_of_groups
from hybrid.diagnosis.contest.posterior import PRIOR_NOTHING_WRONG
from hybrid.diagnosis.modal.claim import Claim
from hybrid.diagnosis.modal.config import CLAIM_SCAN
from hybrid.diagnosis.modal.error_sizes import ErrorSizes
from hybrid.diagnosis.modal.evidence import ModalFit, Start, fit_claim, refitted_errors, with_errors
from hybrid.diagnosis.modal.inflation import without_doubts_in_frequencies
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modal.scan import ClaimTrial, Recordings, scan_claims, shows_in_modes, worth_a_fit
from hybrid.diagnosis.nominal.nodes_at import nodes_at
from hybrid.diagnosis.parallel import parallel_map
from hybrid.diagnosis.stage_names import MODAL_CAUSES


@dataclass(frozen=True)
class Touching:
    """The candidates, by their ``keys``, that touch the place of a cause, in the recordings in which that ``acts``."""

    keys: frozenset[str]
    acts: Recordings

    def has(self, trial: ClaimTrial) -> bool:
        """Return whether a trial is one of them."""
        return trial.acts == self.acts and trial.candidate.key in self.keys


@dataclass(frozen=True)
class ClaimSearch:
    """What is searched: ``candidates`` beside the nominal structure of ``measured``; ``odds`` of each beforehand."""

    measured: ModalData
    candidates: tuple[Candidate, ...]
    odds: Odds

    @classmethod
    def of(cls, measured: ModalData, candidates: Sequence[Candidate]) -> "ClaimSearch":
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
        return item.evidence + self.log_odds(item.claim)

    def log_odds(self, claim: Claim) -> float:
        """Return the log probability of a claim before anything is measured, but for what all have in common."""
        count, prior = len(claim.acts) + bool(claim.changed), 0.0
        for number in range(count):
            prior += float(np.log(CLAIM_SCAN.further_probability if number else 1 - PRIOR_NOTHING_WRONG))
        for candidate, acts in zip(claim.hypothesis.candidates, claim.acts, strict=True):
            prior += self.odds.log(candidate) + self._log_odds_of_acting(acts)
        if claim.changed:
            prior += self._log_odds_of_acting(claim.changed) - float(np.log(1 + len(self.odds.weights)))
        return prior

    def _log_odds_of_acting(self, acts: Recordings) -> float:
        """Return the log probability that a cause acts there: of the two sides of a change the smaller is the likelier,
        by a factor of two for each recording, as a structure is mostly as it was; then the later, as what was drawn
        stood there first.
        """
        if len(acts) == self.count:
            return log_of_groups(np.ones(self.count, dtype=bool))
        beyond = max(len(acts) - self.count / 2, 0.0) + 0.5 * (self.count - 1 not in acts)
        return log_of_groups(np.isin(np.arange(self.count), acts)) - float(np.log(2)) * beyond

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
        fits = self.run_changes(null)
        frontier = self._kept(fits)
        for number, stage in enumerate(MODAL_CAUSES):
            tell(stage)
            before = self.score(self.ranked(fits)[0])
            fits += self._with_another_cause(frontier)
            fits += self._with_one_cause_as_drawn(null) if number == 0 else []
            best = self.ranked(fits)[0]
            if len(best.claim.acts) == number + 1:
                fits += self._with_causes_exchanged(best, (number,), anywhere=True)
            frontier = self._kept([item for item in fits if len(item.claim.acts) == number + 1])
            if not frontier or self.score(frontier[0]) <= before + CLAIM_SCAN.min_gain or frontier[0].sizes.are_usual:
                break
        tell("other causes in their place")
        best = self.ranked(fits)[0]
        if len(best.claim.acts) > 1:
            fits += self._with_causes_exchanged(best, range(len(best.claim.acts)))
        return self.ranked([*fits, *self._with_causes_taken_out(fits)])

    def _with_one_cause_as_drawn(self, null: ModalFit) -> list[ModalFit]:
        """Return fits with one cause in the structure as it was drawn, where its nominal values are off by more than
        was stated: those that may be what these values all stand for.
        """
        drawn = None
        if null.sizes.values_are_off:
            drawn = self._fitted(Start(null.claim, -self.measured.offset, ErrorSizes()), doubts_too=False)
        if drawn is None:
            return []
        return self._with_another_cause([drawn], least=CLAIM_SCAN.min_share * (null.evidence - drawn.evidence))

    def _kept(self, fits: Sequence[ModalFit]) -> list[ModalFit]:
        """Return the best of the fits, that further causes are added to."""
        ranked = self.ranked(fits)[: CLAIM_SCAN.max_kept]
        return [item for item in ranked if self.score(item) > self.score(ranked[0]) - CLAIM_SCAN.beam_nats]

    def run_changes(self, null: ModalFit) -> list[ModalFit]:
        """Return the fits without a cause, of an unknown change in some recordings, too, most probable first."""
        return self.ranked([null, *self._with_unknown_change(null)])

    def _with_unknown_change(self, null: ModalFit) -> list[ModalFit]:
        """Return fits with an unknown change in some recordings: where they differ at all."""
        if self.count < 2:
            return []
        groups = [group for group in self.groups if len(group) < self.count]
        guessed = [refitted_errors(self.measured, null, Claim(null.claim.hypothesis, (), group)) for group in groups]
        best = self.ranked(guessed)[: CLAIM_SCAN.max_kept]
        found = [fit_claim(self.measured, item.start) for item in best]
        return [item for item in found if item is not None]

    def _with_another_cause(
        self, frontier: Sequence[ModalFit], beside: Touching | None = None, least: float = -np.inf
    ) -> list[ModalFit]:
        """Return fits with a cause more than those of the ``frontier``: of each of these the most promising, if they
        may gain more than the ``least``, and of those ``beside`` what was found, where that is known.
        """
        found, seen = list[ModalFit](), set[object]()
        for base in frontier:
            for start in self._starts_with_another_cause(base, beside, least):
                if start.claim.key in seen:
                    continue
                seen.add(start.claim.key)
                added = start.theta[len(base.theta) :]
                beside_base = replace(base.start, claim=start.claim, theta=np.append(base.theta, added))
                for each in (start, beside_base):
                    item = fit_claim(self.measured, each)
                    found += [] if item is None else [item]
        return found

    def _starts_with_another_cause(self, base: ModalFit, beside: Touching | None, least: float) -> list[Start]:
        """Return where fits with a cause more than a fit's begin: in the place of an unknown change, and everywhere.

        Candidates are compared as if one of them were all that is missing: errors that stand for it would hide it. So
        nominal values are those that fit best with usual errors, but where it is known what is ``beside``.
        """
        right, changed = base.sizes.as_usual, base.claim.changed
        almost = self._with_usual_errors(base) if beside is None else []
        parts = [([self.everywhere] if changed else self.groups, almost or [with_errors(self.measured, base, right)])]
        if changed:
            hardly = replace(right, change=CLAIM_SCAN.remaining_change * base.sizes.change)
            parts.append(([changed], [with_errors(self.measured, base, hardly)]))
        found = []
        for groups, bases in parts:
            starts = list[Start]()
            for present in bases:
                found_by_scan = scan_claims(self.measured, present, self.candidates, groups)
                trials = self._ranked_trials([trial for trial in found_by_scan if trial.gain > least])
                promising = worth_a_fit(trials, CLAIM_SCAN.max_polished // len(bases))
                more = [] if beside is None else [trial for trial in trials[len(promising) :] if beside.has(trial)]
                starts += [_start(replace(present, sizes=right), trial) for trial in [*promising, *more]]
            found += self._polished(starts)
        return found

    def _with_usual_errors(self, base: ModalFit) -> list[ModalFit]:
        """Return a fit's claim fitted with usual errors, and no doubt in frequencies alone, from where no element is
        off by itself; none where that cannot stand.

        Where nominal values are off by more than was stated, also with doubts in modes, some of which may be taken for
        others; not with these alone, as all modes of a recording that shows a change may be doubted.
        """
        nominal, theta = self.measured.nominal, base.theta.copy()
        single = slice(nominal.factors, nominal.values)
        theta[single] = -self.measured.offset[single]
        trusted = without_doubts_in_frequencies(self.measured, base.inflation)
        start = Start(base.claim, theta, base.sizes.as_usual, trusted)
        fitted = [self._fitted(start, doubts_too=False)]
        if base.sizes.values_are_off:
            fitted.append(self._fitted(start))
        return [item for item in fitted if item is not None]

    def _ranked_trials(self, trials: Sequence[ClaimTrial]) -> list[ClaimTrial]:
        """Return trials by what they may gain of the log posterior, without those that are fitted anyway."""
        own = [trial for trial in trials if len(trial.acts) < self.count or not self._is_fitted_anyway(trial.candidate)]
        return sorted(own, key=lambda trial: -self._promise(trial))

    def _promise(self, trial: ClaimTrial) -> float:
        """Return what a trial may gain of the log posterior."""
        return trial.gain + self.odds.log(trial.candidate) + self._log_odds_of_acting(trial.acts)

    def _is_fitted_anyway(self, candidate: Candidate) -> bool:
        """Return whether a candidate is a damping ratio, or the stiffness of elements that are uncertain as a whole:
        these are fitted anyway. A single element may be off by more than any value, all the same.
        """
        if isinstance(candidate, ModeCandidate):
            return True
        if "group" in candidate.location:  # its stiffness and its mass, too
            return True
        part = getattr(candidate, "part", None)
        if part is None or candidate.kind != StiffnessChange.kind:
            return False
        own = candidate.location.get("elements") or [candidate.location["element"]]
        return len(own) > 1 and tuple(own) == tuple(self.measured.nominal.parts[part].elements)

    def _polished(self, starts: Sequence[Start]) -> list[Start]:
        """Return the best of the starts after a few rounds of fitting, the sizes of errors as they were."""
        items = [item for item in parallel_map(self._fitted, starts) if item is not None]
        best = sorted(items, key=lambda item: -self.score(item))[: CLAIM_SCAN.max_fitted]
        return [item.start for item in best]

    def _fitted(self, start: Start, doubts_too: bool = True) -> ModalFit | None:
        """Return a start after a few rounds of fitting, the sizes of errors as they were.

        ``doubts_too``: with doubts in modes as is likeliest. Values that are far off lead some of these to others'
        places, and without doubts everything else with them.
        """
        return fit_claim(self.measured, start, CLAIM_SCAN.polishing_rounds, errors_too=False, doubts_too=doubts_too)

    def _with_causes_taken_out(self, fits: Sequence[ModalFit]) -> list[ModalFit]:
        """Return fits in which causes of the best claim are taken out, one by one, as long as it is the better for it:
        a cause may have come in before nominal values were where they should be.
        """
        best, found = self.ranked(fits)[0], list[ModalFit]()
        while best.claim.acts:
            own = self.ranked(less_one(self.measured, best))
            found += own
            if not own or self.score(own[0]) < self.score(best):
                break
            best = own[0]
        return found

    def _with_causes_exchanged(self, best: ModalFit, numbers: Sequence[int], anywhere: bool = False) -> list[ModalFit]:
        """Return fits in which causes of a fit, by their ``numbers``, are others next to them, or, at first,
        ``anywhere``; so again of the best of them, as long as one is the better for it.

        Beside a wrong cause that is near the right one nominal values are nearly right, without any they are not: so
        others are sought with the values as they are beside it.
        """
        found = list[ModalFit]()
        for move in range(CLAIM_SCAN.max_moves):
            each = [self._with_cause_exchanged(best, number, anywhere and move == 0) for number in numbers]
            more = [item for fits in each for item in fits]
            found += more
            now = self.ranked([best, *more])[0]
            if now is best:
                break
            best = now
        return found

    def _with_cause_exchanged(self, best: ModalFit, number: int, anywhere: bool) -> list[ModalFit]:
        """Return fits with another cause in the place of one of a fit's, nominal values and errors as they are.

        What touches its place is tried alone, or, of all ``anywhere``, in any case: scans say roughly what a large
        cause gains.
        """
        structure = self.measured.nominal.structure
        here = nodes_at(best.claim.hypothesis.candidates[number].location, structure)
        touching = frozenset(
            own.key for own in self.candidates if not here.isdisjoint(nodes_at(own.location, structure))
        )
        base = fit_claim(self.measured, best.start.less(number), 1, errors_too=False)
        own = tuple(candidate for candidate in self.candidates if anywhere or candidate.key in touching)
        search, beside = replace(self, candidates=own), Touching(touching, best.claim.acts[number])
        return [] if base is None else search._with_another_cause([base], beside)


def _start(base: ModalFit, trial: ClaimTrial) -> Start:
    """Return where a fit begins with a trial more, in the place of an unknown change of the same recordings."""
    claim = base.claim
    changed = () if trial.acts == claim.changed else claim.changed
    more = Claim(claim.hypothesis.adding(trial.candidate), (*claim.acts, trial.acts), changed)
    return Start(more, np.append(base.theta, trial.size), base.sizes, base.inflation)


def less_one(measured: ModalData, item: ModalFit) -> list[ModalFit]:
    """Return the fits of a fit's claim less one of its causes, each in turn."""
    found = [fit_claim(measured, item.start.less(number)) for number in range(len(item.claim.acts))]
    return [own for own in found if own is not None]


def probabilities(search: ClaimSearch, fits: Sequence[ModalFit]) -> FloatArray:
    """Return how probable each fit's claim is among all of them (fit,)."""
    scores = np.array([search.score(item) for item in fits])
    weights = np.exp(scores - scores.max())
    return np.asarray(weights / weights.sum())
