"""The sizes of errors with which what is left of all modes is most likely (type II maximum likelihood).

Errors are shared by the rows of one mode of the structure alone, and nominal values are few. The covariance is that of
each mode, D, a block each, and what the nominal values move: D + S diag(w^2) S^T, whose inverse and determinant follow
from the blocks' (Woodbury). Blocks are padded to one size, so that all are worked on at once.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import solve_triangular
from scipy.optimize import minimize

from fe_models.arrays import BoolArray, FloatArray, IntArray
from hybrid.diagnosis.modal.error_sizes import (
    LOG_LOWER,
    LOG_MEDIANS,
    LOG_PRECISION,
    LOG_UPPER,
    SCALE_OF,
    SIZE_NAMES,
    ErrorSizes,
    sizes_at,
)
from hybrid.diagnosis.modal.mode_values import MODE_QUANTITIES
from hybrid.diagnosis.modal.rows import Rows


def likeliest_sizes(rows: Rows, residual: FloatArray, start: ErrorSizes, iterations: int) -> ErrorSizes:
    """Return the sizes with which a ``residual`` (row,) is most likely, beside their priors, sought from ``start``."""
    likelihood = Likelihood(rows, residual)

    def cost(logs: FloatArray) -> tuple[float, FloatArray]:
        sizes = sizes_at(logs)
        value, slope = likelihood.at(sizes)
        return -value - sizes.log_prior, -(slope - LOG_PRECISION @ (logs - LOG_MEDIANS))

    begun = np.clip(np.log(start.values), LOG_LOWER, LOG_UPPER)
    bounds = list(zip(LOG_LOWER, LOG_UPPER, strict=True))
    found = minimize(cost, begun, jac=True, method="L-BFGS-B", bounds=bounds, options={"maxiter": iterations})
    return sizes_at(found.x)


@dataclass(frozen=True, eq=False)
class _Whitened:
    """The log density but for a constant (``value``), and what it is made of: ``varying`` (block, place), the standard
    deviation of what differs between recordings; ``whitening`` (block, place, place), which makes errors of unit size
    and independent, with what nominal values move (``moved``) and the residual (``left``) after it; ``capacity``
    1 + S^T D^-1 S (nuisance, nuisance) and ``pulled`` S^T D^-1 residual (nuisance,).
    """

    value: float
    varying: FloatArray
    whitening: FloatArray
    moved: FloatArray
    left: FloatArray
    capacity: FloatArray
    pulled: FloatArray


@dataclass(frozen=True, eq=False)
class Likelihood:
    """How likely a ``residual`` (row,) of all ``rows`` is, by the sizes of errors."""

    rows: Rows
    residual: FloatArray

    @cached_property
    def _places(self) -> IntArray:
        """Which row stands where in the blocks, (block, place); -1 where none does."""
        blocks = [np.flatnonzero(self.rows.mode == mode) for mode in np.unique(self.rows.mode)]
        found = np.full((len(blocks), max(len(block) for block in blocks)), -1)
        for own, block in zip(found, blocks, strict=True):
            own[: len(block)] = block
        return found

    @cached_property
    def _there(self) -> BoolArray:
        return self._places >= 0

    def _in_blocks(self, values: FloatArray) -> FloatArray:
        """Return values (row, ...) by block and place, 0 where no row stands."""
        found = np.asarray(values)[self._places]
        found[~self._there] = 0
        return found

    @cached_property
    def _noise(self) -> FloatArray:
        """The identification's covariance (block, place, place); 1 of each place where no row stands."""
        places, there = self._places, self._there
        both = there[:, :, None] & there[:, None]
        found = np.where(both, self.rows.own_noise[places[:, :, None], places[:, None]], 0.0)
        every = np.arange(places.shape[1])
        found[:, every, every] += ~there
        return found

    @cached_property
    def _alike(self) -> BoolArray:
        """Which two rows of a block have the same shared error, (block, place, place)."""
        shared = np.where(self._there, self.rows.shared[self._places], -1)
        return np.asarray((shared[:, :, None] == shared[:, None]) & self._there[:, :, None])

    @cached_property
    def _quantity(self) -> IntArray:
        """The quantity of each row (block, place), -1 where none stands."""
        return np.asarray(np.where(self._there, self.rows.quantity[self._places], -1))

    @cached_property
    def _unknown(self) -> FloatArray:
        """What an unknown change of unit size moves each row by, (block, place)."""
        return self._in_blocks(self.rows.unknown_change)

    @cached_property
    def _slopes(self) -> FloatArray:
        return self._in_blocks(self.rows.slopes)

    @cached_property
    def _left(self) -> FloatArray:
        return self._in_blocks(self.residual)[..., None]

    def value(self, sizes: ErrorSizes) -> float:
        """Return the log density of the residual."""
        return self._whitened(sizes).value + self.rows.log_constant

    def at(self, sizes: ErrorSizes) -> tuple[float, FloatArray]:
        """Return the log density of the residual, and its slope (size,) by the logarithm of each size."""
        own = self._whitened(sizes)
        back_again = own.whitening.swapaxes(1, 2)
        inverse, weighted, along = back_again @ own.whitening, back_again @ own.moved, back_again @ own.left
        back: FloatArray = np.asarray(np.linalg.inv(own.capacity), dtype=np.float64)
        along = along - weighted @ (back @ own.pulled)[:, None]
        outer = along @ along.swapaxes(1, 2) - inverse + weighted @ back @ weighted.swapaxes(1, 2)
        return own.value + self.rows.log_constant, self._slope(sizes, own.varying, outer, own.pulled, back)

    def _whitened(self, sizes: ErrorSizes) -> "_Whitened":
        common, varying = self._in_blocks(self.rows.common(sizes)), self._in_blocks(self.rows.varying(sizes))
        alike, unknown, every = self._alike, self._unknown, np.arange(self._places.shape[1])
        blocks = self._noise + alike * (common[:, :, None] * common[:, None])
        blocks += alike * (sizes.change**2 * unknown[:, :, None] * unknown[:, None])
        blocks[:, every, every] += varying**2
        lower = np.linalg.cholesky(blocks)
        whitening, root_of_prior = np.linalg.inv(lower), self.rows.prior_root(sizes)
        moved, left = whitening @ (self._slopes @ root_of_prior), whitening @ self._left  # (block, place, nuisance)
        flat = moved.reshape(-1, len(root_of_prior))
        capacity = np.eye(len(root_of_prior)) + flat.T @ flat
        pulled = flat.T @ left.ravel()
        root = np.linalg.cholesky(capacity)
        value = 0.5 * float(np.sum(solve_triangular(root, pulled, lower=True) ** 2) - np.sum(left**2))
        for factor in (np.diagonal(lower, axis1=1, axis2=2), np.diag(root)):
            value -= float(np.log(factor).sum())
        return _Whitened(value, varying, whitening, moved, left, capacity, pulled)

    def _slope(
        self, sizes: ErrorSizes, varying: FloatArray, outer: FloatArray, pulled: FloatArray, back: FloatArray
    ) -> FloatArray:
        """Return the slopes (size,); ``varying`` (block, place): the standard deviation of
        what differs between recordings; ``outer`` (block, place, place):
        a a^T less the inverse of the covariance, a that inverse times the residual; ``pulled`` (nuisance,): S^T D^-1
        residual, ``back``: the inverse of 1 + S^T D^-1 S.
        """
        within = np.sum(outer * self._alike, axis=2)  # of each row, with those that share its error
        alone = np.diagonal(outer, axis1=1, axis2=2)
        found = dict.fromkeys(SIZE_NAMES, 0.0)
        for number, name in enumerate(MODE_QUANTITIES):
            own = self._quantity == number
            found[name] = getattr(sizes, name) ** 2 * float(within[own].sum())
            found[f"{name}_varies"] = float((varying**2 * alone)[own].sum())
        if self._unknown.any():
            both = self._unknown[:, :, None] * self._unknown[:, None]
            found["change"] = sizes.change**2 * float(np.sum(outer * self._alike * both))
        each = (back @ pulled) ** 2 - (1 - np.diag(back))  # diag(S^T outer S)
        for kind, name in SCALE_OF.items():
            found[name] = float(sum(value for value, own in zip(each, self.rows.kinds, strict=True) if own == kind))
        return np.array([found[name] for name in SIZE_NAMES])
