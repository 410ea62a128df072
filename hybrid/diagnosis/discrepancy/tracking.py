"""Recordings followed by a filter: how large the discrepancy is, and how the structure moves in them.

Of two kinds is what no model has: small forces on its modes, which let their phases drift, and what sensors show that
is none of these modes, as that of other ones or sums of frequencies. Both are in proportion to the motion.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.stats import norm

from fe_models.arrays import FloatArray
from hybrid.diagnosis.discrepancy.config import DISCREPANCY
from hybrid.diagnosis.discrepancy.expected_modes import Claimed, Expectation, ExpectedModes, slopes_over_time
from hybrid.diagnosis.discrepancy.kalman import Filtered, filtered, unexpected
from hybrid.diagnosis.discrepancy.linearisation import Linearisation, linear
from hybrid.diagnosis.discrepancy.marginal import Marginal
from hybrid.diagnosis.discrepancy.modal_space import ModalSpace
from hybrid.diagnosis.parallel import parallel_map


@dataclass(frozen=True, eq=False)
class Followed:
    """A motion: its ``data`` (time, sensor), the variance of their ``noise`` (sensor,), how large they are about each
    sample, ``shown`` (time, sensor), and the ``amplitude`` of q in each mode (time, mode); the motion under force laws,
    to first order, None where no law acts.
    """

    data: FloatArray
    noise: FloatArray
    shown: FloatArray
    amplitude: FloatArray
    motion: Linearisation | None = None


@dataclass(frozen=True)
class Discrepancy:
    """What differs from the motion of a model: forces on modes, of a ``size`` over the motion and a radian, and what
    sensors show besides, of a ``share`` of what they show.
    """

    size: float
    share: float

    @property
    def whole(self) -> float:
        """Both together."""
        return float(np.hypot(self.size, self.share))

    @property
    def log_prior(self) -> float:
        """The log density, over the logarithms of both."""
        return log_prior_of(self.size) + log_prior_of(self.share)

    def times(self, size: float, share: float) -> "Discrepancy":
        """Return the discrepancy with either part so many times as large, not beyond what can be told apart."""
        least, most = DISCREPANCY.least, DISCREPANCY.most
        return Discrepancy(*(float(np.clip(part, least, most)) for part in (self.size * size, self.share * share)))


BY_TIME = "data", "shown", "amplitude"
SHORTENING = 0.95  # of motions, step by step, until all are short enough
STARTED = Discrepancy(DISCREPANCY.usual_start, DISCREPANCY.usual_start)
"""From where the most probable one is sought."""


@dataclass(frozen=True, eq=False)
class Track:
    """All motions with one ``discrepancy``: what is ``claimed``, the ``expected`` modes, what was
    ``followed``, what the filter ``found`` in each motion, its ``residuals``, white (time sensor,), and the evidence of
    that, `Marginal`.
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


def followed(space: ModalSpace, data: FloatArray, noise: FloatArray) -> Followed:
    """Return a motion with how large it is, and each mode of it, over the period about each sample.

    As a filter shows it that lets each mode go its own way.
    """
    loosely = Discrepancy(DISCREPANCY.loose_size, DISCREPANCY.loose_share)
    envelope = _about(data**2, np.full(data.shape[1], float(space.omega.min())), space.step)
    shown = np.abs(space.shown).max(axis=0)
    even = np.broadcast_to(np.abs(data).max() / shown, (len(data), space.count))
    own = Followed(data, noise, np.sqrt(envelope), even)
    n = space.count
    for _ in range(DISCREPANCY.passes):  # a mode goes as freely as its own motion is large
        known = filtered_by(space, own, loosely)
        squared = _about(known.states[:, :n] ** 2 + (known.states[:, n:] / space.omega) ** 2, space.omega, space.step)
        least = DISCREPANCY.least_amplitude * np.sqrt((squared * shown**2).max()) / shown
        own = replace(own, amplitude=np.sqrt(squared + least**2))
    return own


def _about(squared: FloatArray, omega: FloatArray, step: float) -> FloatArray:
    """Return the mean of squares (time, column) over the period of each column's ``omega`` (rad/s) about each time."""
    smooth = np.zeros_like(squared)
    for column, own in enumerate(omega):
        width = min(max(round(2 * np.pi / own / step), 1), len(squared))
        kernel = np.ones(width) / width
        padded = np.pad(squared[:, column], (width // 2, width - 1 - width // 2), mode="edge")
        smooth[:, column] = np.convolve(padded, kernel, mode="valid")
    return smooth


def filtered_by(space: ModalSpace, own: Followed, discrepancy: Discrepancy) -> Filtered:
    """Return what a filter makes of a motion with a ``discrepancy``."""
    pushes = discrepancy.size**2 * space.omega**3 * space.step * own.amplitude**2
    begin = (DISCREPANCY.initial_amplitude * own.amplitude.max(axis=0)) ** 2
    variances = np.concatenate([begin, begin * space.omega**2])
    motion = own.motion or linear(space, len(own.data))
    noise = own.noise + (discrepancy.share * own.shown) ** 2
    return filtered(motion, own.data, noise, pushes, variances, space.step)


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


def shortened(item: Track, most_values: float) -> Track:
    """Return the track of the first part of all motions, of so many values, samples times modes and sensors, in all."""
    space, motions = item.spaces[0], item.followed
    samples = round(most_values / (space.count * len(space.shown)))
    longest = max(len(own.data) for own in motions)
    while longest > 1 and sum(min(len(own.data), longest) for own in motions) > samples:
        longest = int(longest * SHORTENING)
    if longest == max(len(own.data) for own in motions):
        return item
    part = slice(longest)
    short = [replace(own, **{name: getattr(own, name)[part] for name in BY_TIME}, motion=None) for own in motions]
    return track(item.claimed, item.expected, short, item.discrepancy)


def log_prior_of(size: float) -> float:
    """Return the log density, over its logarithm, of the discrepancy's size where a model is right: log-normal."""
    return float(norm.logpdf(np.log(size), np.log(DISCREPANCY.usual_size), DISCREPANCY.usual_spread))


def likeliest(
    motions: Sequence[tuple[ModalSpace, Followed]], start: Discrepancy, factors: Sequence[float]
) -> Discrepancy:
    """Return the discrepancy that is most probable in ``motions`` with their modes, from a ``start``: either part is
    changed by the ``factors``, the largest first, as long as it is better for it.
    """
    known: dict[Discrepancy, float] = {}

    def density(of: Discrepancy) -> float:
        if of not in known:
            found = parallel_map(lambda pair: filtered_by(*pair, of).log_density, motions)
            known[of] = sum(found) + of.log_prior
        return known[of]

    best = start
    for factor in factors:
        moved = True
        while moved:
            moved = False
            for change in ((factor, 1.0), (1 / factor, 1.0), (1.0, factor), (1.0, 1 / factor)):
                while density(then := best.times(*change)) > density(best):
                    best, moved = then, True
    return best
