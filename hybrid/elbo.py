"""The evidence lower bound of the variational autoencoder (Lai et al. 2022, eq. 9-11)."""

import math

import torch
from torch import Tensor


def gaussian_log_likelihood(x: Tensor, mean: Tensor, std: Tensor) -> Tensor:
    """Return sum over time and channel of log N(x; mean, std^2), shape (batch,); x, mean (batch, time, channel)."""
    terms = -0.5 * ((x - mean) / std) ** 2 - torch.log(std) - 0.5 * math.log(2 * math.pi)
    return terms.expand_as(x).sum(dim=(1, 2))


def kl_to_standard_normal(mean: Tensor, log_variance: Tensor) -> Tensor:
    """Return KL(N(mean, exp(log_variance)) || N(0, I)) in closed form, shape (batch,); arguments (batch, state)."""
    return 0.5 * (log_variance.exp() + mean**2 - 1 - log_variance).sum(dim=-1)


def sample_normal(mean: Tensor, log_variance: Tensor, generator: torch.Generator) -> Tensor:
    """Return one sample of N(mean, exp(log_variance)) by reparameterisation, same shape."""
    noise = torch.randn(mean.shape, generator=generator, dtype=mean.dtype).to(mean.device)
    return mean + torch.exp(0.5 * log_variance) * noise
