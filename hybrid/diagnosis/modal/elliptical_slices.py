"""Draws from a density near a normal one, by elliptical slice sampling, in which nothing has to be set.

N(m, C) approximates the density. After x, with v drawn from N(0, C), comes

    m + (x - m) cos(a) + v sin(a),

the angle a drawn from a bracket that shrinks towards 0, where x is, until the density over N(m, C) exceeds a level
drawn below that at x (Murray, Adams and MacKay, Elliptical slice sampling, AISTATS 2010; about an approximation:
Nishihara, Murray and Adams, JMLR 15, 2014).
"""

from collections.abc import Callable

import numpy as np

from fe_models.arrays import FloatArray


def slice_samples(
    log_density: Callable[[FloatArray], float],
    middle: FloatArray,
    root: FloatArray,
    draws: int,
    between: int,
    rng: np.random.Generator,
) -> FloatArray:
    """Return draws (draw, value) of a density whose logarithm is ``log_density`` but for a constant, -inf where there
    is none; it is begun at the ``middle`` (value,), where there has to be some.

    ``root`` (value, value): a square root of the covariance C of the approximation. Of the steps one in so many
    ``between`` is kept.
    """
    away = np.linalg.inv(root)

    def log_ratio(values: FloatArray) -> float:
        return log_density(values) + 0.5 * float(np.sum((away @ (values - middle)) ** 2))

    values, level, found = middle, log_ratio(middle), list[FloatArray]()
    for number in range(draws * between):
        values, level = _next(values, level, middle, root @ rng.standard_normal(len(middle)), log_ratio, rng)
        if (number + 1) % between == 0:
            found.append(values)
    return np.array(found)


def _next(
    values: FloatArray,
    level: float,
    middle: FloatArray,
    beside: FloatArray,
    log_ratio: Callable[[FloatArray], float],
    rng: np.random.Generator,
) -> tuple[FloatArray, float]:
    """Return the point that follows ``values`` (value,), whose log ratio is ``level``, and its own log ratio."""
    least = level + np.log(rng.uniform(np.finfo(float).tiny, 1.0))
    angle = rng.uniform(0.0, 2 * np.pi)
    low, high = angle - 2 * np.pi, angle
    while high - low > np.finfo(float).eps:
        tried = middle + np.cos(angle) * (values - middle) + np.sin(angle) * beside
        ratio = log_ratio(tried)
        if ratio > least:
            return tried, ratio
        low, high = (angle, high) if angle < 0 else (low, angle)
        angle = rng.uniform(low, high)
    return values, level
