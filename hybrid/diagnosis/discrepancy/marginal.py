"""What white residuals say once all values that only disturb are marginalised, in closed form, as all is linear.

    e_r = N_r (J_r a + b + c_r) + white noise of unit variance in recording r,

with parameters a of the claim, errors b of values that are common to all recordings, and c_r of each one's own.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from fe_models.arrays import FloatArray
from hybrid.diagnosis.discrepancy.expected_modes import Expectation, ExpectedModes

Residuals = Sequence[FloatArray]
"""A residual (time sensor,) of each recording."""


@dataclass(frozen=True, eq=False)
class _Recording:
    """Of one recording: the ``slopes`` N (time sensor, value) of its residual by its values, and their ``square``
    N^T N; the expected ``modes``, with the slopes J of these values; the Cholesky ``factor`` of N^T N and the precision
    of c together.
    """

    slopes: FloatArray
    square: FloatArray
    modes: ExpectedModes
    factor: tuple[FloatArray, bool]

    @staticmethod
    def of(slopes: FloatArray, modes: ExpectedModes, vary: FloatArray) -> "_Recording":
        """Return it; ``vary`` (value,): the standard deviation of c."""
        square = slopes.T @ slopes
        return _Recording(slopes, square, modes, cho_factor(square + np.diag(1 / vary**2)))

    @property
    def log_volume(self) -> float:
        """The logarithm of the determinant of the factor."""
        return float(np.log(np.diag(self.factor[0])).sum())

    @property
    def precision(self) -> FloatArray:
        """What the residual tells of a and b (parameter + value, same) where c is marginalised."""
        left = self.square - self.square @ cho_solve(self.factor, self.square)
        both = np.hstack([self.modes.slopes, np.eye(len(left))])
        return np.asarray(both.T @ left @ both)

    def solved(self, by: FloatArray) -> FloatArray:
        """Return the most probable c (value, ...) beside nothing else, where N^T times the residual is ``by``."""
        return np.asarray(cho_solve(self.factor, by))

    def on_common(self, by: FloatArray, own: FloatArray) -> FloatArray:
        """Return what is left for a and b (parameter + value, ...) of ``by``, as in `solved`, beside its ``own`` c."""
        rest = by - self.square @ own
        return np.concatenate([self.modes.slopes.T @ rest, rest])


@dataclass(frozen=True, eq=False)
class Marginal:
    """The ``recordings`` and what is ``expected`` of them; ``common``: the Cholesky factor of the precision of a and b;
    ``log_scale``: what the log density has beside the residuals.
    """

    recordings: tuple[_Recording, ...]
    expected: Expectation
    common: tuple[FloatArray, bool]
    log_scale: float

    @staticmethod
    def of(slopes: Sequence[FloatArray], expected: Expectation) -> "Marginal":
        """Return the marginal of the recordings in order, with the ``slopes`` N (time sensor, value) of each."""
        log_scale = -float(np.log(expected.spread).sum() + np.log(expected.common).sum())
        total = np.diag(1 / np.concatenate([expected.spread, expected.common]) ** 2)
        recordings = []
        for own_slopes, modes in zip(slopes, expected.modes, strict=True):
            own = _Recording.of(own_slopes, modes, expected.vary)
            log_scale -= own.log_volume + float(np.log(expected.vary).sum())
            total += own.precision
            recordings.append(own)
        common = cho_factor(total)
        log_scale -= float(np.log(np.diag(common[0])).sum())
        return Marginal(tuple(recordings), expected, common, log_scale)

    @property
    def _count(self) -> int:
        """Number of parameters and values together."""
        return len(self.expected.spread) + len(self.expected.common)

    def inner(self, left: Residuals, right: Residuals) -> FloatArray:
        """Return the products (i, j) of ``left`` and ``right`` vectors, each (time sensor, i) of each recording, in the
        metric of what disturbs: of a residual with itself, twice the negative logarithm of its density.
        """
        plain = np.zeros((left[0].shape[1], right[0].shape[1]))
        common = [np.zeros((self._count, side[0].shape[1])) for side in (left, right)]
        for x, y, own in zip(left, right, self.recordings, strict=True):
            by = [own.slopes.T @ vector for vector in (x, y)]
            solved = [own.solved(item) for item in by]
            plain += x.T @ y - by[0].T @ solved[1]
            for side in (0, 1):
                common[side] += own.on_common(by[side], solved[side])
        return np.asarray(plain - common[0].T @ cho_solve(self.common, common[1]))

    def weighed(self, residuals: Residuals) -> list[FloatArray]:
        """Return what products with ``residuals`` in that metric are made with, (time sensor,) of each recording."""
        common, solved = np.zeros(self._count), []
        for x, own in zip(residuals, self.recordings, strict=True):
            by = own.slopes.T @ x
            solved.append(own.solved(by))
            common = common + own.on_common(by, solved[-1])
        shared, count, found = cho_solve(self.common, common), len(self.expected.spread), []
        for x, own, c in zip(residuals, self.recordings, solved, strict=True):
            moved = own.modes.slopes @ shared[:count] + shared[count:]
            found.append(x - own.slopes @ (c + moved - own.solved(own.square @ moved)))
        return found

    def means(self, residuals: Residuals) -> tuple[FloatArray, FloatArray]:
        """Return how far the claim's parameters (parameter,) are from where they were taken, and the common errors of
        all values (value,), as ``residuals`` that are `centred` have them.
        """
        common = np.zeros(self._count)
        for x, own in zip(residuals, self.recordings, strict=True):
            by = own.slopes.T @ x
            common += own.on_common(by, own.solved(by))
        shared, count = cho_solve(self.common, common), len(self.expected.spread)
        return self.expected.shift + shared[:count], shared[count:]

    def centred(self, residuals: Residuals) -> list[FloatArray]:
        """Return residuals where the claim's parameters are at their prior's centre, and values as these have them."""
        return [
            x - own.slopes @ (own.modes.slopes @ self.expected.shift - own.modes.moved)
            for x, own in zip(residuals, self.recordings, strict=True)
        ]

    def log_density(self, residuals: Residuals) -> float:
        """Return the log density of ``residuals`` that are `centred`, but for what is the same of all."""
        columns = [own[:, None] for own in residuals]
        return -0.5 * float(self.inner(columns, columns)[0, 0]) + self.log_scale

    def log_density_here(self, white: Residuals) -> float:
        """Return the log density of ``white`` residuals and of the claim's parameters and common errors, where these
        are as they were taken, but for what is the same of all: only what is each recording's own is marginalised.
        """
        expected, total = self.expected, 0.0
        for x, own in zip(white, self.recordings, strict=True):
            by = own.slopes.T @ x
            total += float(x @ x - by @ own.solved(by)) + 2 * own.log_volume
        off = np.concatenate([expected.shift / expected.spread, expected.modes[0].moved / expected.common])
        return -0.5 * (total + float(off @ off))
