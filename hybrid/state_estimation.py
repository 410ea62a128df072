"""The most probable initial state given a window's samples, and how sure it is: Gauss-Newton through the latent ODE.

    z0 minimises |(x - x(z0)) / std|^2 + z0^T P^-1 z0,   cov(z0) = (J^T J / std^2 + P^-1)^-1  (Laplace)

with J = dx/dz0 exact, by the integrator's differentiated recursion. Where the model is linear this is the Kalman
smoother's answer; where it is not, the posterior follows the learned forces, which no linear encoder can.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import torch
from torch import Tensor, nn

from hybrid.integrators import propagate, sensitivities

if TYPE_CHECKING:
    from hybrid.model import NeuralModalODE

LARGEST_STEP = 2.0  # in scaled states, which are near one: keeps Gauss-Newton where the forces are known
ITERATIONS = 8  # from nothing; 3 are enough from a state that is nearly right


class StatePrior(nn.Module):
    """What is known before: z0 ~ N(0, P) with ``precision`` P^-1 (2 mode, 2 mode), and the sensors' noise.

    ``noise_std`` (measured,): standard deviation of each measured channel, in its unit.
    """

    def __init__(self, precision: Tensor, noise_std: Tensor) -> None:
        super().__init__()
        self.precision: Tensor
        self.noise_std: Tensor
        self.register_buffer("precision", precision.to(torch.get_default_dtype()))
        self.register_buffer("noise_std", noise_std.to(torch.get_default_dtype()))


@dataclass(frozen=True)
class StateEstimate:
    """``mean`` (batch, 2 mode) and ``covariance`` (batch, 2 mode, 2 mode) of the scaled initial state."""

    mean: Tensor
    covariance: Tensor


def estimate_state(
    model: "NeuralModalODE",
    prior: StatePrior,
    windows: Tensor,
    start: Tensor | None = None,
    iterations: int = ITERATIONS,
) -> StateEstimate:
    """Return the posterior of the initial state given all samples of ``windows`` (batch, time, sensor).

    Only measured channels are read. ``start`` (batch, 2 mode): where the search begins; left out: at rest.
    """
    seen = windows[:, :, model.measured]
    z0 = windows.new_zeros(len(windows), len(prior.precision)) if start is None else start.detach()
    with torch.no_grad():
        for _ in range(iterations):
            predicted, J = _linearise(model, z0, windows.shape[1])
            J = (J / prior.noise_std[:, None]).flatten(1, 2)  # (batch, time * measured, 2 mode)
            misfit = ((seen - predicted) / prior.noise_std).flatten(1)  # (batch, time * measured)
            precision = J.transpose(1, 2) @ J + prior.precision  # (batch, 2 mode, 2 mode)
            downhill = (J.transpose(1, 2) @ misfit[..., None])[..., 0] - z0 @ prior.precision
            move = torch.linalg.solve(precision, downhill)
            z0 = z0 + move * (LARGEST_STEP / move.norm(dim=1, keepdim=True)).clamp(max=1.0)
    return StateEstimate(z0, torch.linalg.inv(precision))


def _linearise(model: "NeuralModalODE", z0: Tensor, samples: int) -> tuple[Tensor, Tensor]:
    """Return the measured channels from z0 (batch, time, measured), and d channels / dz0, with 2 mode behind."""
    dynamics, measured = model.dynamics, model.measured
    every = model.substeps
    z = propagate(dynamics, z0, (samples - 1) * every + 1, model.step / every)  # (batch, substep, 2 mode)
    slopes = dynamics.force_slopes(z.flatten(0, 1)).unflatten(0, z.shape[:2])  # (batch, substep, mode, 2 mode)
    S = sensitivities(dynamics, z, slopes, model.step / every)  # (batch, substep, 2 mode, 2 mode)
    z, slopes, S = z[:, ::every], slopes[:, ::every], S[:, ::every]  # now (batch, time, ...)
    channels = model.decode(z, dynamics.force(z))[..., measured]
    J = model.decode(S.transpose(-1, -2), (slopes @ S).transpose(-1, -2))[..., measured]  # decoding is linear
    return channels, J.transpose(-1, -2)
