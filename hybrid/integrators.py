"""From the initial modal state to the state at every sample: the modal propagator, or a solver of `torchdiffeq`."""

import torch
from torch import Tensor
from torchdiffeq import odeint, odeint_adjoint

from hybrid.config import IntegratorKind
from hybrid.dynamics import ModalDynamics

DOPRI5_TOLERANCE = 1e-6  # relative and absolute, of a scaled state near one


def integrate(
    dynamics: ModalDynamics, z0: Tensor, samples: int, step: float, method: IntegratorKind, substeps: int = 1
) -> Tensor:
    """Return scaled states (batch, time, 2 mode) at ``samples`` instants ``step`` (s) apart, from z0 (batch, 2 mode).

    "propagator": exact for the linear part, second order in the step for the rest, ``substeps`` of them a sample.
    "rk4": one step a sample. "dopri5": adaptive, gradients by the adjoint equation.
    """
    if method == "propagator":
        return propagate(dynamics, z0, (samples - 1) * substeps + 1, step / substeps)[:, ::substeps]
    times = torch.arange(samples, dtype=z0.dtype, device=z0.device) * step
    if method == "rk4":
        states = odeint(dynamics, z0, times, method="rk4")
    else:
        states = odeint_adjoint(dynamics, z0, times, method="dopri5", rtol=DOPRI5_TOLERANCE, atol=DOPRI5_TOLERANCE)
    return states.transpose(0, 1)


def propagate(dynamics: ModalDynamics, z0: Tensor, samples: int, step: float) -> Tensor:
    """Exponential Adams-Bashforth of second order: z+ = e^{Ah} z + h phi1(Ah) B f + h phi2(Ah) B (f - f_before).

    One evaluation of f a step; exact for any step where f is zero (Hochbruck & Ostermann 2010, sec. 2.5). The first
    step has no f before it and takes its own: first order once leaves the order of the whole at two.
    """
    weights = propagator_weights(dynamics, step)  # (4 mode, 2 mode)
    z, before = z0, None
    states = [z0]
    for _ in range(samples - 1):
        force = dynamics.force(z)  # (batch, mode)
        z = torch.cat([z, force, force if before is None else before], dim=-1) @ weights
        before = force
        states.append(z)
    return torch.stack(states, dim=1)


def sensitivities(dynamics: ModalDynamics, states: Tensor, slopes: Tensor, step: float) -> Tensor:
    """Return dz_k / dz_0, (batch, time, 2 mode, 2 mode), of a trajectory of `propagate`: its recursion, differentiated.

    ``states`` (batch, time, 2 mode); ``slopes`` (batch, time, mode, 2 mode): df/dz along them.
    """
    modes = dynamics.modes
    free, now, before = propagator_weights(dynamics, step).T.split([2 * modes, modes, modes], dim=1)
    identity = torch.eye(2 * modes, dtype=states.dtype, device=states.device)
    S = identity.expand(len(states), -1, -1)  # (batch, 2 mode, 2 mode)
    S_all, kick_before = [S], None
    for k in range(states.shape[1] - 1):
        kick = slopes[:, k] @ S  # (batch, mode, 2 mode)
        S = free @ S + now @ kick + before @ (kick if kick_before is None else kick_before)
        kick_before = kick
        S_all.append(S)
    return torch.stack(S_all, dim=1)


def propagator_weights(dynamics: ModalDynamics, step: float) -> Tensor:
    """Return W (4 mode, 2 mode) with z+ = [z, f, f_before] W, all blocks from one matrix exponential.

    exp of [[A, B, 0], [0, 0, I], [0, 0, 0]] h has the blocks e^{Ah}, h phi1 B and h^2 phi2 B in its first rows, where
    B = [0, I]^T feeds forces into the velocities (Al-Mohy & Higham 2011, theorem 2.1).
    """
    A = dynamics.linear_part()
    modes = dynamics.modes
    eye = torch.eye(modes, dtype=A.dtype, device=A.device)
    augmented = torch.cat(
        [
            torch.cat([A, A.new_zeros(2 * modes, 2 * modes)], dim=1),
            A.new_zeros(2 * modes, 4 * modes),
        ]
    )
    feed = torch.zeros_like(augmented)
    feed[modes : 2 * modes, 2 * modes : 3 * modes] = eye
    feed[2 * modes : 3 * modes, 3 * modes :] = eye
    blocks = torch.matrix_exp((augmented + feed) * step)[: 2 * modes]
    free, held, ramp = blocks.split([2 * modes, modes, modes], dim=1)
    return torch.cat([free, held + ramp / step, -ramp / step], dim=1).T
