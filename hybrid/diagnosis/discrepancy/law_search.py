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
from hybrid.diagnosis.contest.posterior import NOTHING
from hybrid.diagnosis.discrepancy.config import LAW_FIT
from hybrid.diagnosis.discrepancy.law_fit import LawFit, best_theta, fit_law, is_followed, response, settled_law
from hybrid.diagnosis.discrepancy.size import right_law_probability
from hybrid.diagnosis.discrepancy.tracking import Track
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.parallel import parallel_map


@dataclass(frozen=True, eq=False)
class LawSearch:
    """The ``track`` without a law, beside a ``nominal`` model; the ``fits`` of laws, most probable first, with their
    ``probabilities`` (law,); what is left over is that no law acts (``none``), or one that is not on the list
    (``other``). ``replaces_causes``: whether laws were sought in the place of all other causes, or beside them.
    """

    track: Track
    nominal: NominalModel
    fits: tuple[LawFit, ...]
    probabilities: FloatArray
    none: float
    other: float
    replaces_causes: bool = True

    @property
    def log_evidence(self) -> float:
        """The log evidence of the most probable law, or of none."""
        return max([self.track.evidence, *(fit.evidence for fit in self.fits)])

    @property
    def named(self) -> LawFit | None:
        """The most probable law, None where most probably none of the list acts."""
        return self.fits[0] if self.fits and float(self.probabilities.sum()) > self.none + self.other else None


def search_laws(item: Track, measured: ModalData) -> LawSearch:
    """Return the force laws that a track's motions ask for."""
    laws = _candidates(item, measured)
    if not laws:
        return LawSearch(item, measured.nominal, (), np.zeros(0), 1.0, 0.0)
    nominal, odds = measured.nominal, Odds.among(laws, 1.0)
    promise = _Promise.of(item, nominal)

    def fitted(law: LawCandidate) -> LawFit:
        """Return the law along the motion as it is, from the start that promises most."""
        starts = [np.array(start) for start in law.first_starts]
        theta = max(starts, key=lambda start: promise.gain(law, start))
        theta, covariance, evidence = best_theta(item, nominal, law, theta, LAW_FIT.steps, None)
        return LawFit(law, theta, covariance, evidence, item)

    def score(fit: LawFit) -> float:
        return fit.evidence + odds.log(fit.candidate)

    def followed(some: Sequence[LawCandidate], count: int) -> list[LawFit]:
        """Return the best ``count`` of some laws, each with its own motion."""
        ranked = sorted(parallel_map(fitted, some), key=lambda fit: -score(fit))[:count]
        rounds = LAW_FIT.first_rounds
        return parallel_map(lambda fit: fit_law(item, nominal, fit.candidate, fit.theta, rounds), ranked)

    scanned = _unlike(item, laws)
    gains = parallel_map(lambda law: max(promise.gain(law, np.array(start)) for start in law.first_starts), scanned)
    promising = [scanned[number] for number in np.argsort(gains)[::-1][: LAW_FIT.fitted]]
    fits = followed(promising, LAW_FIT.refined)
    for _ in range(LAW_FIT.moves):
        best, known = max(fits, key=score), {fit.candidate.key for fit in fits}
        beside = [law for law in _nearest(item, best.candidate, laws) if law.key not in known][: LAW_FIT.neighbours]
        more = followed(beside, LAW_FIT.neighbours) if best.evidence > item.evidence else []
        fits += more
        if not more or max(map(score, more)) <= score(best):
            break
    ranked = sorted(fits, key=lambda fit: -score(fit))
    near = ranked[:1] + [fit for fit in ranked[1 : LAW_FIT.settled] if not _is_beaten(fit, ranked[0])]
    moved = parallel_map(lambda fit: settled_law(fit_law(item, nominal, fit.candidate, fit.theta), nominal), near)
    kept = {fit.candidate.key for fit in near}
    return _concluded(item, nominal, [*moved, *(fit for fit in ranked if fit.candidate.key not in kept)], odds)


