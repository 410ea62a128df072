"""Backbone curves: frequency and damping that change with the size of the motion, on top of the linear rest and NN(z).

    q''_i / b_i = ... - kappa_i(s) omega_i q_i / b_i - delta_i(s) q'_i / b_i,     s = log10 of the scaled state's rms

Friction, cables and joints make a real structure softer and more damped the more it moves, all modes at once; over
some seconds a shift of a thousandth turns into a wrong phase. NN(z) can learn that in principle, yet from a few
recordings it learns it less well than two curves a mode, of a few numbers each.
"""

import torch
from torch import Tensor, nn

from hybrid.neural_modal_ode.config import BACKBONE_RESIDUAL
from hybrid.neural_modal_ode.residuals.free_residual import FreeResidual


class BackboneResidual(nn.Module):
    """`FreeResidual` and curves over the size of the motion, held beyond the first and the last of ``levels``."""

    def __init__(self, modes: int, hidden: int, zero_at_rest: bool) -> None:
        super().__init__()
        self.free = FreeResidual(modes, hidden, zero_at_rest)
        self.table = nn.Parameter(torch.zeros(BACKBONE_RESIDUAL.levels, 2 * modes))
        self.levels: Tensor
        self.register_buffer("levels", torch.linspace(-1.0, 0.0, BACKBONE_RESIDUAL.levels))

    def set_levels(self, states: Tensor) -> None:
        """Spread the levels over the sizes of scaled initial states (window, 2 mode)."""
        span = torch.tensor(BACKBONE_RESIDUAL.size_quantiles, dtype=states.dtype, device=states.device)
        low, high = torch.quantile(_size(states), span).tolist()
        self.levels.copy_(torch.linspace(low - BACKBONE_RESIDUAL.decay_decades, high, BACKBONE_RESIDUAL.levels))

    def linear(self, physical: Tensor) -> Tensor:
        """Return the learned linear map (mode, 2 mode), which comes on top of the physical part."""
        return self.free.linear(physical)

    def forward(self, z: Tensor) -> Tensor:
        """Return what is not linear, (..., mode), at scaled states (..., 2 mode)."""
        weights = BACKBONE_RESIDUAL.rate_per_unit * level_weights(_size(z), self.levels)  # (..., level), 1/s
        rates = weights @ self.table  # (..., 2 mode), 1/s
        of_q, of_q_dot = (rates * z).chunk(2, dim=-1)
        return self.free(z) - of_q - of_q_dot

    def slopes(self, z: Tensor) -> Tensor:
        """Return d force / dz (n, mode, 2 mode) at scaled states (n, 2 mode)."""
        return torch.func.vmap(torch.func.jacrev(lambda state: self(state[None])[0]))(z)


def _size(z: Tensor) -> Tensor:
    """Return log10 of the rms (...) of scaled states (..., 2 mode)."""
    return 0.5 * torch.log10(z.square().mean(dim=-1) + BACKBONE_RESIDUAL.min_mean_square)


def level_weights(x: Tensor, levels: Tensor) -> Tensor:
    """Return weights (..., level) of x (...) with sum one: linear between equidistant ``levels``, held beyond them."""
    held = x.clamp(levels[0], levels[-1])
    return (1 - (held[..., None] - levels).abs() / (levels[1] - levels[0])).clamp(min=0)
