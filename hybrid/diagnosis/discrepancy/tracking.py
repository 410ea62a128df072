"""All recordings as a claim expects them: how they move, and how probable that is with one discrepancy."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fe_models.arrays import FloatArray
from hybrid.diagnosis.discrepancy.expected_modes import Claimed, Expectation, ExpectedModes, slopes_over_time
from hybrid.diagnosis.discrepancy.following import Followed, filtered_by
from hybrid.diagnosis.discrepancy.kalman import Filtered, unexpected
from hybrid.diagnosis.discrepancy.marginal import Marginal
from hybrid.diagnosis.discrepancy.modal_space import ModalSpace
from hybrid.diagnosis.discrepancy.size import Discrepancy
from hybrid.diagnosis.parallel import parallel_map

BY_TIME = "data", "shown", "amplitude"
SHORTENING = 0.95  # of motions, step by step, until all are short enough


@dataclass(frozen=True, eq=False)
class Track:
    """All motions with one ``discrepancy``: what is ``claimed``, the ``expected`` modes, what was ``followed``, what
    the filter ``found`` in each motion, its ``residuals``, white (time sensor,), the ``marginal`` that weighs these,
    and the log ``evidence`` of all.
    """

    discrepancy: Discrepancy
    claimed: Claimed
    expected: Expectation
    followed: tuple[Followed, ...]
    found: tuple[Filtered, ...]
    residuals: tuple[FloatArray, ...]
    marginal: Marginal
    evidence: float

    @cached_property
    def between(self) -> tuple[tuple[FloatArray, FloatArray], ...]:
        """The states within the steps, q and q' (part, mode), of each motion."""
        return tuple(space.between(known.states) for space, known in zip(self.spaces, self.found, strict=True))

    @cached_property
    def log_posterior(self) -> float:
        """The log density of the motions and of the values of all modes, where these are."""
        white = [known.white.ravel() for known in self.found]
        return self.marginal.log_density_here(white) + sum(known.log_scale for known in self.found)

    @property
    def spaces(self) -> tuple[ModalSpace, ...]:
        """The state space of each motion."""
        return tuple(modes.space for modes in self.expected.modes)


def track(claimed: Claimed, expected: Expectation, motions: Sequence[Followed], discrepancy: Discrepancy) -> Track:
    """Return the motions as they are with a ``discrepancy``."""

    def one(item: tuple[ExpectedModes, Followed]) -> tuple[Filtered, FloatArray]:
        modes, own = item
        known = filtered_by(modes.space, own, discrepancy)
        parts, between = [], modes.space.between(known.states)
        for mode in range(modes.space.count):
            rows = unexpected(known, *slopes_over_time(modes, known.states, between, mode))
            parts.append(rows.reshape(len(rows), -1))
        return known, np.concatenate(parts).T

    found, slopes = zip(*parallel_map(one, list(zip(expected.modes, motions, strict=True))), strict=True)
    marginal = Marginal.of(slopes, expected)
    residuals = tuple(marginal.centred([known.white.ravel() for known in found]))
    evidence = marginal.log_density(residuals) + sum(known.log_scale for known in found) + discrepancy.log_prior
    return Track(discrepancy, claimed, expected, tuple(motions), found, residuals, marginal, float(evidence))


def samples_in(item: Track, most_values: float) -> int:
    """Return how many samples of a track's motions have so many values: each times modes and sensors."""
    space = item.spaces[0]
    return round(most_values / (space.count * len(space.shown)))


def shortened(item: Track, samples: int) -> Track:
    """Return the track of the first part of all motions, of so many ``samples`` in all."""
    motions = item.followed
    longest = max(len(own.data) for own in motions)
    while longest > 1 and sum(min(len(own.data), longest) for own in motions) > samples:
        longest = int(longest * SHORTENING)
    if longest == max(len(own.data) for own in motions):
        return item
    part = slice(longest)
    short = [replace(own, **{name: getattr(own, name)[part] for name in BY_TIME}, motion=None) for own in motions]
    return track(item.claimed, item.expected, short, item.discrepancy)
