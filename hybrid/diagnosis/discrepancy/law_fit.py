"""The parameters of a force law that explain most of what a filter did not expect.

Its force is taken along the motion as the filter knows it, so that the channels are linear in the force; motion and
parameters are found in turn. What disturbs (nominal values, errors of models, initial states) is marginalised.
"""

from dataclasses import dataclass, replace

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes import HystereticSpring
from fe_models.causes.candidate import LawCandidate
from hybrid.diagnosis.discrepancy.config import LAW_FIT, SETTLING
from hybrid.diagnosis.discrepancy.hysteresis import Hysteresis
from hybrid.diagnosis.discrepancy.kalman import unexpected
from hybrid.diagnosis.discrepancy.law_forces import DirectForce, LawForce, RememberedForce
from hybrid.diagnosis.discrepancy.linearisation import linearised, pushed_by
from hybrid.diagnosis.discrepancy.settling import log_posterior_of, settled
from hybrid.diagnosis.discrepancy.size import Discrepancy
from hybrid.diagnosis.discrepancy.tracking import Track, tracked
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.response.forces import force_of


@dataclass(frozen=True, eq=False)
class LawFit:
    """A law's ``candidate`` with its ``theta`` (parameter,) and their ``covariance``; log ``evidence``; the ``track``
    along whose motion ``theta`` is the best.
    """

    candidate: LawCandidate
    theta: FloatArray
    covariance: FloatArray
    evidence: float
    track: Track


def is_followed(law: LawCandidate) -> bool:
    """Return whether a law's force is known along a motion: of those with a memory, that of a `HystereticSpring`."""
    return not law.has_memory or isinstance(law.build(*law.first_starts[0]), HystereticSpring)


def force_along(nominal: NominalModel, law: LawCandidate, theta: FloatArray) -> LawForce:
    """Return the force of a law of ``theta`` (parameter,)."""
    spring = law.build(*theta.tolist())
    if isinstance(spring, HystereticSpring):
        return RememberedForce(law.pull, Hysteresis(spring))
    force = force_of(law, nominal, theta[None], np.ones((1, len(nominal.parts))))
    return DirectForce(law.pull, lambda u, v: np.ravel(np.broadcast_to(force(u[None], v[None]), (1, len(u)))))


def unexpected_by_law(track: Track, law: LawCandidate, theta: FloatArray) -> list[FloatArray]:
    """Return what a law of ``theta`` (parameter,) makes unexpected, white (time sensor,) of each motion of a track."""
    force, found = force_along(track.nominal, law, theta), []
    for space, known, motion in zip(track.spaces, track.filtered, track.fine_motions, strict=True):
        push = pushed_by(force, space, motion)
        found.append(unexpected(known, push.states[None], push.channels[None]).ravel())
    return found


@dataclass(frozen=True, eq=False)
class _LawResiduals:
    """What a ``law`` leaves of the residuals of a ``track``, in which its force has the part ``acting`` (time sensor,)
    already.
    """

    track: Track
    law: LawCandidate
    acting: list[FloatArray]

    def left_by(self, shown: list[FloatArray]) -> list[FloatArray]:
        """Return what is left (time sensor,) of each motion where the law makes unexpected what is ``shown``."""
        return [own - now + before for own, now, before in zip(self.track.residuals, shown, self.acting, strict=True)]

    def log_posterior(self, left: list[FloatArray], theta: FloatArray) -> float:
        """Return the log density of what is ``left``, and of ``theta``, but for constants."""
        columns = [own[:, None] for own in left]
        off = (theta - np.array(self.law.neutral)) / np.array(self.law.width)
        return -0.5 * float(self.track.marginal.inner(columns, columns)[0, 0]) - 0.5 * float(off @ off)

    def slopes(self, theta: FloatArray, shown: list[FloatArray]) -> list[FloatArray]:
        """Return the slopes (time sensor, parameter) of what is ``shown`` at ``theta``, by finite differences."""
        width, upper = np.array(self.law.width), self.upper
        slopes = [np.zeros((len(own), len(width))) for own in shown]
        for number in range(len(width)):
            moved = theta.copy()
            step = LAW_FIT.difference_step * width[number]
            step = -step if theta[number] + step > upper[number] else step
            moved[number] += step
            for own, before, after in zip(slopes, shown, unexpected_by_law(self.track, self.law, moved), strict=True):
                own[:, number] = (after - before) / step
        return slopes

    @property
    def upper(self) -> FloatArray:
        """The largest theta (parameter,)."""
        return np.array(self.law.upper or (np.inf,) * len(self.law.width))