def _is_beaten(fit: LawFit, best: LawFit) -> bool:
    """Return whether a law leaves more than a right model does where the best leaves no more."""
    return best.track.discrepancy.is_usual and not fit.track.discrepancy.is_usual


def _unlike(item: Track, laws: Sequence[LawCandidate]) -> list[LawCandidate]:
    """Return the laws less those of a kind and side whose places move like that of one before: a move finds these."""
    found, known = list[LawCandidate](), dict[object, list[FloatArray]]()
    for law in laws:
        along = law.pull @ item.spaces[0].shapes
        along = along / max(float(np.linalg.norm(along)), TINY)
        others = known.setdefault((law.kind, law.location.get("side")), [])
        if all(abs(float(along @ other)) < LAW_FIT.alike for other in others):
            others.append(along)
            found.append(law)
    return found


def _nearest(item: Track, best: LawCandidate, laws: Sequence[LawCandidate]) -> list[LawCandidate]:
    """Return the laws of the same kind and side as the best, those first whose places move most alike."""
    space, side = item.spaces[0], best.location.get("side")
    own = best.pull @ space.shapes
    alike = [law for law in laws if law.kind == best.kind and law.location.get("side") == side]

    def likeness(law: LawCandidate) -> float:
        other = law.pull @ space.shapes
        sizes = float(np.linalg.norm(own)) * float(np.linalg.norm(other))
        return abs(float(own @ other)) / max(sizes, TINY)

    return sorted(alike, key=lambda law: -likeness(law))


def _concluded(item: Track, nominal: NominalModel, fits: Sequence[LawFit], odds: Odds) -> LawSearch:
    """Return the laws with their probabilities; what a law only resembles is another one that is not on the list, or
    what any model gets wrong, as the discrepancy without it is usual or not.
    """
    scores = np.array([fit.evidence + odds.log(fit.candidate) for fit in fits]) + np.log1p(-NOTHING)
    order = np.argsort(-scores)
    every = np.append(scores[order], item.evidence + np.log(NOTHING))
    weights = np.exp(every - every.max())
    weights /= weights.sum()
    before, after = item.discrepancy.whole, [fits[number].track.discrepancy.whole for number in order]
    right = np.array([right_law_probability(before, own) for own in after])
    found = weights[:-1] * right
    usual, rest = item.discrepancy.usual_probability, float(weights[:-1].sum() - found.sum())
    none, other = float(weights[-1]) + usual * rest, (1 - usual) * rest
    first = np.argsort(-found, kind="stable")
    return LawSearch(item, nominal, tuple(fits[number] for number in order[first]), found[first], none, other)


def _candidates(item: Track, measured: ModalData) -> tuple[LawCandidate, ...]:
    """Return all force laws at all places, their priors by the motion as the filter knows it."""
    shapes, n = item.spaces[0].shapes, item.spaces[0].count
    states = np.concatenate([known.states for known in item.found])
    motion = Motion(states[:, :n] @ shapes.T, states[:, n:] @ shapes.T)
    channels = tuple(Channel(sensor.name, 1.0, 1.0) for sensor in measured.sensors)
    found = candidates_of(Known(measured.nominal, motion, channels))
    return tuple(own for own in found if isinstance(own, LawCandidate) and is_followed(own))


@dataclass(frozen=True, eq=False)
class _Promise:
    """What a law may gain whose force is as large as fits best: a step of least squares in its size alone."""

    item: Track
    nominal: NominalModel
    weighed: list[FloatArray]  # the residuals in the metric of what disturbs

    @classmethod
    def of(cls, item: Track, nominal: NominalModel) -> "_Promise":
        return cls(item, nominal, item.marginal.weighed(item.residuals))

    def gain(self, law: LawCandidate, theta: FloatArray) -> float:
        """Return the gain of the log density."""
        shown = response(self.item, self.nominal, law, theta)
        along = sum(float(a @ b) for a, b in zip(shown, self.weighed, strict=True))
        columns = [own[:, None] for own in shown]
        square = float(self.item.marginal.inner(columns, columns)[0, 0])
        return 0.5 * max(along, 0.0) ** 2 / square if square > 0 else 0.0
