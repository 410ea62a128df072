"""A trajectory of the propagator, linearised: how each state depends on the ones before it.

A step takes y_k = [z_k, f_k-1] to y_k+1. With J_k = df/dz at z_k, small changes follow dy_k+1 = dy_k T_k as rows:

    T_k = [[free + J_k now, J_k], [before, 0]]

All slopes of all times are taken at once; only products of small matrices are left to the loop over time.
"""

from dataclasses import dataclass

import torch
from torch import Tensor

from hybrid.neural_modal_ode.dynamics import ModalDynamics
from hybrid.neural_modal_ode.integrators import propagator_weights


@dataclass(frozen=True)
class TrajectoryJacobian:
    """``slopes`` J^T (time, batch, 2 mode, mode) and ``transitions`` T (time, batch, 3 mode, 3 mode)."""

    slopes: Tensor
    transitions: Tensor


def trajectory_jacobian(dynamics: ModalDynamics, states: Tensor, step: float) -> TrajectoryJacobian:
    """Return the linearisation along ``states`` (time, batch, 2 mode), ``step`` (s) apart."""
    modes = dynamics.modes
    free, now, before = propagator_weights(dynamics, step).split([2 * modes, modes, modes])
    slopes = dynamics.force_slopes(states.flatten(0, 1)).transpose(1, 2)  # (time * batch, 2 mode, mode)
    transitions = slopes.new_zeros(len(slopes), 3 * modes, 3 * modes)
    transitions[:, : 2 * modes, : 2 * modes] = slopes @ now + free
    transitions[:, : 2 * modes, 2 * modes :] = slopes
    transitions[:, 2 * modes :, : 2 * modes] = before
    shape = states.shape[:2]
    return TrajectoryJacobian(slopes.unflatten(0, shape), transitions.unflatten(0, shape))


def sensitivities(linearised: TrajectoryJacobian) -> Tensor:
    """Return dz_k / dz_0, (time, batch, 2 mode of z_0, 2 mode of z_k)."""
    slopes, transitions = linearised.slopes, linearised.transitions
    modes = slopes.shape[3]
    S = transitions.new_empty(*transitions.shape[:2], 2 * modes, 3 * modes)
    S[0, :, :, : 2 * modes] = torch.eye(2 * modes, dtype=S.dtype, device=S.device)
    S[0, :, :, 2 * modes :] = slopes[0]  # the first step has no force before it and takes its own
    rows = S.unbind()
    for k, transition in enumerate(transitions[:-1].unbind()):
        torch.bmm(rows[k], transition, out=rows[k + 1])
    return S[..., : 2 * modes]
