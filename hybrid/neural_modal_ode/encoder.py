"""Encoders: mean and log-variance of the initial modal state z0 = [q0, q0'] from a record's first samples."""

import torch
from torch import Tensor, nn

from hybrid.neural_modal_ode.config import ENCODER
from hybrid.neural_modal_ode.networks import mlp


class PaperEncoder(nn.Module):
    """The encoder of Lai et al. 2022: an MLP reads x_0 for q0, an RNN reads all samples, newest first, for q0'."""

    def __init__(self, channels: int, modes: int, hidden: int, rnn_hidden: int) -> None:
        super().__init__()
        self.position = mlp(channels, hidden, 2 * modes)
        self.recurrent = nn.RNN(channels, rnn_hidden, batch_first=True)
        self.velocity = nn.Linear(rnn_hidden, 2 * modes)

    def forward(self, samples: Tensor) -> tuple[Tensor, Tensor]:
        """Return mean and log-variance of z0, each (batch, 2 mode), from normalised samples (batch, time, channel)."""
        q_mean, q_log_variance = self.position(samples[:, 0]).chunk(2, dim=-1)  # (batch, mode) each
        _, last = self.recurrent(samples.flip(1))  # (1, batch, rnn_hidden)
        v_mean, v_log_variance = self.velocity(last[0]).chunk(2, dim=-1)  # (batch, mode) each
        return torch.cat([q_mean, v_mean], -1), torch.cat([q_log_variance, v_log_variance], -1)


class WindowEncoder(nn.Module):
    """A linear estimator of z0 from all samples at once; its standard deviation grows with the samples' size.

    Linear, because a free vibration of twice the size starts from twice the state; and small, because a few recordings
    hold few independent windows. The estimator starts where `calibration` leaves it.
    """

    def __init__(self, channels: int, modes: int, samples: int) -> None:
        super().__init__()
        self.linear = nn.Linear(channels * samples, 2 * modes, bias=False)
        self.log_variance = nn.Parameter(torch.full((2 * modes,), ENCODER.initial_log_variance))

    def forward(self, samples: Tensor) -> tuple[Tensor, Tensor]:
        """Return mean and log-variance of z0, each (batch, 2 mode), from normalised samples (batch, time, channel)."""
        flat = samples.flatten(1)  # (batch, time * channel)
        size = flat.square().mean(dim=1, keepdim=True) + ENCODER.min_size**2  # (batch, 1)
        return self.linear(flat), self.log_variance + torch.log(size)
