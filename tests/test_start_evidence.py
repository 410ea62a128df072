"""The evidence of a window's start: the integral that it stands for, and what it must not depend on."""

from collections.abc import Iterator

import numpy as np
import pytest
import torch
from scipy.integrate import quad
from scipy.stats import multivariate_normal

from fe_models.arrays import FloatArray
from hybrid.estimation.start_evidence import StartEvidence, evidence_of
from tests.hybrid_problems import double_precision


@pytest.fixture(autouse=True)
def _double() -> Iterator[None]:
    with double_precision():
        yield


def evidence_with(V: FloatArray) -> StartEvidence:
    return StartEvidence(torch.tensor(np.linalg.inv(np.linalg.cholesky(V))))


def some_covariance(seed: int, n: int = 3) -> FloatArray:
    factor = np.random.default_rng(seed).standard_normal((n, n + 2))
    return np.asarray(factor @ factor.T)


def test_it_is_the_density_integrated_over_an_unknown_size() -> None:
    """Log of int N(x; 0, s^2 V) ds / s by quadrature, up to one constant for all x and V; 1e-6 is the quadrature's."""
    x = np.random.default_rng(0).standard_normal((4, 3))
    differences = []
    for V in (some_covariance(1), some_covariance(2)):
        found = evidence_with(V)(torch.tensor(x)).numpy()
        for row, value in zip(x, found, strict=True):
            size = np.sqrt(row @ np.linalg.solve(V, row))  # where the integrand has its bulk

            def density(log_s: float, row: FloatArray = row, V: FloatArray = V, size: float = size) -> float:
                return float(multivariate_normal(cov=(size * np.exp(log_s)) ** 2 * V).pdf(row))

            differences.append(np.log(quad(density, -5, 12, epsabs=0, epsrel=1e-9, limit=200)[0]) - value)
    np.testing.assert_allclose(differences, differences[0], rtol=0, atol=1e-6)


def test_a_start_of_another_size_favours_nobody() -> None:
    """Every recording loses the same n log 1000."""
    x = torch.randn(5, 3, generator=torch.Generator().manual_seed(0))
    for V in (some_covariance(1), some_covariance(2)):
        evidence = evidence_with(V)
        shift = evidence(1e3 * x) - evidence(x)
        assert torch.allclose(shift, torch.full_like(shift, -3 * np.log(1e3)), rtol=1e-12)


def test_silence_gives_finite_numbers() -> None:
    assert bool(torch.isfinite(evidence_with(some_covariance(1))(torch.zeros(2, 3))).all())


def test_the_sizes_of_a_recordings_starts_do_not_matter() -> None:
    rng = np.random.default_rng(0)
    starts = rng.standard_normal((200, 4))
    plain, sized = evidence_of(starts), evidence_of(starts * 10.0 ** rng.uniform(-3, 3, (200, 1)))
    assert torch.allclose(plain.root, sized.root, rtol=1e-9)


def test_starts_are_recognised_by_how_they_spread() -> None:
    """A thousand starts of each of two covariances: on average each is likelier under its own."""
    rng = np.random.default_rng(0)
    starts = [rng.multivariate_normal(np.zeros(3), some_covariance(seed), 1000) for seed in (1, 2)]
    evidence = [evidence_of(each) for each in starts]
    means = [[float(each(torch.tensor(x)).mean()) for each in evidence] for x in starts]
    assert means[0][0] > means[0][1] + 0.1
    assert means[1][1] > means[1][0] + 0.1


def test_starts_that_do_not_fill_their_space_still_have_a_covariance() -> None:
    """One direction only, as of one mode without noise: the shrinkage keeps the logarithm finite."""
    starts = np.outer(np.random.default_rng(0).standard_normal(50), [1.0, 2.0, 2.0])
    evidence = evidence_of(starts)
    along, across = evidence(torch.tensor([[1.0, 2.0, 2.0], [2.0, -1.0, 0.0]]))
    assert torch.isfinite(along)
    assert along > across + 1.0
