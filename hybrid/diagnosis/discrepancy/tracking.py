"""All recordings as a claim expects them: how they move, and how probable that is with one discrepancy."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fe_models.arrays import FloatArray
from hybrid.diagnosis.discrepancy.config import DISCREPANCY
from hybrid.diagnosis.discrepancy.expected_modes import Expectation, ExpectedModes, MotionClaim, slopes_over_time
from hybrid.diagnosis.discrepancy.following import FollowedMotion, filtered_by
from hybrid.diagnosis.discrepancy.kalman import FilteredMotion, unexpected
from hybrid.diagnosis.discrepancy.marginal import Marginal
from hybrid.diagnosis.discrepancy.modal_space import FineMotion, ModalSpace
from hybrid.diagnosis.discrepancy.size import Discrepancy
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.parallel import parallel_map

SHORTENING = 0.95  # of motions, step by step, until all are short enough


@dataclass(frozen=True, eq=False)
class Track:
    """All motions with one ``discrepancy``: what is ``claimed`` of them, the ``expected`` modes, the ``motions`` and
    what the filter makes of each (``filtered``), their ``residuals``, white (time sensor,), the ``marginal`` that
    weighs these, and the log ``evidence`` of all.
    """

    discrepancy: Discrepancy
    claimed: MotionClaim
    expected: Expectation
    motions: tuple[FollowedMotion, ...]
    filtered: tuple[FilteredMotion, ...]
    residuals: tuple[FloatArray, ...]
    marginal: Marginal
    evidence: float

    @cached_property
    def fine_motions(self) -> tuple[FineMotion, ...]:
        """Each motion, as the filter has it, within the steps."""
        return tuple(space.fine_motion(own.states) for space, own in zip(self.spaces, self.filtered, strict=True))

    @cached_property
    def log_posterior(self) -> float:
        """The log density of the motions and of the values of all modes, where these are."""
        white = [own.white.ravel() for own in self.filtered]
        return self.marginal.log_density_here(white) + sum(own.log_scale for own in self.filtered)

    @property
    def nominal(self) -> NominalModel:
        """The nominal model that the claim is about."""
        return self.claimed.measured.nominal

    @property
    def spaces(self) -> tuple[ModalSpace, ...]:
        """The state space of each motion."""
        return tuple(modes.space for modes in self.expected.modes)


def tracked(
    claimed: MotionClaim, expected: Expectation, motions: Sequence[FollowedMotion], discrepancy: Discrepancy
) -> Track:
    """Return the motions as they are with a ``discrepancy``."""
    both = parallel_map(
        lambda pair: _filtered_with_slopes(*pair, discrepancy), list(zip(expected.modes, motions, strict=True))
    )
    filtered, slopes = zip(*both, strict=True)
    marginal = Marginal.of(slopes, expected)
    residuals = tuple(marginal.centred([own.white.ravel() for own in filtered]))
    evidence = marginal.log_density(residuals) + sum(own.log_scale for own in filtered) + discrepancy.log_prior
    return Track(discrepancy, claimed, expected, tuple(motions), filtered, residuals, marginal, float(evidence))


def with_less_discrepancy(track: Track) -> Track:
    """Return a track with a smaller discrepancy as long as that is more probable: beside modes that are held where they
    are expected it may be many times as large as beside all that they may be.
    """
    while not track.discrepancy.is_small:
        less = track.discrepancy.times(DISCREPANCY.shrinking, DISCREPANCY.shrinking)
        found = tracked(track.claimed, track.expected, track.motions, less)
        if found.evidence <= track.evidence:
            break
        track = found
    return track


def _filtered_with_slopes(
    modes: ExpectedModes, motion: FollowedMotion, discrepancy: Discrepancy
) -> tuple[FilteredMotion, FloatArray]:
    """Return what the filter makes of a motion, and the slopes (time sensor, value) of its residual by all values."""
    filtered = filtered_by(modes.space, motion, discrepancy)
    parts, fine = [], modes.space.fine_motion(filtered.states)
    for mode in range(modes.space.count):
        rows = unexpected(filtered, *slopes_over_time(modes, filtered.states, fine, mode))
        parts.append(rows.reshape(len(rows), -1))
    return filtered, np.concatenate(parts).T


def samples_in(track: Track, most_values: float) -> int:
    """Return how many samples of a track's motions have so many values: each times modes and sensors."""
    space = track.spaces[0]
    return round(most_values / (space.count * len(space.shown)))


def shortened(track: Track, samples: int) -> Track:
    """Return the track of the first part of all motions, of so many ``samples`` in all."""
    lengths = [own.samples for own in track.motions]
    longest = max(lengths)
    while longest > 1 and sum(min(own, longest) for own in lengths) > samples:
        longest = int(longest * SHORTENING)
    if longest == max(lengths):
        return track
    return tracked(track.claimed, track.expected, [own.begin(longest) for own in track.motions], track.discrepancy)
