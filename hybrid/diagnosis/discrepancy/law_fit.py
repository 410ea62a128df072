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
from hybrid.diagnosis.discrepancy.tracking import Track, track
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.response.forces import force_of


@dataclass(frozen=True, eq=False)
class LawFit:
    """A law's ``candidate`` with its ``theta`` (parameter,) and their ``covariance``; log ``evidence``; the ``track``
    with the law in it, of which ``theta`` is the best.
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

    def along(u: FloatArray, v: FloatArray) -> FloatArray:
        return np.ravel(np.broadcast_to(force(u[None], v[None]), (1, len(u))))

    return DirectForce(law.pull, along)


def response(item: Track, nominal: NominalModel, law: LawCandidate, theta: FloatArray) -> list[FloatArray]:
    """Return what a law of ``theta`` (parameter,) makes unexpected, white (time sensor,) of each motion of a track."""
    acting, found = force_along(nominal, law, theta), []
    for space, known, between in zip(item.spaces, item.found, item.between, strict=True):
        added, shown = pushed_by(acting, space, between)
        found.append(unexpected(known, added[None], shown[None]).ravel())
    return found


def best_theta(
    item: Track, nominal: NominalModel, law: LawCandidate, theta: FloatArray, steps: int, within: FloatArray | None
) -> tuple[FloatArray, FloatArray, float]:
    """Return the best parameters from ``theta`` (parameter,), their covariance, and the log evidence.

    Motion and discrepancy are those of a track; ``within``: the parameters of the law that acts in it already, None
    without.
    """
    width, neutral = np.array(law.width), np.array(law.neutral)
    lower, upper = np.array(law.lower), np.array(law.upper or (np.inf,) * len(width))

    def made(values: FloatArray) -> list[FloatArray]:
        return response(item, nominal, law, values)

    there = [np.zeros_like(own) for own in item.residuals] if within is None else made(within)

    def left_by(values: list[FloatArray]) -> list[FloatArray]:
        return [own - now + before for own, now, before in zip(item.residuals, values, there, strict=True)]

    def log_posterior(left: list[FloatArray], at: FloatArray) -> float:
        columns = [own[:, None] for own in left]
        off = (at - neutral) / width
        return -0.5 * float(item.marginal.inner(columns, columns)[0, 0]) - 0.5 * float(off @ off)

    shown = made(theta)
    present, damping, normal = log_posterior(left_by(shown), theta), LAW_FIT.first_damping, np.diag(1 / width**2)
    for _ in range(steps):
        slopes = [np.zeros((len(own), len(width))) for own in shown]
        for number in range(len(width)):
            moved = theta.copy()
            step = LAW_FIT.difference_step * width[number]
            step = -step if theta[number] + step > upper[number] else step
            moved[number] += step
            for own, before, after in zip(slopes, shown, made(moved), strict=True):
                own[:, number] = (after - before) / step
        left = [own[:, None] for own in left_by(shown)]
        normal = item.marginal.inner(slopes, slopes) + np.diag(1 / width**2)
        along = item.marginal.inner(slopes, left)[:, 0] - (theta - neutral) / width**2
        gained = 0.0
        for _ in range(LAW_FIT.tries):
            then = np.clip(theta + np.linalg.solve(normal + damping * np.diag(np.diag(normal)), along), lower, upper)
            shown_then = made(then)
            value = log_posterior(left_by(shown_then), then)
            if value > present:
                gained, theta, shown, present = value - present, then, shown_then, value
                damping /= 10
                break
            damping *= 10
        if gained < LAW_FIT.converged_nats:
            break
    scale = item.evidence - log_posterior([*item.residuals], neutral)  # of the density, whatever the law
    occam = -0.5 * float(np.linalg.slogdet(normal * np.outer(width, width))[1])
    return theta, np.asarray(np.linalg.inv(normal), dtype=np.float64), present + scale + occam


def fit_law(
    item: Track, nominal: NominalModel, law: LawCandidate, theta: FloatArray, rounds: int = LAW_FIT.rounds
) -> LawFit:
    """Return the best fit of a law from ``theta`` (parameter,), motion and discrepancy found with it in turn.

    A force that answers to the motion at once, as friction does, makes the turns overshoot: where one fails, the next
    goes on from the best with half as much of the new motion.
    """
    bare, best, share, left = item, None, 1.0, item.discrepancy
    moving = item  # as whose motion the law's force is taken
    for _ in range(rounds):
        try:
            fit = _fit_once(bare, moving, nominal, law, theta, left, best.track.evidence if best else bare.evidence)
        except np.linalg.LinAlgError:  # a motion that grows beyond numbers
            fit = None
        gained = -np.inf if fit is None else fit.evidence - (best.evidence if best else -np.inf)
        if fit is not None and gained > 0:
            mixed = fit.track if best is None else _mixed(best.track, fit.track, share)
            best, moving, theta, left = replace(fit, track=mixed), mixed, fit.theta, fit.track.discrepancy
        elif best is None:
            break
        else:
            share *= LAW_FIT.easing
            moving = _mixed(best.track, fit.track, share) if fit else best.track
            theta, left = best.theta, best.track.discrepancy
        little = LAW_FIT.settled_share * max(best.evidence - item.evidence, 0.0)
        if abs(gained) < max(LAW_FIT.settled_nats, little) or share < LAW_FIT.least_share:
            break
    return best or LawFit(law, theta, np.diag(np.square(law.width)), -np.inf, bare)


def settled_law(fit: LawFit, nominal: NominalModel) -> LawFit:
    """Return a law's fit whose modes are where the recordings have them beside it: law and modes in turn."""
    for _ in range(SETTLING.turns):
        moved = settled(fit.track, [force_along(nominal, fit.candidate, fit.theta)])
        if moved is fit.track:
            break
        new = fit_law(moved, nominal, fit.candidate, fit.theta)
        gained = log_posterior_of(new.track) - log_posterior_of(fit.track)
        if gained > 0 and np.isfinite(new.evidence):
            fit = new
        if gained < SETTLING.settled_nats:
            break
    return fit


def _fit_once(
    bare: Track,
    moving: Track,
    nominal: NominalModel,
    law: LawCandidate,
    theta: FloatArray,
    left: Discrepancy,
    than: float,
) -> LawFit:
    """Return the law with its force along the motion of a track ``moving``, then a discrepancy with which that is more
    probable ``than`` before, if any is, then the law anew.
    """
    laws = [force_along(nominal, law, theta)]
    motions = [
        replace(own, motion=linearised(space, known.states, laws))
        for own, space, known in zip(bare.followed, moving.spaces, moving.found, strict=True)
    ]
    tried = list[Track]()
    for size in dict.fromkeys(left.times(factor, factor) for factor in LAW_FIT.shrinking):
        tried.append(track(bare.claimed, bare.expected, motions, size))
        if tried[-1].evidence > than:
            break
    item = max(tried, key=lambda own: own.evidence)
    theta, covariance, evidence = best_theta(item, nominal, law, theta, LAW_FIT.steps, theta)
    return LawFit(law, theta, covariance, evidence, item)


def _mixed(one: Track, other: Track, share: float) -> Track:
    """Return the ``other`` track with motions between both, nearer to it the larger its ``share``."""
    found = [
        replace(new, states=(1 - share) * old.states + share * new.states)
        for old, new in zip(one.found, other.found, strict=True)
    ]
    return replace(other, found=tuple(found))
