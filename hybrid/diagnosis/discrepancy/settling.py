"""Modes as the recordings have them: the claim's parameters, and the errors that any model has, at their best values.

How a claim's modes change with its parameters is taken where these are. Forecasts go by the modes with the errors that
all recordings share: a real structure's are some thousandths off those of any model.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hybrid.diagnosis.discrepancy.config import SETTLING
from hybrid.diagnosis.discrepancy.expected_modes import Claimed, Expectation, expectation_of
from hybrid.diagnosis.discrepancy.following import likeliest_discrepancy
from hybrid.diagnosis.discrepancy.law_forces import LawForce
from hybrid.diagnosis.discrepancy.linearisation import linearised
from hybrid.diagnosis.discrepancy.tracking import Track, track
from hybrid.diagnosis.modal.evidence import bounded


def settled(item: Track, laws: Sequence[LawForce]) -> Track:
    """Return a track whose modes are where its recordings have them, under force ``laws``.

    By Newton's steps, each half as long as often as it makes the recordings less probable.
    """
    share = 1.0
    for _ in range(SETTLING.steps):
        new = _moved(item, share, laws)
        gained = -np.inf if new is None else log_posterior_of(new) - log_posterior_of(item)
        if new is not None and gained > 0:
            item, share = new, min(share / SETTLING.easing, 1.0)
        else:
            share *= SETTLING.easing
        if abs(gained) < SETTLING.settled_nats or share < SETTLING.least_share:
            break
    return item


def log_posterior_of(item: Track) -> float:
    """Return the log density of a track's motions and of all values, where these are."""
    return item.log_posterior + item.discrepancy.log_prior


def _moved(item: Track, share: float, laws: Sequence[LawForce]) -> Track | None:
    """Return a track after a ``share`` of a step to where its recordings have all values; None where none is there."""
    step, errors = item.marginal.means(item.residuals)
    known = item.expected.modes
    fit = item.claimed.fit
    theta = bounded(fit.claim.hypothesis, fit.theta, share * step)
    claimed = item.claimed.at(theta, known[0].reference)
    expected = expectation_of(claimed)
    if expected is None:
        return None
    before = known[0].moved
    try:
        return _followed_by(item, claimed, expected.by(before + share * (errors - before)), laws)
    except np.linalg.LinAlgError:  # a motion that grows beyond numbers
        return None


def _followed_by(item: Track, claimed: Claimed, expected: Expectation, laws: Sequence[LawForce]) -> Track:
    """Return the track of the same motions with other modes."""
    motions = [
        replace(own, motion=linearised(modes.space, known.states, laws) if laws else None)
        for own, modes, known in zip(item.followed, expected.modes, item.found, strict=True)
    ]
    pairs = list(zip((modes.space for modes in expected.modes), motions, strict=True))
    return track(claimed, expected, motions, likeliest_discrepancy(pairs, item.discrepancy, SETTLING.factors))
