"""What is learned of the dynamics: a free map of the modal state, forces at places of the structure, or nothing."""

from collections.abc import Callable

import torch
from torch import Tensor, nn

from hybrid.connectors import Connectors
from hybrid.networks import mlp, start_at_zero
from hybrid.scaling import StateScale


def local_slopes(laws: Callable[[Tensor, Tensor], Tensor], u: Tensor, v: Tensor) -> tuple[Tensor, Tensor]:
    """Return d law / du and d law / dv, both shaped as u, of laws that act on each entry of u and v by itself.

    The gradient of the sum of all forces then holds each one's own derivative.
    """
    with torch.enable_grad():
        u, v = u.detach().requires_grad_(), v.detach().requires_grad_()
        by_u, by_v = torch.autograd.grad(laws(u, v).sum(), (u, v), allow_unused=True)
    zero = torch.zeros_like(u)  # the slope of a law that does not feel u, or v
    return zero if by_u is None else by_u, zero if by_v is None else by_v


def place_slopes(
    laws: Callable[[Tensor, Tensor], Tensor], elongations: Tensor, rates: Tensor, feeds: Tensor, z: Tensor
) -> Tensor:
    """Return d (feeds^T laws(u, v)) / dz, (n, mode, 2 mode), with u = elongations z1, v = rates z2 at z (n, 2 mode).

    ``elongations``, ``rates`` and ``feeds``: (place, mode); ``laws`` take and give (place, n).
    """
    z1, z2 = z.chunk(2, dim=-1)  # (n, mode) each
    by_u, by_v = local_slopes(laws, elongations @ z1.T, rates @ z2.T)  # (place, n) each
    columns = torch.cat([by_u[..., None] * elongations[:, None], by_v[..., None] * rates[:, None]], dim=-1)
    return torch.einsum("cm,cnk->nmk", feeds, columns)  # columns: (place, n, 2 mode)


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


class ConnectorResidual(nn.Module):
    """A spring, a dashpot and a small net for each place of the structure: f(u, v) = k u + c v + net(u, v) - net(0, 0).

    The springs and dashpots stand for the whole linear part, so that the linear rest is what they have beyond the
    nominal one.
    """

    def __init__(self, connectors: Connectors, scale: StateScale, hidden: int) -> None:
        super().__init__()
        dtype = torch.get_default_dtype()
        count = len(connectors.names)
        shapes, feeds = (torch.tensor(part, dtype=dtype) for part in (connectors.shapes, connectors.feeds))
        a, b = torch.tensor(scale.displacement, dtype=dtype), torch.tensor(scale.velocity, dtype=dtype)
        self.elongations: Tensor
        self.rates: Tensor
        self.feeds: Tensor
        self.sizes: Tensor
        self.register_buffer("elongations", shapes * a)  # (connector, mode): u = elongations z1
        self.register_buffer("rates", shapes * b)  # (connector, mode): v = rates z2
        self.register_buffer("feeds", feeds / b)  # (connector, mode): q'' / b a unit of force
        u, v = self.elongations.norm(dim=1), self.rates.norm(dim=1)
        force = (b / a).mean() / self.feeds.norm(dim=1)  # gives q'' of the size it has in free vibration
        self.register_buffer("sizes", torch.stack([u, v, force]))  # (3, connector): of u, v and the force
        self.springs = nn.Parameter(torch.zeros(2, count, dtype=dtype))  # k and c in units of force / u, force / v
        self.weight = nn.Parameter(torch.randn(count, 2, hidden, dtype=dtype))
        self.bias = nn.Parameter(torch.randn(count, 1, hidden, dtype=dtype))
        self.out = nn.Parameter(torch.zeros(count, hidden, 1, dtype=dtype))

    def linear(self, physical: Tensor) -> Tensor:
        """Return what springs and dashpots have beyond the ``physical`` part, (mode, 2 mode)."""
        k, c = self.coefficients()
        stiffness = -(self.feeds.T * k) @ self.elongations
        damping = -(self.feeds.T * c) @ self.rates
        return torch.cat([stiffness, damping], dim=1) - physical

    def coefficients(self) -> tuple[Tensor, Tensor]:
        """Return the linear springs k (N/m) and dashpots c (N s/m), (connector,) each."""
        u, v, force = self.sizes
        return self.springs[0] * force / u, self.springs[1] * force / v

    def set_coefficients(self, k: Tensor, c: Tensor) -> None:
        """Set the linear springs (N/m) and dashpots (N s/m), (connector,) each."""
        u, v, force = self.sizes
        with torch.no_grad():
            self.springs.copy_(torch.stack([k * u / force, c * v / force]))

    def laws(self, u: Tensor, v: Tensor) -> Tensor:
        """Return the nets' forces (N), (connector, n), at elongations u (m) and rates v (m/s) of the same shape."""
        inputs = torch.stack([u / self.sizes[0, :, None], v / self.sizes[1, :, None]], dim=-1)  # (connector, n, 2)
        at_rest = torch.bmm(torch.tanh(self.bias), self.out)  # (connector, 1, 1)
        moving = torch.bmm(torch.tanh(torch.baddbmm(self.bias, inputs, self.weight)), self.out)
        return (moving - at_rest)[..., 0] * self.sizes[2, :, None]

    def forward(self, z: Tensor) -> Tensor:
        """Return the nets' part of q'' / b, (..., mode), at scaled states (..., 2 mode)."""
        z1, z2 = z.flatten(0, -2).chunk(2, dim=-1)  # (n, mode) each
        force = self.laws(self.elongations @ z1.T, self.rates @ z2.T)  # (connector, n)
        return -(force.T @ self.feeds).reshape(*z.shape[:-1], -1)

    def slopes(self, z: Tensor) -> Tensor:
        """Return d forward / dz (n, mode, 2 mode) at scaled states (n, 2 mode)."""
        return -place_slopes(self.laws, self.elongations, self.rates, self.feeds, z)


Residual = NoResidual | FreeResidual | ConnectorResidual
