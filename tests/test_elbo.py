"""The evidence lower bound against torch.distributions, and its gradient against finite differences."""

from collections.abc import Iterator

import pytest
import torch
from torch.distributions import Independent, Normal, kl_divergence

from hybrid.training.elbo import gaussian_log_likelihood, kl_to_standard_normal, sample_normal
from tests.hybrid_problems import double_precision


@pytest.fixture(autouse=True)
def _double() -> Iterator[None]:
    with double_precision():
        torch.manual_seed(0)
        yield


def test_likelihood_is_that_of_independent_normals() -> None:
    x, mean = torch.randn(2, 5, 7, 3)
    for std in (torch.rand(5, 1, 3) + 0.1, torch.rand(5, 7, 3) + 0.1, torch.tensor(0.3)):
        expected = Independent(Normal(mean, std.expand_as(mean)), 2).log_prob(x)
        assert torch.allclose(gaussian_log_likelihood(x, mean, std), expected, rtol=1e-13)


def test_kl_is_that_of_torch() -> None:
    mean, log_variance = torch.randn(2, 20, 8)
    q = Independent(Normal(mean, torch.exp(0.5 * log_variance)), 1)
    p = Independent(Normal(torch.zeros(8), torch.ones(8)), 1)
    assert torch.allclose(kl_to_standard_normal(mean, log_variance), kl_divergence(q, p), rtol=1e-13)


def test_kl_is_positive_and_zero_only_at_the_standard_normal() -> None:
    assert float(kl_to_standard_normal(torch.zeros(1, 8), torch.zeros(1, 8))) == 0.0
    mean, log_variance = 0.01 * torch.randn(2, 1000, 8)
    assert bool((kl_to_standard_normal(mean, log_variance) > 0).all())


def test_samples_have_the_mean_and_the_variance_asked_for() -> None:
    """Of 200,000 draws the mean is off by sigma / 450, the standard deviation by sigma / 630; four times that."""
    mean, log_variance = torch.tensor([1.0, -2.0]), torch.tensor([0.0, 3.0])
    n = 200_000
    drawn = sample_normal(mean.expand(n, 2), log_variance.expand(n, 2), torch.Generator().manual_seed(0))
    std = torch.exp(0.5 * log_variance)
    assert torch.all(torch.abs(drawn.mean(dim=0) - mean) < 4 * std / n**0.5)
    assert torch.all(torch.abs(drawn.std(dim=0) / std - 1) < 4 / (2 * n) ** 0.5)
    correlation = float(torch.corrcoef(drawn.T)[0, 1])
    assert abs(correlation) < 4 / n**0.5


def test_samples_follow_the_generator_that_is_passed_in() -> None:
    mean = torch.zeros(3, 4)
    one, again, other = (sample_normal(mean, mean, torch.Generator().manual_seed(seed)) for seed in (5, 5, 6))
    assert torch.equal(one, again)
    assert not torch.equal(one, other)


def test_gradient_flows_through_the_sample() -> None:
    """dz/dmean = 1 and dz/dlog_variance = (z - mean) / 2, and autograd's whole gradient is that of differences."""
    mean, log_variance = torch.randn(2, 3, 4, requires_grad=True).unbind()
    z = sample_normal(mean, log_variance, torch.Generator().manual_seed(0))
    by_mean, by_log_variance = torch.autograd.grad(z.sum(), (mean, log_variance))
    assert torch.equal(by_mean, torch.ones(3, 4))
    assert torch.allclose(by_log_variance, ((z - mean) / 2).detach(), rtol=1e-12)


def test_gradient_of_the_bound_is_that_of_finite_differences() -> None:
    x = torch.randn(2, 5, 4)

    def bound(mean: torch.Tensor, log_variance: torch.Tensor, log_std: torch.Tensor) -> torch.Tensor:
        z = sample_normal(mean, log_variance, torch.Generator().manual_seed(0))  # (batch, state)
        likelihood = gaussian_log_likelihood(x, z[:, None].expand_as(x), log_std.exp())
        return kl_to_standard_normal(mean, log_variance) - likelihood

    inputs = [torch.randn(2, 4, requires_grad=True) for _ in range(2)]
    assert torch.autograd.gradcheck(bound, (*inputs, torch.randn(2, 1, 4, requires_grad=True)))
