"""The internal elongation of a hysteretic spring along a motion, exact between turns, and how it answers to changes.

In shares of its reach, y along x: dy/dx = 1 - y^n where it is loaded, 1 where it is unloaded. What a step in x makes of
y is read from the curve of a slow pull from rest.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fe_models.arrays import TINY, FloatArray
from fe_models.causes.hysteretic_spring import HystereticSpring, loading_curve
from hybrid.compiled import compiled


@dataclass(frozen=True, eq=False)
class Course:
    """What a spring remembers, ``z`` (part,), m; in each part of the way to the next how that grows with the one before
    and with the elongation's step, ``kept`` and ``follows`` (part - 1,).
    """

    z: FloatArray
    kept: FloatArray
    follows: FloatArray


@dataclass(frozen=True, eq=False)
class Hysteresis:
    """A ``spring`` as its curve says."""

    spring: HystereticSpring

    @cached_property
    def curve(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Elongations and what is remembered of them, in shares of the reach, and the slope there (point,)."""
        elongation, share = loading_curve(self.spring.sharpness)
        return elongation, share, 1 - share**self.spring.sharpness

    def along(self, u: FloatArray, first: float | None = None) -> Course:
        """Return the course along elongations ``u`` (part,), from what is remembered at ``first`` (m): as after a slow
        pull, where it is not given.
        """
        reach = self.spring.reach
        x = u / reach
        begun = np.sign(x[0]) * _after(abs(x[0]), *self.curve) if first is None else first / reach
        y, kept, follows = _follow(x, begun, *self.curve, self.spring.sharpness)
        return Course(reach * y, kept, follows)


@compiled
def _after(x: float, elongation: FloatArray, share: FloatArray, slope: FloatArray) -> float:
    """Return the curve at x >= 0: Hermite's cubic between its points."""
    last = len(elongation) - 1
    if x >= elongation[last]:
        return share[last]
    i = min(max(int(np.searchsorted(elongation, x, side="right")) - 1, 0), last - 1)
    h = elongation[i + 1] - elongation[i]
    t = (x - elongation[i]) / h
    rise = share[i + 1] - share[i]
    bent = h * slope[i] - rise + t * (2 * rise - h * (slope[i] + slope[i + 1]))
    return share[i] + t * (rise + (1 - t) * bent)


@compiled
def _before(y: float, elongation: FloatArray, share: FloatArray) -> float:
    """Return the elongation at which the curve is at y >= 0, by chords."""
    last = len(share) - 1
    if y >= share[last]:
        return elongation[last]
    i = min(max(int(np.searchsorted(share, y, side="right")) - 1, 0), last - 1)
    near = (y - share[i]) / (share[i + 1] - share[i])
    return elongation[i] + near * (elongation[i + 1] - elongation[i])


@compiled
def step_of(
    y: float, step: float, elongation: FloatArray, share: FloatArray, slope: FloatArray, sharpness: float
) -> tuple[float, float, float]:
    """Return what a ``step`` in x makes of y, and how that grows with y and with the step."""
    if y * step >= 0:
        at = _before(abs(y), elongation, share) + abs(step)
        moved = _after(at, elongation, share, slope)
        left = max(1 - moved**sharpness, 0.0)
        return (moved if y + step >= 0 else -moved), min(left / max(1 - abs(y) ** sharpness, TINY), 1.0), left
    if abs(step) <= abs(y):
        return y + step, 1.0, 1.0
    moved = _after(abs(step) - abs(y), elongation, share, slope)
    left = max(1 - moved**sharpness, 0.0)
    return (moved if step >= 0 else -moved), left, left


@compiled
def _follow(
    x: FloatArray, first: float, elongation: FloatArray, share: FloatArray, slope: FloatArray, sharpness: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    y, kept, follows = np.zeros(len(x)), np.ones(len(x) - 1), np.ones(len(x) - 1)
    y[0] = first
    for i in range(len(x) - 1):
        y[i + 1], kept[i], follows[i] = step_of(y[i], x[i + 1] - x[i], elongation, share, slope, sharpness)
    return y, kept, follows
