"""Simulation-based calibration: where posteriors are right, a true value's rank among their draws is any alike.

Talts et al., Validating Bayesian inference algorithms with simulation-based calibration, arXiv 1804.06788, 2018.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import chisquare

from fe_models.arrays import FloatArray

DRAWS = 99  # of a posterior: ranks of 0 to 99
BINS = 10
PASSES = 0.01  # p: a right posterior is found wrong once in a hundred times


@dataclass(frozen=True)
class Uniform:
    """Of a ``kind`` of parameter: the ``counts`` (bin,) of ranks, and how probable more uneven ones are, ``p``."""

    kind: str
    counts: tuple[int, ...]
    p: float


def ranks_of(kinds: Sequence[str], truth: FloatArray, draws: FloatArray) -> dict[str, list[int]]:
    """Return the ranks of the ``truth`` (parameter,) among ``draws`` (draw, parameter) of the posterior, by the
    ``kinds`` of parameters.
    """
    found: dict[str, list[int]] = {}
    for kind, below in zip(kinds, (draws < truth).sum(axis=0).tolist(), strict=False):
        found.setdefault(kind, []).append(int(below))
    return found


def draws_of(mean: FloatArray, covariance: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Return draws (draw, parameter) of a normal posterior."""
    return rng.multivariate_normal(mean, covariance, DRAWS, method="eigh")


def uniform(ranks: Mapping[str, Sequence[Sequence[int]]]) -> list[Uniform]:
    """Return how even ranks are, by the kind of parameter; ``ranks`` of each: (draw, parameter of that kind).

    Parameters of a kind are tested one by one, as in a posterior they hang together; of several the smallest p counts,
    times their number (Bonferroni).
    """
    found = []
    for kind, own in ranks.items():
        each = np.array(own).T  # (parameter, draw)
        counts = np.array([np.histogram(row, bins=BINS, range=(-0.5, DRAWS + 0.5))[0] for row in each])
        p = min(float(chisquare(row).pvalue) for row in counts) * len(counts)
        found.append(Uniform(kind, tuple(counts.sum(axis=0).tolist()), min(p, 1.0)))
    return found