def fit_along(track: Track, law: LawCandidate, theta: FloatArray, is_acting: bool) -> LawFit:
    """Return the best fit of a law from ``theta`` (parameter,), motion and discrepancy being those of a track.

    By Levenberg's and Marquardt's steps. ``is_acting``: whether the motion is that under the law of this theta already.
    """
    width, neutral, lower = np.array(law.width), np.array(law.neutral), np.array(law.lower)
    shown = unexpected_by_law(track, law, theta)
    residuals = _LawResiduals(track, law, shown if is_acting else [np.zeros_like(own) for own in track.residuals])
    present, damping = residuals.log_posterior(residuals.left_by(shown), theta), LAW_FIT.first_damping
    normal = np.diag(1 / width**2)
    for _ in range(LAW_FIT.steps):
        slopes = residuals.slopes(theta, shown)
        left = [own[:, None] for own in residuals.left_by(shown)]
        normal = track.marginal.inner(slopes, slopes) + np.diag(1 / width**2)
        along = track.marginal.inner(slopes, left)[:, 0] - (theta - neutral) / width**2
        gained = 0.0
        for _ in range(LAW_FIT.tries):
            step = np.linalg.solve(normal + damping * np.diag(np.diag(normal)), along)
            then = np.clip(theta + step, lower, residuals.upper)
            shown_then = unexpected_by_law(track, law, then)
            value = residuals.log_posterior(residuals.left_by(shown_then), then)
            if value > present:
                gained, theta, shown, present = value - present, then, shown_then, value
                damping /= 10
                break
            damping *= 10
        if gained < LAW_FIT.converged_nats:
            break
    scale = track.evidence - residuals.log_posterior([*track.residuals], neutral)  # of the density, whatever the law
    occam = -0.5 * float(np.linalg.slogdet(normal * np.outer(width, width))[1])
    covariance = np.asarray(np.linalg.inv(normal), dtype=np.float64)
    return LawFit(law, theta, covariance, present + scale + occam, track)


def fit_law(track: Track, law: LawCandidate, theta: FloatArray, rounds: int = LAW_FIT.rounds) -> LawFit:
    """Return the best fit of a law from ``theta`` (parameter,), motion and discrepancy found with it in turn, from a
    ``track`` without it.

    A force that answers to the motion at once, as friction does, makes the turns overshoot: where one fails, the next
    goes on from the best with half as much of the new motion.
    """
    best, share, discrepancy = None, 1.0, track.discrepancy
    moving = track  # as whose motion the law's force is taken
    for _ in range(rounds):
        try:
            evidence = best.track.evidence if best else track.evidence
            fit = _fit_once(track, moving, law, theta, discrepancy, evidence)
        except np.linalg.LinAlgError:  # a motion that grows beyond numbers
            fit = None
        gained = -np.inf if fit is None else fit.evidence - (best.evidence if best else -np.inf)
        if fit is not None and gained > 0:
            mixed = fit.track if best is None else _mixed(best.track, fit.track, share)
            best, moving, theta, discrepancy = replace(fit, track=mixed), mixed, fit.theta, fit.track.discrepancy
        elif best is None:
            break
        else:
            share *= LAW_FIT.easing
            moving = _mixed(best.track, fit.track, share) if fit else best.track
            theta, discrepancy = best.theta, best.track.discrepancy
        little = LAW_FIT.settled_share * max(best.evidence - track.evidence, 0.0)
        if abs(gained) < max(LAW_FIT.settled_nats, little) or share < LAW_FIT.min_share:
            break
    return best or LawFit(law, theta, np.diag(np.square(law.width)), -np.inf, track)


def settled_law(fit: LawFit) -> LawFit:
    """Return a law's fit whose modes are where the recordings have them beside it: law and modes in turn."""
    for _ in range(SETTLING.turns):
        moved = settled(fit.track, [force_along(fit.track.nominal, fit.candidate, fit.theta)])
        if moved is fit.track:
            break
        new = fit_law(moved, fit.candidate, fit.theta)
        gained = log_posterior_of(new.track) - log_posterior_of(fit.track)
        if gained > 0 and np.isfinite(new.evidence):
            fit = new
        if gained < SETTLING.settled_nats:
            break
    return fit


def refitted_law(track: Track, law: LawFit) -> LawFit:
    """Return a law that was fitted to other motions, or beside other modes, fitted and settled in a ``track``."""
    return settled_law(fit_law(track, law.candidate, law.theta))


def _fit_once(
    bare: Track, moving: Track, law: LawCandidate, theta: FloatArray, discrepancy: Discrepancy, evidence: float
) -> LawFit:
    """Return the law with its force along the motion of a track ``moving``, then the first smaller discrepancy that is
    more probable than the ``evidence`` before, or the most probable where none is, then the law anew.
    """
    laws = [force_along(bare.nominal, law, theta)]
    motions = [
        replace(own, linearisation=linearised(space, known.states, laws))
        for own, space, known in zip(bare.motions, moving.spaces, moving.filtered, strict=True)
    ]
    tried = list[Track]()
    for size in dict.fromkeys(discrepancy.times(factor, factor) for factor in LAW_FIT.shrinking):
        tried.append(tracked(bare.claimed, bare.expected, motions, size))
        if tried[-1].evidence > evidence:
            break
    return fit_along(max(tried, key=lambda own: own.evidence), law, theta, is_acting=True)


def _mixed(one: Track, other: Track, share: float) -> Track:
    """Return the ``other`` track with motions between both, nearer to it the larger its ``share``."""
    filtered = [
        replace(new, states=(1 - share) * old.states + share * new.states)
        for old, new in zip(one.filtered, other.filtered, strict=True)
    ]
    return replace(other, filtered=tuple(filtered))
