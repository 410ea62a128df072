"""Which force law the recordings ask for, at which place: all are screened, the best are fitted.

A law is named by what it leaves. What is not on the list is followed in part by whatever is most like it; the right law
leaves no more of the discrepancy than any right model does. Beforehand one is as probable as the other: the
discrepancy's size then has its usual distribution, and what a law that only resembles the right one leaves of its
energy may be any share.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import norm

from fe_models.arrays import FloatArray
from fe_models.causes.candidate import LawCandidate
from fe_models.causes.known import Channel, Known
from fe_models.causes.places import Motion
from fe_models.causes.searched import candidates_of
from hybrid.diagnosis.contest.odds import Odds
from hybrid.diagnosis.contest.posterior import NOTHING
from hybrid.diagnosis.discrepancy.config import DISCREPANCY, LAW_FIT
from hybrid.diagnosis.discrepancy.law_fit import LawFit, best_theta, fit_law, response
from hybrid.diagnosis.discrepancy.tracking import Track
from hybrid.diagnosis.modal.claim import Measured
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.parallel import parallel_map


@dataclass(frozen=True, eq=False)
class LawSearch:
    """The ``track`` without a law; the ``fits`` of laws, most probable first, with their ``probabilities`` (law,); what
    is left over is that no law acts (``none``), or one that is not on the list (``other``).
    """

    track: Track
    fits: tuple[LawFit, ...]
    probabilities: FloatArray
    none: float
    other: float

    @property
    def best(self) -> LawFit | None:
        """The most probable law, None where most probably none acts."""
        return self.fits[0] if self.fits and self.none < float(self.probabilities.sum()) + self.other else None

    @property
    def explains(self) -> float:
        """The share of the discrepancy's energy that the most probable law takes away."""
        best = self.best
        return 0.0 if best is None else float(np.clip(1 - (best.track.size / self.track.size) ** 2, 0.0, 1.0))


def search_laws(item: Track, measured: Measured) -> LawSearch:
    """Return the force laws that a track's motions ask for."""
    laws = _candidates(item, measured)
    if not laws:
        return LawSearch(item, (), np.zeros(0), 1.0, 0.0)
    nominal, odds = measured.nominal, Odds.among(laws, 1.0)
    promise = _Promise.of(item, nominal)
    starts = [(promise.gain(law, theta), law, theta) for law in laws for theta in map(np.array, law.first_starts)]
    first = _best_of_each(starts)[: LAW_FIT.fitted]

    def fitted(start: tuple[float, LawCandidate, FloatArray]) -> tuple[float, LawCandidate, FloatArray]:
        _, law, theta = start
        theta, _, evidence = best_theta(item, nominal, law, theta, LAW_FIT.steps, None)
        return evidence + odds.log(law), law, theta

    ranked = _best_of_each(parallel_map(fitted, first))[: LAW_FIT.refined]
    fits = parallel_map(lambda start: fit_law(item, nominal, start[1], start[2]), ranked)
    return _concluded(item, fits, odds)


def _concluded(item: Track, fits: Sequence[LawFit], odds: Odds) -> LawSearch:
    scores = np.array([fit.evidence + odds.log(fit.candidate) for fit in fits]) + np.log1p(-NOTHING)
    order = np.argsort(-scores)
    every = np.append(scores[order], item.evidence + np.log(NOTHING))
    weights = np.exp(every - every.max())
    weights = weights / weights.sum()
    right = np.array([share_right(item.size, fits[number].track.size) for number in order])
    found = weights[:-1] * right
    other = float(weights[:-1].sum() - found.sum())
    return LawSearch(item, tuple(fits[number] for number in order), found, float(weights[-1]), other)


def share_right(before: float, after: float) -> float:
    """Return how probable it is that a law is the right one, as it changes the discrepancy's size from ``before`` to
    ``after``, rather than one that resembles another.

    That of a right model has a log-normal distribution; a law like another leaves any share of the energy: a share
    (after / before)^2 that is uniform has the density 2 (after / before)^2 over the logarithm of the size.
    """
    right = norm.pdf(np.log(after), np.log(DISCREPANCY.usual_size), DISCREPANCY.usual_spread)
    alike = 2 * min(after / before, 1.0) ** 2
    return float(right / (right + alike))


def _candidates(item: Track, measured: Measured) -> tuple[LawCandidate, ...]:
    """Return all force laws at all places, their priors by the motion as the filter knows it."""
    shapes, n = item.spaces[0].shapes, item.spaces[0].count
    states = np.concatenate([known.states for known in item.found])
    motion = Motion(states[:, :n] @ shapes.T, states[:, n:] @ shapes.T)
    channels = tuple(Channel(sensor.name, 1.0, 1.0) for sensor in measured.sensors)
    found = candidates_of(Known(measured.nominal, motion, channels))
    return tuple(candidate for candidate in found if isinstance(candidate, LawCandidate))


def _best_of_each(
    starts: Sequence[tuple[float, LawCandidate, FloatArray]],
) -> list[tuple[float, LawCandidate, FloatArray]]:
    """Return the best start of each law, most promising first."""
    best: dict[str, tuple[float, LawCandidate, FloatArray]] = {}
    for start in starts:
        known = best.get(start[1].key)
        if known is None or start[0] > known[0]:
            best[start[1].key] = start
    return sorted(best.values(), key=lambda start: -start[0])


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
