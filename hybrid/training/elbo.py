"""The evidence lower bound of the variational autoencoder (Lai et al. 2022, eq. 9-11)."""

import math

import torch
from torch import Tensor

from hybrid.config import TrainingConfig
from hybrid.neural_modal_ode.driving import Driving
from hybrid.neural_modal_ode.model import NeuralModalODE
from hybrid.training.config import GRADIENT


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


def negative_elbo(
    model: NeuralModalODE,
    windows: Tensor,
    std: Tensor,
    horizon: int,
    kl_weight: float,
    generator: torch.Generator,
    driving: Driving | None = None,
) -> Tensor:
    """Return -ELBO (batch,) of the first ``horizon`` samples of windows (batch, time, sensor), measured channels only.

    ``std`` (batch, 1, measured): standard deviation of the Gaussian likelihood. One sample of z0 by reparameterisation.
    ``driving``: what is known to drive the windows.
    """
    mean, log_variance = model.encode(windows, driving)
    z0 = sample_normal(mean, log_variance, generator)
    decoded = model.forecast(z0, horizon, driving).channels[:, :, model.measured]
    log_likelihood = gaussian_log_likelihood(windows[:, :horizon, model.measured], decoded, std)
    return kl_weight * kl_to_standard_normal(mean, log_variance) - log_likelihood


class Elbo:
    """The negative evidence lower bound; the noise is a fixed share of each window's channels, as model errors are."""

    def __init__(
        self, model: NeuralModalODE, windows: Tensor, config: TrainingConfig, driving: Driving | None = None
    ) -> None:
        self.kl_weight, self.driving = config.kl_weight, driving
        measured = windows[:, :, model.measured]
        overall = measured.square().mean(dim=(0, 1)).sqrt()  # (measured,)
        own = measured.square().mean(dim=1, keepdim=True).sqrt()  # (window, 1, measured)
        self.std = config.noise_std * (own + GRADIENT.least_noise_share * overall)

    def __call__(
        self, model: NeuralModalODE, windows: Tensor, batch: Tensor, horizon: int, generator: torch.Generator
    ) -> Tensor:
        """Return -ELBO (batch,) of the windows with the numbers ``batch``."""
        driving = None if self.driving is None else self.driving[batch]
        return negative_elbo(model, windows[batch], self.std[batch], horizon, self.kl_weight, generator, driving)
