"""What is learned of the dynamics where no place is known for it: a free map of the modal state, or nothing."""

import torch
from torch import Tensor, nn

from hybrid.neural_modal_ode.networks import mlp, start_at_zero


class NoResidual(nn.Module):
    """Nothing learned: the FE model."""

    def __init__(self, modes: int) -> None:
        super().__init__()
        self.modes = modes

    def linear(self, physical: Tensor) -> Tensor:
        """Return zeros (mode, 2 mode)."""
        return torch.zeros_like(physical)

    def forward(self, z: Tensor) -> Tensor:
        """Return zeros (..., mode)."""
        return torch.zeros_like(z[..., : self.modes])

    def slopes(self, z: Tensor) -> Tensor:
        """Return zeros (n, mode, 2 mode) at scaled states (n, 2 mode)."""
        return z.new_zeros(len(z), self.modes, 2 * self.modes)


class FreeResidual(nn.Module):
    """A linear map of z and NN(z) of Lai et al. 2022, in units of q'' / b.

    A structure at rest stays at rest: with ``zero_at_rest`` the net enters as NN(z) - NN(0), and starts at zero.
    """

    def __init__(self, modes: int, hidden: int, zero_at_rest: bool) -> None:
        super().__init__()
        self.rest = nn.Linear(2 * modes, modes, bias=False)
        nn.init.zeros_(self.rest.weight)
        self.net = mlp(2 * modes, hidden, modes)
        self.zero_at_rest = zero_at_rest
        if zero_at_rest:
            start_at_zero(self.net)

    def linear(self, physical: Tensor) -> Tensor:
        """Return the learned linear map (mode, 2 mode), which comes on top of the physical part."""
        return self.rest.weight

    def forward(self, z: Tensor) -> Tensor:
        """Return the net's part (..., mode) at scaled states (..., 2 mode)."""
        force = self.net(z)
        return force - self.net(torch.zeros_like(z[..., :1, :])) if self.zero_at_rest else force

    def slopes(self, z: Tensor) -> Tensor:
        """Return d net / dz (n, mode, 2 mode) at scaled states (n, 2 mode)."""
        return torch.func.vmap(torch.func.jacrev(self.net))(z)
