"""Modes as the recordings have them: the claim's parameters, and the errors that any model has, at their best values.

How a claim's modes change with its parameters is taken where these are. Forecasts go by the modes with the errors that
all recordings share: a real structure's are some thousandths off those of any model.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hybrid.diagnosis.discrepancy.config import SETTLING
from hybrid.diagnosis.discrepancy.expected_modes import Expectation, MotionClaim, expectation_of
from hybrid.diagnosis.discrepancy.following import likeliest_discrepancy
from hybrid.diagnosis.discrepancy.law_forces import LawForce
from hybrid.diagnosis.discrepancy.linearisation import linearised
from hybrid.diagnosis.discrepancy.tracking import Track, tracked
from hybrid.diagnosis.modal.evidence import bounded


def settled(track: Track, laws: Sequence[LawForce]) -> Track:
    """Return a track whose modes are where its recordings have them, under force ``laws``.

    By Newton's steps, each half as long as often as it makes the recordings less probable.
    """
    share = 1.0
    for _ in range(SETTLING.steps):
        new = _moved(track, share, laws)
        gained = -np.inf if new is None else log_posterior_of(new) - log_posterior_of(track)
        if new is not None and gained > 0:
            track, share = new, min(share / SETTLING.easing, 1.0)
        else:
            share *= SETTLING.easing
        if abs(gained) < SETTLING.settled_nats or share < SETTLING.min_share:
            break
    return track


def log_posterior_of(track: Track) -> float:
    """Return the log density of a track's motions and of all values, where these are."""
    return track.log_posterior + track.discrepancy.log_prior


def _moved(track: Track, share: float, laws: Sequence[LawForce]) -> Track | None:
    """Return a track after a ``share`` of a step to where its recordings have all values; None where none is there."""
    step, errors = track.marginal.means(track.residuals)
    known = track.expected.modes[0]
    fit = track.claimed.fit
    theta = bounded(fit.claim.hypothesis, fit.theta, share * step)
    claimed = track.claimed.at(theta, known.reference)
    expected = expectation_of(claimed)
    if expected is None:
        return None
    try:
        return _with_modes(track, claimed, expected.moved_by(known.moved + share * (errors - known.moved)), laws)
    except np.linalg.LinAlgError:  # a motion that grows beyond numbers
        return None


def _with_modes(track: Track, claimed: MotionClaim, expected: Expectation, laws: Sequence[LawForce]) -> Track:
    """Return the track of the same motions with other modes."""
    motions = [
        replace(own, linearisation=linearised(modes.space, known.states, laws) if laws else None)
        for own, modes, known in zip(track.motions, expected.modes, track.filtered, strict=True)
    ]
    pairs = list(zip((modes.space for modes in expected.modes), motions, strict=True))
    return tracked(claimed, expected, motions, likeliest_discrepancy(pairs, track.discrepancy, SETTLING.factors))
