"""Forecasts of windows from their first samples: by the hybrid model, and by the FE model from the same start."""

from copy import deepcopy
from dataclasses import dataclass, replace

import numpy as np
import torch
from torch import Tensor

from fe_models.dofs import FloatArray
from fe_models.errors import InputError
from hybrid.model import NeuralModalODE, Trajectory
from hybrid.residual import NoResidual
from hybrid.state_estimation import StatePrior, estimate_state, smooth_state

BATCH = 64  # windows at a time: bounds memory
NOISE_FREEDOM = 20  # degrees of freedom of the prior on a window's noise: ten samples of four channels weigh twice that


@dataclass(frozen=True)
class Forecast:
    """Modal coordinates and rates (window, time, mode), and channels (window, time, sensor)."""

    q: FloatArray
    q_dot: FloatArray
    q_ddot: FloatArray
    channels: FloatArray


def fe_counterpart(model: NeuralModalODE) -> NeuralModalODE:
    """Return the model without anything learned in its dynamics: the FE model, exact in time, from the same start."""
    fe = deepcopy(model)
    fe.config = replace(fe.config, integrator="propagator")
    fe.dynamics.residual = NoResidual(fe.dynamics.modes).to(fe.dynamics.a)
    return fe


@torch.no_grad()
def forecast_windows(
    model: NeuralModalODE,
    windows: FloatArray,
    dynamics: NeuralModalODE | None = None,
    samples: int | None = None,
    whole: bool = False,
) -> Forecast:
    """Forecast windows (window, time, sensor) from their first samples, starting at the mean of q(z0 | samples).

    ``dynamics`` (the FE counterpart, say) forecasts in place of ``model``, from the state that ``model`` encodes;
    ``samples`` of them, or as many as the windows have. ``whole``: see `posterior`.
    """
    parts: list[Trajectory] = []
    for start in range(0, len(windows), BATCH):
        batch = torch.tensor(
            windows[start : start + BATCH], dtype=model.channel_scale.dtype, device=model.channel_scale.device
        )
        mean, _ = posterior(model, batch, whole)
        parts.append((dynamics or model).forecast(mean, samples or windows.shape[1]))
    return joined(parts)


@torch.no_grad()
def posterior(model: NeuralModalODE, windows: Tensor, whole: bool = False) -> tuple[Tensor, Tensor]:
    """Return the mean (window, 2 mode) of z0 given windows (window, time, sensor), and a root of its covariance.

    From the windows' first samples, or, ``whole``, from all of them: that needs a model which solves for its states
    (`InputError` otherwise). There the covariance is scaled by how well the window is explained: as under a
    chi-squared prior of the noise's variance.
    """
    prior = model.encoder
    if not isinstance(prior, StatePrior):
        if whole:
            raise InputError("only models that solve for their states (--preset places) can use a whole record")
        mean, log_variance = model.encode(windows)
        return mean, torch.diag_embed((0.5 * log_variance).exp())
    seen = windows if whole else windows[:, : model.config.encoder_samples]
    estimate = smooth_state(model, prior, seen) if whole else estimate_state(model, prior, seen)
    samples = seen.shape[1] * len(model.measured)
    scale = (2 * estimate.misfit + NOISE_FREEDOM) / (samples + NOISE_FREEDOM)  # (window,)
    return estimate.mean, torch.linalg.cholesky(estimate.covariance) * scale.sqrt()[:, None, None]


@torch.no_grad()
def generate(model: NeuralModalODE, q: FloatArray, q_dot: FloatArray, samples: int) -> Forecast:
    """Return the motion (1, time, ...) from modal coordinates and velocities (mode,) that the user sets."""
    state = [
        torch.tensor(values[None], dtype=model.channel_scale.dtype, device=model.channel_scale.device)
        for values in (q, q_dot)
    ]
    return joined([model.forecast(model.scale_state(*state), samples)])


def joined(parts: list[Trajectory]) -> Forecast:
    """Return trajectories of some windows after the other as one forecast."""

    def join(name: str) -> FloatArray:
        return np.concatenate([getattr(part, name).cpu().double().numpy() for part in parts])

    return Forecast(join("q"), join("q_dot"), join("q_ddot"), join("channels"))
