"""What training lowers: the negative evidence lower bound, or the misfit from states that are solved for."""

import torch
from torch import Tensor, nn

from hybrid.config import TrainingConfig
from hybrid.elbo import gaussian_log_likelihood, kl_to_standard_normal, sample_normal
from hybrid.model import NeuralModalODE
from hybrid.state_estimation import ITERATIONS, StatePrior, estimate_state

QUIET = 0.05  # of a channel's rms over all windows: the least noise, relative as the rest of it
FEW_ITERATIONS = 2  # of Gauss-Newton, from the state that the last epoch found
LEAST_SPREAD = 1e-4  # of the mean variance: keeps a prior on states that never move
MEDIAN_TO_STD = 1.4826  # of the absolute values of normal noise
FOLLOWING = 0.1  # share of each batch in the noise's standard deviation
TAIL = 5.0  # noise standard deviations beyond which a misfit counts linearly: a poor model has many


def negative_elbo(
    model: NeuralModalODE, windows: Tensor, std: Tensor, horizon: int, kl_weight: float, generator: torch.Generator
) -> Tensor:
    """Return -ELBO (batch,) of the first ``horizon`` samples of windows (batch, time, sensor), measured channels only.

    ``std`` (batch, 1, measured): standard deviation of the Gaussian likelihood. One sample of z0 by reparameterisation.
    """
    mean, log_variance = model.encode(windows)
    z0 = sample_normal(mean, log_variance, generator)
    decoded = model.forecast(z0, horizon).channels[:, :, model.measured]
    log_likelihood = gaussian_log_likelihood(windows[:, :horizon, model.measured], decoded, std)
    return kl_weight * kl_to_standard_normal(mean, log_variance) - log_likelihood


class Elbo(nn.Module):
    """The negative evidence lower bound; the noise is a fixed share of each window's channels, as model errors are."""

    def __init__(self, model: NeuralModalODE, windows: Tensor, config: TrainingConfig) -> None:
        super().__init__()
        self.kl_weight = config.kl_weight
        measured = windows[:, :, model.measured]
        overall = measured.square().mean(dim=(0, 1)).sqrt()  # (measured,)
        own = measured.square().mean(dim=1, keepdim=True).sqrt()  # (window, 1, measured)
        self.std = config.noise_std * (own + QUIET * overall)

    def forward(
        self, model: NeuralModalODE, windows: Tensor, batch: Tensor, horizon: int, generator: torch.Generator
    ) -> Tensor:
        """Return -ELBO (batch,) of the windows with the numbers ``batch``."""
        return negative_elbo(model, windows[batch], self.std[batch], horizon, self.kl_weight, generator)

    def end_epoch(self, model: NeuralModalODE) -> None:
        """Do nothing: the encoder is learned like all else."""


class ProjectedMisfit(nn.Module):
    """The misfit of whole windows from the states that fit them best (variable projection, as in the calibration).

    At the best state the misfit does not change with the state, so that its gradient with the state held is the whole
    gradient. Each window's state is kept, and is where its search begins in the next epoch.
    """

    def __init__(self, model: NeuralModalODE, windows: Tensor) -> None:
        super().__init__()
        self.states: Tensor
        self.started: Tensor
        self.register_buffer("states", windows.new_zeros(len(windows), 2 * model.dynamics.modes))
        self.register_buffer("started", torch.zeros(len(windows), dtype=torch.bool, device=windows.device))

    def forward(
        self, model: NeuralModalODE, windows: Tensor, batch: Tensor, horizon: int, generator: torch.Generator
    ) -> Tensor:
        """Return the misfit (batch,): half the square in noise standard deviations, linear beyond `TAIL`."""
        prior = model.encoder
        if not isinstance(prior, StatePrior):
            raise TypeError("the projected misfit needs a model that solves for its states")
        part = windows[batch, :horizon]
        iterations = FEW_ITERATIONS if bool(self.started[batch].all()) else ITERATIONS
        states = estimate_state(model, prior, part, self.states[batch], iterations).mean
        self.states[batch], self.started[batch] = states, True
        decoded = model.forecast(states, horizon).channels
        error = (part - decoded)[:, :, model.measured]  # (batch, time, measured)
        self._follow_noise(prior, error.detach())
        misfit = (error / prior.noise_std).flatten(1)
        return TAIL**2 * (torch.sqrt(1 + (misfit / TAIL) ** 2) - 1).sum(dim=1)

    def end_epoch(self, model: NeuralModalODE) -> None:
        """Let the prior be the spread of the states found in this epoch."""
        if isinstance(model.encoder, StatePrior):
            spread = self.states.T @ self.states / len(self.states)
            guard = LEAST_SPREAD * spread.diagonal().mean() * torch.eye(len(spread), device=spread.device)
            model.encoder.precision.copy_(torch.linalg.inv(spread + guard))

    def _follow_noise(self, prior: StatePrior, error: Tensor) -> None:
        """Let the noise follow what the model leaves, by the median: windows not explained yet hardly move it."""
        now = MEDIAN_TO_STD * error.abs().flatten(0, 1).median(dim=0).values  # (measured,)
        prior.noise_std.lerp_(now, FOLLOWING)


Objective = Elbo | ProjectedMisfit


def objective_for(model: NeuralModalODE, windows: Tensor, config: TrainingConfig) -> Objective:
    """Return what trains this model."""
    if isinstance(model.encoder, StatePrior):
        return ProjectedMisfit(model, windows)
    return Elbo(model, windows, config)
