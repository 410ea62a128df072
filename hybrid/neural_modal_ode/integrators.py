"""From the initial modal state to the state at every sample: the modal propagator, or a solver of `torchdiffeq`."""

import torch
from torch import Tensor, nn
from torchdiffeq import odeint, odeint_adjoint

from hybrid.config import IntegratorKind
from hybrid.neural_modal_ode.driving import Driving
from hybrid.neural_modal_ode.dynamics import ModalDynamics
from hybrid.neural_modal_ode.residuals.connector_residual import ConnectorResidual
from hybrid.neural_modal_ode.tanh_recursion import TanhRecursion

DOPRI5_TOLERANCE = 1e-6  # relative and absolute, of a scaled state near one


def integrate(
    dynamics: ModalDynamics,
    z0: Tensor,
    samples: int,
    step: float,
    method: IntegratorKind,
    substeps: int = 1,
    driving: Driving | None = None,
) -> Tensor:
    """Return scaled states (batch, time, 2 mode) at ``samples`` instants ``step`` (s) apart, from z0 (batch, 2 mode).

    ``driving``: known forces, of at least as many samples. "propagator": exact for the linear part and for these
    forces, second order in the step for the rest, ``substeps`` of them a sample.
    "rk4": one step a sample. "dopri5": adaptive, gradients by the adjoint equation.
    """
    if method == "propagator":
        pushes = None if driving is None else pushes_of(dynamics, driving.first(samples), step, substeps)
        return propagate(dynamics, z0, (samples - 1) * substeps + 1, step / substeps, pushes)[:, ::substeps]
    times = torch.arange(samples, dtype=z0.dtype, device=z0.device) * step
    rate = dynamics if driving is None else _Driven(dynamics, driving, step)
    if method == "rk4":
        states = odeint(rate, z0, times, method="rk4")
    else:
        states = odeint_adjoint(rate, z0, times, method="dopri5", rtol=DOPRI5_TOLERANCE, atol=DOPRI5_TOLERANCE)
    return states.transpose(0, 1)


class _Driven(nn.Module):
    """dz/dt under known forces, in the form that `torchdiffeq` asks for."""

    def __init__(self, dynamics: ModalDynamics, driving: Driving, step: float) -> None:
        super().__init__()
        self.dynamics, self.driving, self.step = dynamics, driving, step

    def forward(self, t: Tensor, z: Tensor) -> Tensor:
        """Return dz/dt (..., 2 mode)."""
        rate: Tensor = self.dynamics(t, z)
        known = self.driving.at(t / self.step) / self.dynamics.b
        return rate + torch.cat([torch.zeros_like(known), known], dim=-1)


def pushes_of(dynamics: ModalDynamics, driving: Driving, step: float, substeps: int) -> Tensor:
    """Return what known forces add to the scaled state over each substep, (batch, substep, 2 mode)."""
    feed = driving.participation.T / dynamics.b[:, None]  # (mode, place)
    return driving.pushes(dynamics.linear_part(), torch.cat([torch.zeros_like(feed), feed]), step, substeps)


def propagate(dynamics: ModalDynamics, z0: Tensor, samples: int, step: float, pushes: Tensor | None = None) -> Tensor:
    """Exponential Adams-Bashforth of second order: z+ = e^{Ah} z + h phi1(Ah) B f + h phi2(Ah) B (f - f_before).

    One evaluation of f a step; exact for any step where f is zero (Hochbruck & Ostermann 2010, sec. 2.5). The first
    step has no f before it and takes its own: first order once leaves the order of the whole at two. ``pushes``
    (batch, samples - 1, 2 mode): what known forces add over each step, see `pushes_of`.
    """
    weights = propagator_weights(dynamics, step)  # (4 mode, 2 mode)
    if isinstance(dynamics.residual, ConnectorResidual) and not dynamics.effects:
        return _propagate_nets(dynamics.residual, weights, z0, samples, pushes)
    z, before = z0, None
    states = [z0]
    for k in range(samples - 1):
        force = dynamics.force(z)  # (batch, mode)
        z = torch.cat([z, force, force if before is None else before], dim=-1) @ weights
        z = z if pushes is None else z + pushes[:, k]
        before = force
        states.append(z)
    return torch.stack(states, dim=1)


def _propagate_nets(
    residual: ConnectorResidual, weights: Tensor, z0: Tensor, samples: int, pushes: Tensor | None
) -> Tensor:
    """Return what the loop of `propagate` gives, the nets of all places as one: f = tanh(z into + bias) out - c."""
    modes = residual.feeds.shape[1]
    weight, bias, out = residual.nets()
    of_u, of_v = (weight / residual.sizes[:2].T[..., None]).unbind(dim=1)  # (place, hidden) each: 1/m, s/m
    # (2 mode, place * hidden)
    into = torch.cat(
        [
            (residual.elongations.T[..., None] * of_u).flatten(1),
            (residual.rates.T[..., None] * of_v).flatten(1),
        ]
    )
    gain = -(residual.feeds * residual.sizes[2, :, None])[:, None] * out  # (place, hidden, mode)
    at_rest = (torch.tanh(bias).transpose(1, 2) * gain).sum(dim=(0, 1))  # (mode,)
    free, held, ramp = weights.split([2 * modes, modes, modes])
    now, before = gain.flatten(0, 1) @ held, gain.flatten(0, 1) @ ramp  # (place * hidden, 2 mode) each
    drift = -at_rest @ (held + ramp)  # (2 mode,)
    states: Tensor = TanhRecursion.apply(  # type: ignore[no-untyped-call]
        z0, free, now, before, drift, into, bias.flatten(), samples, None if pushes is None else pushes.transpose(0, 1)
    )
    return states.transpose(0, 1)


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
