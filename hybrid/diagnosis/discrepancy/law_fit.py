"""The parameters of a force law that explain most of what a filter did not expect.

Its force is taken along the motion as the filter knows it, so that the channels are linear in the force; motion and
parameters are found in turn. What disturbs (nominal values, errors of models, initial states) is marginalised.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes.candidate import LawCandidate
from hybrid.diagnosis.discrepancy.config import DISCREPANCY, LAW_FIT
from hybrid.diagnosis.discrepancy.expected_modes import Expectation
from hybrid.diagnosis.discrepancy.kalman import unexpected
from hybrid.diagnosis.discrepancy.tracking import Followed, Push, Track, most_probable
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


def pushes_of(item: Track, nominal: NominalModel, law: LawCandidate, theta: FloatArray) -> list[Push]:
    """Return what a law of ``theta`` (parameter,) does to each motion, as the structure moves there."""
    force = force_of(law, nominal, theta[None], np.ones((1, len(nominal.parts))))
    pushes = []
    for space, (q, rate) in zip(item.spaces, item.between, strict=True):
        along = law.pull @ space.shapes
        pulled = np.ravel(np.broadcast_to(force((q @ along)[None], (rate @ along)[None]), (1, len(q))))
        pushes.append(space.pushed(-pulled, law.pull))
    return pushes


def responses_of(item: Track, pushes: Sequence[Push]) -> list[FloatArray]:
    """Return what pushes make unexpected, white (time sensor,) of each motion."""
    return [
        unexpected(space, known, added[None], shown[None]).ravel()
        for space, known, (added, shown) in zip(item.spaces, item.found, pushes, strict=True)
    ]


def best_theta(
    item: Track, nominal: NominalModel, law: LawCandidate, theta: FloatArray, steps: int, within: FloatArray | None
) -> tuple[FloatArray, FloatArray, float]:
    """Return the best parameters from ``theta`` (parameter,), their covariance, and the log evidence, motion and
    discrepancy as in a track; ``within``: the parameters of the law that acts in the track already, None without.
    """
    width, neutral = np.array(law.width), np.array(law.neutral)
    lower, upper = np.array(law.lower), np.array(law.upper or (np.inf,) * len(width))

    def response(values: FloatArray) -> list[FloatArray]:
        return responses_of(item, pushes_of(item, nominal, law, values))

    there = [np.zeros_like(own) for own in item.residuals] if within is None else response(within)

    def left_by(values: list[FloatArray]) -> list[FloatArray]:
        return [own - now + before for own, now, before in zip(item.residuals, values, there, strict=True)]

    def log_posterior(left: list[FloatArray], at: FloatArray) -> float:
        columns = [own[:, None] for own in left]
        off = (at - neutral) / width
        return -0.5 * float(item.marginal.inner(columns, columns)[0, 0]) - 0.5 * float(off @ off)

    shown = response(theta)
    present, damping, normal = log_posterior(left_by(shown), theta), LAW_FIT.first_damping, np.diag(1 / width**2)
    for _ in range(steps):
        slopes = [np.zeros((len(own), len(width))) for own in shown]
        for number in range(len(width)):
            moved = theta.copy()
            step = LAW_FIT.difference_step * width[number]
            step = -step if theta[number] + step > upper[number] else step
            moved[number] += step
            for own, before, after in zip(slopes, shown, response(moved), strict=True):
                own[:, number] = (after - before) / step
        left = [own[:, None] for own in left_by(shown)]
        normal = item.marginal.inner(slopes, slopes) + np.diag(1 / width**2)
        along = item.marginal.inner(slopes, left)[:, 0] - (theta - neutral) / width**2
        gained = 0.0
        for _ in range(LAW_FIT.tries):
            then = np.clip(theta + np.linalg.solve(normal + damping * np.diag(np.diag(normal)), along), lower, upper)
            shown_then = response(then)
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
    return theta, np.linalg.inv(normal), present + scale + occam


def fit_law(
    item: Track, nominal: NominalModel, law: LawCandidate, theta: FloatArray, expected: Expectation | None = None
) -> LawFit:
    """Return the best fit of a law from ``theta`` (parameter,), motion and discrepancy found with it in turn."""
    best, size = None, item.size
    bare: tuple[Followed, ...] = item.followed
    for _ in range(LAW_FIT.rounds):
        pushes = pushes_of(item, nominal, law, theta)
        followed = [replace(own, push=_together(own.push, push)) for own, push in zip(bare, pushes, strict=True)]
        sizes = [size * factor for factor in LAW_FIT.shrinking if size * factor > DISCREPANCY.sizes[0]]
        item = most_probable(expected or item.expected, followed, sizes or [size])
        size = item.size
        theta, covariance, evidence = best_theta(item, nominal, law, theta, LAW_FIT.steps, theta)
        before = -np.inf if best is None else best.evidence
        if best is None or evidence > before:
            best = LawFit(law, theta, covariance, evidence, item)
        if evidence < before + LAW_FIT.settled_nats:
            break
    assert best is not None
    return best


def _together(one: Push | None, other: Push) -> Push:
    return other if one is None else (one[0] + other[0], one[1] + other[1])
