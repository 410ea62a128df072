"""What white residuals say once all values that only disturb are marginalised, in closed form, as all is linear.

    e_r = N_r (J_r a + b + c_r) + white noise of unit variance in recording r,

with parameters a of the claim, errors b of values that are common to all recordings, and c_r of each one's own.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from fe_models.arrays import FloatArray
from hybrid.diagnosis.discrepancy.expected_modes import Expectation

Stacked = Sequence[FloatArray]
"""A residual (time sensor,) of each recording."""


@dataclass(frozen=True, eq=False)
class Marginal:
    """``slopes`` N_r (time sensor, value) of each recording and what is expected of their values; ``own``: Cholesky
    factors with the errors of each recording, ``left`` (value, value): what is then known of values; ``all``: the
    factor with what is common; ``log_scale``: what the log density has beside the residuals.
    """

    slopes: tuple[FloatArray, ...]
    expected: Expectation
    own: tuple[tuple[FloatArray, bool], ...]
    squares: tuple[FloatArray, ...]
    all: tuple[FloatArray, bool]
    log_scale: float

    @staticmethod
    def of(slopes: Sequence[FloatArray], expected: Expectation) -> "Marginal":
        """Return the marginal of the recordings in order."""
        own, squares, log_scale = [], [], 0.0
        parameters, values = len(expected.spread), len(expected.common)
        total = np.diag(1 / np.concatenate([expected.spread, expected.common]) ** 2)
        log_scale -= float(np.log(expected.spread).sum() + np.log(expected.common).sum())
        for N, modes in zip(slopes, expected.modes, strict=True):
            square = N.T @ N
            factor = cho_factor(square + np.diag(1 / expected.vary**2))
            log_scale -= float(np.log(np.diag(factor[0])).sum() + np.log(expected.vary).sum())
            left = square - square @ cho_solve(factor, square)
            J = np.hstack([modes.slopes, np.eye(values)])
            total += J.T @ left @ J
            own.append(factor)
            squares.append(square)
        assert total.shape == (parameters + values,) * 2
        whole = cho_factor(total)
        log_scale -= float(np.log(np.diag(whole[0])).sum())
        return Marginal(tuple(slopes), expected, tuple(own), tuple(squares), whole, log_scale)

    def inner(self, left: Stacked, right: Stacked) -> FloatArray:
        """Return the products (i, j) of ``left`` and ``right`` vectors, each (time sensor, i) of each recording, in the
        metric of what disturbs: of a residual with itself, twice the negative logarithm of its density.
        """
        count = len(self.expected.spread) + len(self.expected.common)
        plain = np.zeros((left[0].shape[1], right[0].shape[1]))
        common = [np.zeros((count, side[0].shape[1])) for side in (left, right)]
        for x, y, N, modes, factor, square in zip(
            left, right, self.slopes, self.expected.modes, self.own, self.squares, strict=True
        ):
            by = [N.T @ vector for vector in (x, y)]
            solved = [cho_solve(factor, item) for item in by]
            plain += x.T @ y - by[0].T @ solved[1]
            for side in (0, 1):
                rest = by[side] - square @ solved[side]
                common[side] += np.vstack([modes.slopes.T @ rest, rest])
        return np.asarray(plain - common[0].T @ cho_solve(self.all, common[1]))

    def weighed(self, vectors: Stacked) -> list[FloatArray]:
        """Return what products with ``vectors`` (time sensor,) of each recording in that metric are made with."""
        common, solved = np.zeros(len(self.expected.spread) + len(self.expected.common)), []
        for x, N, modes, factor, square in zip(
            vectors, self.slopes, self.expected.modes, self.own, self.squares, strict=True
        ):
            by = cho_solve(factor, N.T @ x)
            solved.append(by)
            rest = N.T @ x - square @ by
            common = common + np.concatenate([modes.slopes.T @ rest, rest])
        shared, count, found = cho_solve(self.all, common), len(self.expected.spread), []
        for x, N, modes, factor, square, by in zip(
            vectors, self.slopes, self.expected.modes, self.own, self.squares, solved, strict=True
        ):
            moved = modes.slopes @ shared[:count] + shared[count:]
            found.append(x - N @ (by + moved - cho_solve(factor, square @ moved)))
        return found

    def means(self, residuals: Stacked) -> tuple[FloatArray, FloatArray]:
        """Return how far the claim's parameters (parameter,) are from where they were taken, and the common errors of
        all values (value,), as ``residuals`` that are `centred` have them.
        """
        common = np.zeros(len(self.expected.spread) + len(self.expected.common))
        for x, N, modes, factor, square in zip(
            residuals, self.slopes, self.expected.modes, self.own, self.squares, strict=True
        ):
            by = N.T @ x
            rest = by - square @ cho_solve(factor, by)
            common += np.concatenate([modes.slopes.T @ rest, rest])
        shared, count = cho_solve(self.all, common), len(self.expected.spread)
        return self.expected.shift + shared[:count], shared[count:]

    def centred(self, residuals: Stacked) -> list[FloatArray]:
        """Return residuals where the claim's parameters are at their prior's centre, and values as these have them."""
        return [
            own - N @ (modes.slopes @ self.expected.shift - modes.moved)
            for own, N, modes in zip(residuals, self.slopes, self.expected.modes, strict=True)
        ]

    def log_density(self, residuals: Stacked) -> float:
        """Return the log density of ``residuals`` that are `centred`, but for what is the same of all."""
        columns = [own[:, None] for own in residuals]
        return -0.5 * float(self.inner(columns, columns)[0, 0]) + self.log_scale

    def log_density_here(self, white: Stacked) -> float:
        """Return the log density of ``white`` residuals and of the claim's parameters and common errors, where these
        are as they were taken, but for what is the same of all: only what is each recording's own is marginalised.
        """
        expected, total = self.expected, 0.0
        for x, N, factor in zip(white, self.slopes, self.own, strict=True):
            by = N.T @ x
            total += float(x @ x - by @ cho_solve(factor, by)) + 2 * float(np.log(np.diag(factor[0])).sum())
        off = np.concatenate([expected.shift / expected.spread, expected.modes[0].moved / expected.common])
        return -0.5 * (total + float(off @ off))
