"""Which force law the recordings ask for, at which place: all are screened, the best are fitted.

A law is named by what it leaves. What is not on the list is followed in part by whatever is most like it; the right law
leaves no more of the discrepancy than any right model does. Beforehand one is as probable as the other: the
discrepancy's size then has its usual distribution, and what a law that only resembles the right one leaves of its
energy may be any share.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fe_models.arrays import TINY, FloatArray
from fe_models.causes.candidate import LawCandidate
from fe_models.causes.known import Channel, Known
from fe_models.causes.places import Motion
from fe_models.causes.searched import candidates_of
from hybrid.diagnosis.contest.odds import Odds
from hybrid.diagnosis.contest.posterior import PRIOR_NOTHING_WRONG
from hybrid.diagnosis.discrepancy.config import LAW_FIT
from hybrid.diagnosis.discrepancy.law_fit import (
    LawFit,
    fit_along,
    fit_law,
    is_followed,
    refitted_law,
    unexpected_by_law,
)
from hybrid.diagnosis.discrepancy.size import right_law_probability
from hybrid.diagnosis.discrepancy.tracking import Track
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.parallel import parallel_map


@dataclass(frozen=True, eq=False)
class LawSearch:
    """The ``track`` without a law; the ``fits`` of laws, most probable first, with their ``probabilities`` (law,); what
    is left over is that no law acts (``none``), or one that is not on the list (``other``). ``replaces_causes``:
    whether laws were sought in the place of all other causes, or beside them.
    """

    track: Track
    fits: tuple[LawFit, ...]
    probabilities: FloatArray
    none: float
    other: float
    replaces_causes: bool = True

    @classmethod
    def without_laws(cls, track: Track) -> "LawSearch":
        """Return the search where no law is possible, or none is needed."""
        return cls(track, (), np.zeros(0), 1.0, 0.0)

    @property
    def nominal(self) -> NominalModel:
        """The nominal model beside which laws were sought."""
        return self.track.nominal

    @property
    def log_evidence(self) -> float:
        """The log evidence of the most probable law, or of none."""
        return max([self.track.evidence, *(fit.evidence for fit in self.fits)])

    @property
    def named(self) -> LawFit | None:
        """The most probable law, None where most probably none of the list acts."""
        return self.fits[0] if self.fits and float(self.probabilities.sum()) > self.none + self.other else None


def search_laws(track: Track) -> LawSearch:
    """Return the force laws that a track's motions ask for."""
    laws = _candidates(track)
    if not laws:
        return LawSearch.without_laws(track)
    contest = _LawContest(track, laws, Odds.among(laws, 1.0), track.marginal.weighed(track.residuals))
    fits = contest.with_own_motion(contest.most_promising(), LAW_FIT.max_refined)
    fits = contest.with_neighbours(fits)
    return with_probabilities(track, contest.with_best_settled(fits), contest.odds)


@dataclass(frozen=True, eq=False)
class _LawContest:
    """The ``laws`` that may act in a ``track``, with their ``odds`` beforehand; its residuals ``weighed`` (time
    sensor,) by what disturbs.
    """

    track: Track
    laws: tuple[LawCandidate, ...]
    odds: Odds
    weighed: list[FloatArray]

    def most_promising(self) -> list[LawCandidate]:
        """Return the laws that promise most, each at the place that stands for all like it."""
        scanned = _unlike(self.track, self.laws)
        gains = parallel_map(lambda law: max(self._gain(law, start) for start in _starts(law)), scanned)
        return [scanned[number] for number in np.argsort(gains)[::-1][: LAW_FIT.max_fitted]]

    def with_own_motion(self, laws: Sequence[LawCandidate], count: int) -> list[LawFit]:
        """Return the best ``count`` of some laws along the motion as it is, each then fitted with its own motion."""
        best = sorted(parallel_map(self._along_track, laws), key=lambda fit: -self._score(fit))[:count]
        rounds = LAW_FIT.first_rounds
        return parallel_map(lambda fit: fit_law(self.track, fit.candidate, fit.theta, rounds), best)

    def with_neighbours(self, fits: list[LawFit]) -> list[LawFit]:
        """Return fits, and those of the best law's kind where the structure moves alike, as long as one is better."""
        for _ in range(LAW_FIT.max_moves):
            best, known = max(fits, key=self._score), {fit.candidate.key for fit in fits}
            if best.evidence <= self.track.evidence:
                break
            beside = [law for law in _nearest(self.track, best.candidate, self.laws) if law.key not in known]
            more = self.with_own_motion(beside[: LAW_FIT.max_neighbours], LAW_FIT.max_neighbours)
            fits = [*fits, *more]
            if not more or max(map(self._score, more)) <= self._score(best):
                break
        return fits

    def with_best_settled(self, fits: Sequence[LawFit]) -> list[LawFit]:
        """Return fits, of which the best and its rivals have modes where the recordings have them, these first."""
        ranked = sorted(fits, key=lambda fit: -self._score(fit))
        best = ranked[:1] + [fit for fit in ranked[1 : LAW_FIT.max_settled] if not _is_beaten(fit, ranked[0])]
        settled = parallel_map(lambda fit: refitted_law(self.track, fit), best)
        done = {fit.candidate.key for fit in best}
        return [*settled, *(fit for fit in ranked if fit.candidate.key not in done)]

    def _along_track(self, law: LawCandidate) -> LawFit:
        """Return the law along the motion as it is, from the start that promises most."""
        start = max(_starts(law), key=lambda theta: self._gain(law, theta))
        return fit_along(self.track, law, start, is_acting=False)

    def _score(self, fit: LawFit) -> float:
        return fit.evidence + self.odds.log(fit.candidate)

    def _gain(self, law: LawCandidate, theta: FloatArray) -> float:
        """Return what a law may gain of the log density whose force is as large as fits best: a step of least squares
        in its size alone.
        """
        shown = unexpected_by_law(self.track, law, theta)
        along = sum(float(a @ b) for a, b in zip(shown, self.weighed, strict=True))
        columns = [own[:, None] for own in shown]
        square = float(self.track.marginal.inner(columns, columns)[0, 0])
        return 0.5 * max(along, 0.0) ** 2 / square if square > 0 else 0.0


