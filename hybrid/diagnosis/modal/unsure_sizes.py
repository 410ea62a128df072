"""Standard deviations that count that the sizes of errors, estimated from the same modes, are none too sure themselves.

Their logarithms are normal about the most likely ones, with the curvature of the likelihood there and their priors'
(Laplace); a fit's covariance is that of a mixture over such sizes: what it is on average, and how the best values move.
"""

from dataclasses import dataclass, replace

import numpy as np

from fe_models.arrays import FloatArray
from hybrid.diagnosis.modal.config import UNSURE_SIZES
from hybrid.diagnosis.modal.error_sizes import LOG_LOWER, LOG_SPREADS, LOG_UPPER, sizes_of
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
        logs, root = np.log(item.sizes.values), _root_of_covariance(item)
    except np.linalg.LinAlgError:
        return None
    drawn = np.random.default_rng(0).standard_normal((UNSURE_SIZES.draws // 2, len(logs)))
    within, moved = list[FloatArray](), list[FloatArray]()
    for off in np.concatenate([drawn, -drawn]):  # either side of each, so that their mean is that of the sizes
        try:
            own = with_errors(measured, item, sizes_of(np.clip(logs + root @ off, LOG_LOWER, LOG_UPPER)))
        except np.linalg.LinAlgError:  # sizes so small that no numbers hold them
            continue
        within.append(own.covariance)
        moved.append(item.theta + step_of(measured, own))
    return SizesPosterior(np.array(moved), np.array(within)) if within else None


def _root_of_covariance(item: ModalFit) -> FloatArray:
    """Return a square root (size, size) of the covariance of the sizes' logarithms; nowhere beyond their priors'."""
    logs, likelihood = np.log(item.sizes.values), Likelihood(item.rows, item.residual)
    steps = UNSURE_SIZES.difference_step * np.eye(len(logs))
    slopes = [(likelihood.at(sizes_of(logs + own))[1] - likelihood.at(sizes_of(logs - own))[1]) for own in steps]
    curvature = -np.array(slopes) / (2 * UNSURE_SIZES.difference_step)
    scaled = LOG_SPREADS[:, None] * (curvature + curvature.T) / 2 * LOG_SPREADS  # in units of the priors
    values, vectors = np.linalg.eigh(scaled)
    return np.asarray(LOG_SPREADS[:, None] * vectors / np.sqrt(1 + np.maximum(values, 0.0)))
