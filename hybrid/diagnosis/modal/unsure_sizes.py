"""Standard deviations that count that the sizes of errors, estimated from the same modes, are none too sure themselves.

Few modes tell sizes, so that the posterior of their logarithms is no normal one: its tails reach far upwards. Sizes are
drawn from it (`elliptical_slices`), whatever the causes' own values are; Laplace's approximation about the most likely
ones shows where. A fit's covariance is that of a mixture over such sizes: what it is on average, and how the best
values move.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import block_diag

from fe_models.arrays import TINY, FloatArray
from hybrid.diagnosis.modal.config import UNSURE_SIZES
from hybrid.diagnosis.modal.elliptical_slices import slice_samples
from hybrid.diagnosis.modal.error_sizes import (
    LOG_LOWER,
    LOG_ROOT,
    LOG_UPPER,
    NOMINAL_KINDS,
    NOMINAL_SCALES,
    sizes_at,
)
from hybrid.diagnosis.modal.evidence import ModalFit, step_of, with_errors
from hybrid.diagnosis.modal.likely_errors import Likelihood
from hybrid.diagnosis.modal.modal_data import ModalData


@dataclass(frozen=True, eq=False)
class SizesPosterior:
    """A posterior over all sizes of errors, each as probable as any other: the best values (size, parameter) of each,
    ``theta``, and their ``covariances`` (size, parameter, parameter).
    """

    theta: FloatArray
    covariances: FloatArray

    def about(self, theta: FloatArray) -> FloatArray:
        """Return the mean squares and products (parameter, parameter) of how far values are from ``theta``."""
        off = self.theta - theta
        return np.asarray(self.covariances.mean(axis=0) + off.T @ off / len(off))

    def draws(self, count: int, rng: np.random.Generator) -> FloatArray:
        """Return ``count`` draws (draw, parameter) of it."""
        which = rng.integers(len(self.theta), size=count)
        drawn = [rng.multivariate_normal(self.theta[k], self.covariances[k], method="eigh") for k in which]
        return np.array(drawn)


def with_unsure_sizes(measured: ModalData, item: ModalFit) -> ModalFit:
    """Return a fit with the covariance of its values over all sizes of errors that they leave open."""
    found = posterior_over_sizes(measured, item)
    return item if found is None else replace(item, covariance=found.about(item.theta))


def posterior_over_sizes(measured: ModalData, item: ModalFit) -> SizesPosterior | None:
    """Return the posterior of a fit's values over all sizes of errors that they leave open; None where no numbers hold
    these.
    """
    if not len(item.pairs):
        return None
    try:
        drawn = _drawn_sizes(item)
    except np.linalg.LinAlgError:
        return None
    within, moved = list[FloatArray](), list[FloatArray]()
    for logs in drawn:
        try:
            own = with_errors(measured, item, sizes_at(logs))
        except np.linalg.LinAlgError:
            continue
        within.append(own.covariance)
        moved.append(item.theta + step_of(measured, own))
    return SizesPosterior(np.array(moved), np.array(within)) if within else None


def likelihood_of_sizes(item: ModalFit) -> Likelihood:
    """Return how likely sizes are whatever a fit's causes' own values are, marginalised as nominal values are."""
    rows, hypothesis, first = item.rows, item.claim.hypothesis, item.nuisances
    width, off = hypothesis.width[first:], item.theta[first:] - hypothesis.centre[first:]
    every = replace(
        rows,
        slopes=item.slopes,
        spread=np.concatenate([rows.spread, width]),
        correlation_root=block_diag(rows.correlation_root, np.eye(len(width))),
        kinds=(*rows.kinds, *[""] * len(width)),
    )
    return Likelihood(every, item.residual + item.slopes[:, first:] @ off)


def _drawn_sizes(item: ModalFit) -> FloatArray:
    """Return logarithms of sizes (draw, size) that a fit leaves open."""
    likelihood, likeliest, largest = likelihood_of_sizes(item), np.log(item.sizes.values), _largest(item)

    def log_density(logs: FloatArray) -> float:
        if (logs < LOG_LOWER).any() or (logs > largest).any():
            return -np.inf
        sizes = sizes_at(logs)
        try:
            return likelihood.value(sizes) + sizes.log_prior
        except np.linalg.LinAlgError:  # sizes so small that no numbers hold them
            return -np.inf

    root, rng = _root_of_covariance(likelihood, likeliest), np.random.default_rng(0)
    return slice_samples(log_density, likeliest, root, UNSURE_SIZES.draws, UNSURE_SIZES.between, rng)


def _root_of_covariance(likelihood: Likelihood, logs: FloatArray) -> FloatArray:
    """Return a square root (size, size) of Laplace's covariance about ``logs`` (size,); nowhere beyond the priors'."""
    steps = UNSURE_SIZES.difference_step * np.eye(len(logs))
    slopes = [(likelihood.at(sizes_at(logs + own))[1] - likelihood.at(sizes_at(logs - own))[1]) for own in steps]
    curvature = -np.array(slopes) / (2 * UNSURE_SIZES.difference_step)
    scaled = LOG_ROOT.T @ ((curvature + curvature.T) / 2) @ LOG_ROOT  # in units of the priors
    values, vectors = np.linalg.eigh(scaled)
    return np.asarray(LOG_ROOT @ vectors / np.sqrt(1 + np.maximum(values, 0.0)))


def _largest(item: ModalFit) -> FloatArray:
    """Return the logarithms of the largest sizes (size,) that are drawn, none below the most likely one."""
    kinds, found = np.array(item.rows.kinds), LOG_UPPER.copy()
    for kind, scale in zip(NOMINAL_KINDS, NOMINAL_SCALES, strict=True):
        stated = item.rows.spread[kinds == kind].max(initial=TINY)
        found[scale] = min(np.log(UNSURE_SIZES.max_deviation / stated), found[scale])
    return np.maximum(found, np.log(item.sizes.values))
