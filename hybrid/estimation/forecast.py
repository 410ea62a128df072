"""Forecasts of windows from their first samples: by the hybrid model, or by its FE counterpart from the same start."""

from dataclasses import dataclass

import numpy as np
import torch
from torch import Tensor

from fe_models.arrays import FloatArray
from fe_models.errors import InputError
from hybrid.estimation.config import UNCERTAINTY
from hybrid.estimation.experts import Experts, Hybrid
from hybrid.estimation.most_probable_state import estimate_state, smooth_state
from hybrid.neural_modal_ode.driving import Driving
from hybrid.neural_modal_ode.model import Trajectory
from hybrid.neural_modal_ode.state_prior import StatePrior


@dataclass(frozen=True)
class Forecast:
    """Modal coordinates and rates (window, time, mode), and channels (window, time, sensor)."""

    q: FloatArray
    q_dot: FloatArray
    q_ddot: FloatArray
    channels: FloatArray


@torch.no_grad()
def forecast_windows(
    model: Hybrid,
    windows: FloatArray,
    dynamics: Hybrid | None = None,
    samples: int | None = None,
    whole: bool = False,
    driving: Driving | None = None,
) -> Forecast:
    """Forecast windows (window, time, sensor) from their first samples, starting at the mean of q(z0 | samples).

    ``dynamics`` (the FE counterpart, say) forecasts in place of ``model``, from the state that ``model`` encodes;
    ``samples`` of them, or as many as the windows have. ``whole``: see `posterior`. ``driving``: what is known to drive
    the windows, over as many samples.
    """
    parts: list[Trajectory] = []
    for start in range(0, len(windows), UNCERTAINTY.windows_per_batch):
        batch = torch.tensor(
            windows[start : start + UNCERTAINTY.windows_per_batch],
            dtype=model.channel_scale.dtype,
            device=model.channel_scale.device,
        )
        known = None if driving is None else driving[start : start + UNCERTAINTY.windows_per_batch].to(batch)
        mean, _ = posterior(model, batch, whole, known)
        parts.append((dynamics or model).forecast(mean, samples or windows.shape[1], known))
    return joined(parts)


def solves_for_states(model: Hybrid) -> bool:
    """Return whether the model solves for its states through its dynamics, instead of encoding them."""
    return not isinstance(model, Experts) and isinstance(model.encoder, StatePrior)


@torch.no_grad()
def posterior(
    model: Hybrid, windows: Tensor, whole: bool = False, driving: Driving | None = None
) -> tuple[Tensor, Tensor]:
    """Return the mean (window, 2 mode) of z0 given windows (window, time, sensor), and a root of its covariance.

    From the windows' first samples, or, ``whole``, from all of them: that needs a model which solves for its states
    (`InputError` otherwise). There the covariance is scaled by how well the window is explained: as under a
    chi-squared prior of the noise's variance. ``driving``: what is known to drive the windows.
    """
    if whole and not solves_for_states(model):
        raise InputError("only models that solve for their states (--preset places) can use a whole record")
    if isinstance(model, Experts):  # their own errors are much larger than what a start leaves open
        state = model.initial_state(windows)
        return state, state.new_zeros(*state.shape, state.shape[1])
    prior = model.encoder
    if not isinstance(prior, StatePrior):
        mean, log_variance = model.encode(windows, driving)
        return mean, torch.diag_embed((0.5 * log_variance).exp())
    seen = windows if whole else windows[:, : model.config.encoder_samples]
    estimate = (smooth_state if whole else estimate_state)(model, prior, seen, driving=driving)
    samples = seen.shape[1] * len(model.measured)
    # (window,)
    scale = (2 * estimate.misfit + UNCERTAINTY.noise_degrees_of_freedom) / (
        samples + UNCERTAINTY.noise_degrees_of_freedom
    )
    root = torch.linalg.cholesky_ex(estimate.covariance)[0]  # no number where the forecasts are none
    return estimate.mean, root * scale.sqrt()[:, None, None]


@torch.no_grad()
def generate(model: Hybrid, q: FloatArray, q_dot: FloatArray, samples: int) -> Forecast:
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
