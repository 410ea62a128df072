"""Natural frequencies that are off in proportion to their square: time steps in which recordings were simulated.

Newmark's method with constant average acceleration lengthens the period of a mode by (omega h)^2 / 12 in steps of h
(Bathe, Finite Element Procedures, section 9.4), which no factor of a stiffness or mass does, so that a spring somewhere
would stand for it. Meshes and beam theories that are coarse where waves are short act likewise, to either side.
"""

from typing import Any

import numpy as np

from fe_models.arrays import FloatArray
from hybrid.diagnosis.response.config import DISPERSION


def dispersed(M: FloatArray, K: FloatArray, amount: FloatArray, rate: float) -> FloatArray:
    """Return K (variant, mode, mode), beside M alike, with the dispersion of recordings at ``rate`` (Hz).

    ``amount`` (variant,): the square of the steps in which they were simulated, over that of a tenth of their sampling
    interval; negative where frequencies are higher than K has them. omega^2 becomes omega^2 (1 - amount x / (6 + 6 x))
    with x = (omega h)^2 of that tenth: to first order what such steps do, and bounded for modes far above the samples.
    """
    if not amount.any():
        return K
    square = (DISPERSION.normal_step_share / rate) ** 2
    return np.asarray(K - amount[:, None, None] / 6 * (K @ np.linalg.solve(M + square * K, square * K)))


def dispersed_squares(omega2: FloatArray, amount: FloatArray, rate: float) -> FloatArray:
    """Return squared natural frequencies (variant, mode), (rad/s)^2, with the dispersion: see `dispersed`."""
    return np.asarray(omega2 * _remaining(amount[:, None], omega2, rate))


def shift(amount: float, omega: float, rate: float) -> float:
    """Return the relative shift of a natural frequency ``omega`` (rad/s) by a dispersion: see `dispersed`."""
    return float(np.sqrt(_remaining(amount, omega**2, rate)) - 1)


def _remaining(amount: Any, omega2: Any, rate: float) -> Any:
    """Return what the dispersion leaves of squared natural frequencies, in shares: see `dispersed`."""
    x = (DISPERSION.normal_step_share / rate) ** 2 * omega2
    return 1 - amount * x / (6 + 6 * x)


def step_of(amount: float, rate: float) -> float:
    """Return the steps (s) in which recordings at ``rate`` (Hz) of that positive ``amount`` were simulated."""
    return float(DISPERSION.normal_step_share / rate * np.sqrt(amount))
