"""Standard deviations that count that the sizes of errors, estimated from the same modes, are none too sure themselves.

Their logarithms are normal about the most likely ones, with the curvature of the likelihood there and their priors'
(Laplace), but for the scales of stiffnesses and masses, which few parts tell: these go as the likelihood says on a grid
(the marginal of each is skewed, with a long tail upwards), the other sizes as is most likely beside them. A fit's
covariance is that of a mixture over such sizes: what it is on average, and how the best values move.
"""

from dataclasses import dataclass, replace

import numpy as np

from fe_models.arrays import TINY, FloatArray
from hybrid.diagnosis.modal.config import UNSURE_SIZES
from hybrid.diagnosis.modal.error_sizes import (
    LOG_LOWER,
    LOG_ROOT,
    LOG_UPPER,
    NOMINAL_KINDS,
    NOMINAL_SCALES,
    sizes_of,
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
            own = with_errors(measured, item, sizes_of(np.clip(logs, LOG_LOWER, LOG_UPPER)))
        except np.linalg.LinAlgError:  # sizes so small that no numbers hold them
            continue
        within.append(own.covariance)
        moved.append(item.theta + step_of(measured, own))
    return SizesPosterior(np.array(moved), np.array(within)) if within else None


def _drawn_sizes(item: ModalFit) -> FloatArray:
    """Return logarithms of sizes (draw, size) that a fit leaves open."""
    rng, root, logs = np.random.default_rng(0), _root_of_covariance(item), np.log(item.sizes.values)
    covariance, scales = root @ root.T, list(NOMINAL_SCALES)
    others = [number for number in range(len(logs)) if number not in scales]
    along = covariance[np.ix_(others, scales)] @ np.linalg.inv(covariance[np.ix_(scales, scales)])
    beside = np.linalg.cholesky(
        covariance[np.ix_(others, others)] - along @ covariance[np.ix_(scales, others)]
    )  # of the other sizes, given both scales
    normal = rng.standard_normal((UNSURE_SIZES.draws // 2, len(others)))
    normal = np.concatenate([normal, -normal])  # either side of each, so that their mean is that of the sizes
    found = np.empty((len(normal), len(logs)))
    found[:, scales] = _drawn_scales(item, logs, others, along, rng)
    found[:, others] = logs[others] + (found[:, scales] - logs[scales]) @ along.T + normal @ beside.T
    return found


def _drawn_scales(
    item: ModalFit, logs: FloatArray, others: list[int], along: FloatArray, rng: np.random.Generator
) -> FloatArray:
    """Return logarithms of the scales (draw, scale), as likely as the modes say where the ``others`` go ``along``."""
    likelihood, scales = Likelihood(item.rows, item.residual), list(NOMINAL_SCALES)
    sides = [
        np.linspace(LOG_LOWER[own], most, UNSURE_SIZES.grid) for own, most in zip(scales, _largest(item), strict=True)
    ]
    cells = np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1).reshape(-1, len(scales))
    density = np.empty(len(cells))
    for number, cell in enumerate(cells):
        tried = logs.copy()
        tried[scales] = cell
        tried[others] = np.clip(logs[others] + along @ (cell - logs[scales]), LOG_LOWER[others], LOG_UPPER[others])
        sizes = sizes_of(tried)
        density[number] = likelihood.at(sizes)[0] + sizes.log_prior
    shares = np.cumsum(np.exp(density - density.max()))
    even = (np.arange(UNSURE_SIZES.draws) + 0.5) / UNSURE_SIZES.draws  # spread evenly over what is likely
    chosen = cells[np.searchsorted(shares, even * shares[-1])]
    width = np.array([side[1] - side[0] for side in sides])
    return np.asarray(rng.permutation(chosen + width * (rng.random(chosen.shape) - 0.5)))


def _largest(item: ModalFit) -> FloatArray:
    """Return the logarithms of the largest scales (scale,) that are drawn, none below the most likely one."""
    kinds, scales = np.array(item.rows.kinds), list(NOMINAL_SCALES)
    stated = np.array([item.rows.spread[kinds == kind].max(initial=TINY) for kind in NOMINAL_KINDS])
    return np.clip(np.log(UNSURE_SIZES.max_deviation / stated), np.log(item.sizes.values)[scales], LOG_UPPER[scales])


def _root_of_covariance(item: ModalFit) -> FloatArray:
    """Return a square root (size, size) of the covariance of the sizes' logarithms; nowhere beyond their priors'."""
    logs, likelihood = np.log(item.sizes.values), Likelihood(item.rows, item.residual)
    steps = UNSURE_SIZES.difference_step * np.eye(len(logs))
    slopes = [(likelihood.at(sizes_of(logs + own))[1] - likelihood.at(sizes_of(logs - own))[1]) for own in steps]
    curvature = -np.array(slopes) / (2 * UNSURE_SIZES.difference_step)
    scaled = LOG_ROOT.T @ ((curvature + curvature.T) / 2) @ LOG_ROOT  # in units of the priors
    values, vectors = np.linalg.eigh(scaled)
    return np.asarray(LOG_ROOT @ vectors / np.sqrt(1 + np.maximum(values, 0.0)))
