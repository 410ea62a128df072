"""The normal equations of a least-squares fit of the learned forces, with each window's initial state projected out.

For small changes d of the forces' parameters and e of a window's initial state, the misfit r changes by -A^T d - B^T e.
The best e for a given d is known window by window, which leaves N d = g for the parameters alone:

    N = sum A A^T - A B^T M^-1 B A^T,    g = sum A r - A B^T M^-1 h,    M = B B^T + P^-1,    h = B r - P^-1 z0

(variable projection; Golub & Pereyra 1973). A comes from the differentiated recursion of the propagator.
"""

from dataclasses import dataclass

import torch
from torch import Tensor

from hybrid.estimation.most_probable_state import misfits, observation
from hybrid.estimation.trajectory_sensitivity import trajectory_jacobian
from hybrid.neural_modal_ode.integrators import propagator_weights
from hybrid.neural_modal_ode.model import NeuralModalODE
from hybrid.neural_modal_ode.residuals.connector_residual import ConnectorResidual
from hybrid.neural_modal_ode.state_prior import StatePrior


@dataclass(frozen=True)
class NormalEquations:
    """``matrix`` N (parameter, parameter) and ``downhill`` g (parameter,) of some windows, in double precision.

    A change d of the parameters moves the best initial states by ``own`` - ``coupling`` d, with ``own`` (batch, state)
    and ``coupling`` (batch, state, parameter).
    """

    matrix: Tensor
    downhill: Tensor
    own: Tensor
    coupling: Tensor


@torch.no_grad()
def normal_equations(
    model: NeuralModalODE,
    residual: ConnectorResidual,
    prior: StatePrior,
    states: Tensor,
    seen: Tensor,
    weights: Tensor,
) -> NormalEquations:
    """Return the equations at a trajectory ``states`` (substep, batch, 2 mode) for channels ``seen``.

    ``seen``: (time, batch, measured). ``weights`` (batch,): how much each window counts.
    """
    B, A = _channel_slopes(model, residual, prior, states).split([states.shape[2], residual.table.numel()], dim=1)
    _, misfit = misfits(model, prior, states, seen)  # (batch, time * measured)
    M = B @ B.transpose(1, 2) + prior.precision  # (batch, 2 mode, 2 mode)
    AB = B @ A.transpose(1, 2)  # (batch, 2 mode, parameter)
    h = (B @ misfit[..., None])[..., 0] - states[0] @ prior.precision  # (batch, 2 mode)
    solved = torch.linalg.solve(M, torch.cat([AB, h[..., None]], dim=2))
    coupling, own = solved[..., :-1], solved[..., -1]
    root = weights.sqrt()[:, None, None]
    flat = (A * root).transpose(0, 1).flatten(1)  # (parameter, batch * time * measured)
    matrix = flat @ flat.T - torch.einsum("bsp,bsr,b->pr", AB, coupling, weights)
    downhill = torch.einsum("bpt,bt,b->p", A, misfit, weights) - torch.einsum("bsp,bs,b->p", AB, own, weights)
    return NormalEquations(matrix.double(), downhill.double(), own, coupling)


def _channel_slopes(model: NeuralModalODE, residual: ConnectorResidual, prior: StatePrior, states: Tensor) -> Tensor:
    """Return d channels / d [z0, parameters] in noise deviations (batch, 2 mode + parameter, time * measured)."""
    every, modes = model.substeps, model.dynamics.modes
    step = model.step / every
    linearised = trajectory_jacobian(model.dynamics, states, step)
    _, now, _ = propagator_weights(model.dynamics, step).split([2 * modes, modes, modes])
    by_state, by_force = observation(model, prior)
    to_channels = by_state + linearised.slopes[::every] @ by_force  # (time, batch, 2 mode, measured)
    laws = residual.parameter_slopes(states.flatten(0, 1)).unflatten(0, states.shape[:2])  # (substep, batch, place, .)
    kicks = torch.cat([-residual.feeds @ now, -residual.feeds], dim=1)  # (place, 3 mode): a force, in [z, f_before]
    seen_kicks = -residual.feeds @ by_force  # (place, measured)

    def of_places(k: int, each: Tensor) -> Tensor:
        """Return what every parameter does at substep k through ``each`` (place, .), shape (batch, parameter, .)."""
        return (laws[k][..., None] * each[:, None]).flatten(1, 2)

    batch, parameters = states.shape[1], residual.table.numel()
    rows = states.new_zeros(batch, 2 * modes + parameters, 3 * modes)  # d [z_k, f_k-1] / d [z0, parameters]
    rows[:, : 2 * modes, : 2 * modes] = torch.eye(2 * modes, dtype=rows.dtype, device=rows.device)
    rows[:, : 2 * modes, 2 * modes :] = linearised.slopes[0]
    rows[:, 2 * modes :, 2 * modes :] = of_places(0, -residual.feeds)
    kick = torch.zeros_like(rows)
    seen = states.new_empty(len(to_channels), *rows.shape[:2], by_force.shape[1])
    for k, transition in enumerate(linearised.transitions.unbind()):
        if k % every == 0:
            torch.bmm(rows[..., : 2 * modes], to_channels[k // every], out=seen[k // every])
            seen[k // every, :, 2 * modes :] += of_places(k, seen_kicks)
        kick[:, 2 * modes :] = of_places(k, kicks)
        rows = torch.baddbmm(kick, rows, transition)
    return seen.permute(1, 2, 0, 3).flatten(2)
