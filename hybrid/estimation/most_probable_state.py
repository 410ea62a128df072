"""The most probable initial state given a window's samples, and how sure it is: Gauss-Newton through the latent ODE.

    z0 minimises |(x - x(z0)) / std|^2 / 2 + z0^T P^-1 z0 / 2,   cov(z0) = (J^T J / std^2 + P^-1)^-1  (Laplace)

with J = dx/dz0 exact. Where the model is linear this is the Kalman smoother's answer; where it is not, the posterior
follows the learned forces, which no linear encoder can. Each window has its own damping (Levenberg & Marquardt).
"""

from dataclasses import dataclass

import torch
from torch import Tensor

from hybrid.estimation.config import STATE
from hybrid.estimation.trajectory_sensitivity import sensitivities, trajectory_jacobian
from hybrid.levenberg_marquardt import Damping
from hybrid.neural_modal_ode.driving import Driving, parts_of
from hybrid.neural_modal_ode.integrators import propagate, pushes_of
from hybrid.neural_modal_ode.model import NeuralModalODE
from hybrid.neural_modal_ode.state_prior import StatePrior

DAMPING = Damping(first=1e-3, easing=5.0, tightening=8.0)  # of the diagonal of the normal matrix


@dataclass(frozen=True)
class StateEstimate:
    """``mean`` (batch, 2 mode) and ``covariance`` (batch, 2 mode, 2 mode) of z0, scaled, and the ``misfit`` (batch,).

    The misfit is what is minimised: minus the logarithm of the posterior, without its constant.
    """

    mean: Tensor
    covariance: Tensor
    misfit: Tensor


def smooth_state(
    model: NeuralModalODE, prior: StatePrior, windows: Tensor, driving: Driving | None = None
) -> StateEstimate:
    """Return the posterior given whole windows (batch, time, sensor), however long: the span of samples grows."""
    parts = []
    known = parts_of(driving, STATE.windows_per_batch, len(windows))
    for batch, own in zip(windows.split(STATE.windows_per_batch), known, strict=True):
        span = model.config.encoder_samples
        estimate = estimate_state(model, prior, batch[:, :span], driving=own)
        while span < windows.shape[1]:
            span = round(STATE.span_growth * span)
            near = STATE.max_iterations_from_near
            estimate = estimate_state(model, prior, batch[:, :span], estimate.mean, near, own)
        parts.append(estimate)
    return StateEstimate(*(torch.cat([getattr(part, name) for part in parts]) for name in vars(parts[0])))


@torch.no_grad()
def estimate_state(
    model: NeuralModalODE,
    prior: StatePrior,
    windows: Tensor,
    start: Tensor | None = None,
    iterations: int = STATE.max_iterations,
    driving: Driving | None = None,
) -> StateEstimate:
    """Return the posterior of the initial state given all samples of ``windows`` (batch, time, sensor).

    Only measured channels are read. ``start`` (batch, 2 mode): where the search begins; left out: at rest.
    ``driving``: what is known to drive the windows, over at least as many samples.
    """
    known = None if driving is None else driving.first(windows.shape[1])
    seen = by_motion(model, windows, known)  # (time, batch, measured)
    z0 = windows.new_zeros(len(windows), len(prior.precision)) if start is None else start
    states = trajectory(model, z0, len(seen), known)
    misfit, residual = misfits(model, prior, states, seen)
    damping = torch.full_like(misfit, DAMPING.start)
    for _ in range(iterations):
        J = channel_slopes(model, prior, states)  # (batch, 2 mode, time * measured)
        normal = J @ J.transpose(1, 2) + prior.precision  # (batch, 2 mode, 2 mode)
        downhill = (J @ residual[..., None])[..., 0] - z0 @ prior.precision
        damped = normal + torch.diag_embed(damping[:, None] * normal.diagonal(dim1=1, dim2=2))
        move = torch.linalg.solve_ex(damped, downhill)[0]
        move = move * (STATE.max_step / move.norm(dim=1, keepdim=True)).clamp(max=1.0)
        tried = trajectory(model, z0 + move, len(seen), known)
        tried_misfit, tried_residual = misfits(model, prior, tried, seen)
        better = tried_misfit <= misfit  # (batch,); false where numbers overflow
        z0 = torch.where(better[:, None], z0 + move, z0)
        states = torch.where(better[:, None], tried, states)
        residual = torch.where(better[:, None], tried_residual, residual)
        misfit = torch.where(better, tried_misfit, misfit)
        damping = DAMPING.after(damping, better)
    J = channel_slopes(model, prior, states)
    return StateEstimate(z0, torch.linalg.inv(J @ J.transpose(1, 2) + prior.precision), misfit)


def by_motion(model: NeuralModalODE, windows: Tensor, driving: Driving | None) -> Tensor:
    """Return what the measured channels of windows show of the motion (time, batch, measured), and not of forces."""
    own = windows if driving is None else windows - driving.shown
    return own[:, :, model.measured].transpose(0, 1)


def trajectory(model: NeuralModalODE, z0: Tensor, samples: int, driving: Driving | None = None) -> Tensor:
    """Return the states at every substep (substep, batch, 2 mode); ``driving`` of as many samples."""
    every = model.substeps
    pushes = None if driving is None else pushes_of(model.dynamics, driving, model.step, every)
    states = propagate(model.dynamics, z0, (samples - 1) * every + 1, model.step / every, pushes)
    return states.transpose(0, 1).contiguous()


def misfits(model: NeuralModalODE, prior: StatePrior, states: Tensor, seen: Tensor) -> tuple[Tensor, Tensor]:
    """Return the misfit (batch,) and the channels' misfits in noise standard deviations (batch, time * measured).

    ``states`` (substep, batch, 2 mode), ``seen`` (time, batch, measured): see `by_motion`.
    """
    at_samples = states[:: model.substeps]
    channels = model.decode(at_samples, model.dynamics.force(at_samples))[..., model.measured]
    residual = ((seen - channels) / prior.noise_std).transpose(0, 1).flatten(1)
    z0 = states[0]
    return 0.5 * (residual.square().sum(dim=1) + ((z0 @ prior.precision) * z0).sum(dim=1)), residual


def channel_slopes(model: NeuralModalODE, prior: StatePrior, states: Tensor) -> Tensor:
    """Return d channels / dz_0 in noise standard deviations (batch, 2 mode, time * measured), along ``states``."""
    every = model.substeps
    linearised = trajectory_jacobian(model.dynamics, states, model.step / every)
    S = sensitivities(linearised)[::every]  # (time, batch, 2 mode, 2 mode)
    by_state, by_force = observation(model, prior)
    seen = S @ by_state + (S @ linearised.slopes[::every]) @ by_force  # (time, batch, 2 mode, measured)
    return seen.permute(1, 2, 0, 3).flatten(2)


def observation(model: NeuralModalODE, prior: StatePrior) -> tuple[Tensor, Tensor]:
    """Return d channels / dz (2 mode, measured) and d channels / d force (mode, measured), in noise deviations."""
    modes = model.dynamics.modes
    unit = torch.eye(3 * modes, dtype=prior.precision.dtype, device=prior.precision.device)
    channels = model.decode(unit[:, : 2 * modes], unit[:, 2 * modes :])[:, model.measured] / prior.noise_std
    return channels[: 2 * modes], channels[2 * modes :]
