"""Recordings followed by a filter: how large the discrepancy is, and how the structure moves in them."""

from collections.abc import Sequence
from dataclasses import dataclass
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
    """A motion: its ``data`` (time, sensor), the variance of their ``noise`` (sensor,), the ``amplitude`` of q in each
    mode (time, mode), and the motion under force laws, to first order, None where no law acts.
    """

    data: FloatArray
    noise: FloatArray
    amplitude: FloatArray
    motion: Linearisation | None = None


@dataclass(frozen=True, eq=False)
class Track:
    """All motions with a discrepancy of one ``size``: what is ``claimed``, the ``expected`` modes, what was
    ``followed``, what the filter ``found`` in each motion, its ``residuals``, white (time sensor,), and the evidence of
    that, `Marginal`.
    """

    size: float
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


def amplitudes_of(space: ModalSpace, data: FloatArray, noise: FloatArray) -> FloatArray:
    """Return how large each mode's motion q is (time, mode), over the period about each sample.

    As a filter shows it that lets each mode go its own way.
    """
    loosely = max(DISCREPANCY.sizes)
    shown = np.abs(space.shown).max(axis=0)
    even = np.broadcast_to(np.abs(data).max() / shown, (len(data), space.count))
    known = _filtered(space, Followed(data, noise, even), loosely)
    n = space.count
    squared = known.states[:, :n] ** 2 + (known.states[:, n:] / space.omega) ** 2
    smooth = np.zeros_like(squared)
    for mode, omega in enumerate(space.omega):
        width = min(max(round(2 * np.pi / omega / space.step), 1), len(data))
        kernel = np.ones(width) / width
        padded = np.pad(squared[:, mode], (width // 2, width - 1 - width // 2), mode="edge")
        smooth[:, mode] = np.convolve(padded, kernel, mode="valid")
    least = DISCREPANCY.least_amplitude * np.sqrt((squared * shown**2).max()) / shown
    return np.sqrt(smooth + least**2)


def _filtered(space: ModalSpace, own: Followed, size: float) -> Filtered:
    pushes = size**2 * space.omega**3 * space.step * own.amplitude**2
    begin = (DISCREPANCY.initial_amplitude * own.amplitude.max(axis=0)) ** 2
    variances = np.concatenate([begin, begin * space.omega**2])
    motion = own.motion or linear(space, len(own.data))
    return filtered(motion, own.data, own.noise, pushes, variances, space.step)


def track(claimed: Claimed, expected: Expectation, followed: Sequence[Followed], size: float) -> Track:
    """Return the motions as they are with a discrepancy of a ``size``."""

    def one(item: tuple[ExpectedModes, Followed]) -> tuple[Filtered, FloatArray]:
        modes, own = item
        known = _filtered(modes.space, own, size)
        parts, between = [], modes.space.between(known.states)
        for mode in range(modes.space.count):
            rows = unexpected(known, *slopes_over_time(modes, known.states, between, mode))
            parts.append(rows.reshape(len(rows), -1))
        return known, np.concatenate(parts).T

    found, slopes = zip(*parallel_map(one, list(zip(expected.modes, followed, strict=True))), strict=True)
    marginal = Marginal.of(slopes, expected)
    residuals = tuple(marginal.centred([known.white.ravel() for known in found]))
    evidence = marginal.log_density(residuals) + sum(known.log_scale for known in found) + log_prior_of(size)
    return Track(size, claimed, expected, tuple(followed), found, residuals, marginal, float(evidence))


def log_prior_of(size: float) -> float:
    """Return the log density, over its logarithm, of the discrepancy's size where a model is right: log-normal."""
    return float(norm.logpdf(np.log(size), np.log(DISCREPANCY.usual_size), DISCREPANCY.usual_spread))


def most_probable(
    claimed: Claimed, expected: Expectation, followed: Sequence[Followed], sizes: Sequence[float]
) -> Track:
    """Return the track with the most probable of the ``sizes``."""
    return max((track(claimed, expected, followed, size) for size in sizes), key=lambda item: item.evidence)


def tracked(claimed: Claimed, expected: Expectation, followed: Sequence[Followed]) -> Track:
    """Return the track with the most probable size of all."""
    best = most_probable(claimed, expected, followed, DISCREPANCY.sizes)
    return max(
        (best, *(track(claimed, expected, followed, best.size * factor) for factor in DISCREPANCY.finer)),
        key=lambda item: item.evidence,
    )