def _starts(law: LawCandidate) -> list[FloatArray]:
    """Return the parameters (parameter,) from which a law is fitted."""
    return [np.array(start) for start in law.first_starts]


def _is_beaten(fit: LawFit, best: LawFit) -> bool:
    """Return whether a law leaves more than a right model does where the best leaves no more."""
    return best.track.discrepancy.is_usual and not fit.track.discrepancy.is_usual


def _unlike(track: Track, laws: Sequence[LawCandidate]) -> list[LawCandidate]:
    """Return the laws less those of a kind and side whose places move like that of one before: see `with_neighbours`,
    which finds these.
    """
    found, known = list[LawCandidate](), dict[object, list[FloatArray]]()
    for law in laws:
        along = law.pull @ track.spaces[0].shapes
        along = along / max(float(np.linalg.norm(along)), TINY)
        others = known.setdefault((law.kind, law.location.get("side")), [])
        if all(abs(float(along @ other)) < LAW_FIT.min_cosine for other in others):
            others.append(along)
            found.append(law)
    return found


def _nearest(track: Track, best: LawCandidate, laws: Sequence[LawCandidate]) -> list[LawCandidate]:
    """Return the laws of the same kind and side as the best, those first whose places move most alike."""
    shapes, side = track.spaces[0].shapes, best.location.get("side")
    alike = [law for law in laws if law.kind == best.kind and law.location.get("side") == side]
    return sorted(alike, key=lambda law: -_likeness(best.pull @ shapes, law.pull @ shapes))


def _likeness(one: FloatArray, other: FloatArray) -> float:
    """Return the cosine, whatever its sign, between two places' shares (mode,) in all modes."""
    sizes = float(np.linalg.norm(one)) * float(np.linalg.norm(other))
    return abs(float(one @ other)) / max(sizes, TINY)


def with_probabilities(track: Track, fits: Sequence[LawFit], odds: Odds) -> LawSearch:
    """Return laws with their probabilities, most probable first; what a law only resembles is another one that is not
    on the list, or what any model gets wrong, as the discrepancy without it is usual or not.
    """
    scores = np.array([fit.evidence + odds.log(fit.candidate) for fit in fits]) + np.log1p(-PRIOR_NOTHING_WRONG)
    by_evidence = np.argsort(-scores)
    every = np.append(scores[by_evidence], track.evidence + np.log(PRIOR_NOTHING_WRONG))
    weights = np.exp(every - every.max())
    weights /= weights.sum()
    before, after = track.discrepancy.whole, [fits[number].track.discrepancy.whole for number in by_evidence]
    found = weights[:-1] * np.array([right_law_probability(before, own) for own in after])
    usual, rest = track.discrepancy.usual_probability, float(weights[:-1].sum() - found.sum())
    none, other = float(weights[-1]) + usual * rest, (1 - usual) * rest
    by_probability = np.argsort(-found, kind="stable")
    ranked = tuple(fits[number] for number in by_evidence[by_probability])
    return LawSearch(track, ranked, found[by_probability], none, other)


def _candidates(track: Track) -> tuple[LawCandidate, ...]:
    """Return all force laws at all places, their priors by the motion as the filter knows it."""
    shapes, n = track.spaces[0].shapes, track.spaces[0].count
    states = np.concatenate([known.states for known in track.filtered])
    motion = Motion(states[:, :n] @ shapes.T, states[:, n:] @ shapes.T)
    channels = tuple(Channel(sensor.name, 1.0, 1.0) for sensor in track.claimed.measured.sensors)
    found = candidates_of(Known(track.nominal, motion, channels))
    return tuple(own for own in found if isinstance(own, LawCandidate) and is_followed(own))
