"""The learned rest as forces at places of the structure: a spring, a dashpot and a small net at each of them."""

import torch
from torch import Tensor, nn

from hybrid.neural_modal_ode.connectors import Connectors
from hybrid.neural_modal_ode.scaling import StateScale


class ConnectorResidual(nn.Module):
    """f(u, v) = k u + c v + net(u, v) - net(0, 0) at each place, with one layer of tanh in each net.

    The springs and dashpots stand for the whole linear part, so that the linear rest is what they have beyond the
    nominal one. ``table`` (place, 2 + 4 hidden) holds, for each place, k and c in units of force / u and
    force / v, then the net's weights on u and on v, its biases and its outputs.
    """

    def __init__(self, connectors: Connectors, scale: StateScale, hidden: int) -> None:
        super().__init__()
        dtype = torch.get_default_dtype()
        count = len(connectors.names)
        self.hidden = hidden
        shapes, feeds = (torch.tensor(part, dtype=dtype) for part in (connectors.shapes, connectors.feeds))
        a, b = torch.tensor(scale.displacement, dtype=dtype), torch.tensor(scale.velocity, dtype=dtype)
        self.elongations: Tensor
        self.rates: Tensor
        self.feeds: Tensor
        self.sizes: Tensor
        self.register_buffer("elongations", shapes * a)  # (place, mode): u = elongations z1
        self.register_buffer("rates", shapes * b)  # (place, mode): v = rates z2
        self.register_buffer("feeds", feeds / b)  # (place, mode): q'' / b a unit of force
        u, v = self.elongations.norm(dim=1), self.rates.norm(dim=1)
        force = (b / a).mean() / self.feeds.norm(dim=1)  # gives q'' of the size it has in free vibration
        self.register_buffer("sizes", torch.stack([u, v, force]))  # (3, place): of u, v and the force
        table = torch.randn(count, 2 + 4 * hidden, dtype=dtype)
        table[:, :2] = 0
        table[:, -hidden:] = 0
        self.table = nn.Parameter(table)

    def nets(self) -> tuple[Tensor, Tensor, Tensor]:
        """Return weights (place, 2, hidden), biases (place, 1, hidden) and outputs (place, hidden, 1) of the nets."""
        places, hidden = len(self.table), self.hidden
        weight, bias, out = self.table[:, 2:].split([2 * hidden, hidden, hidden], dim=1)
        return weight.reshape(places, 2, hidden), bias[:, None], out[..., None]

    def linear(self, physical: Tensor) -> Tensor:
        """Return what springs and dashpots have beyond the ``physical`` part, (mode, 2 mode)."""
        k, c = self.coefficients()
        stiffness = -(self.feeds.T * k) @ self.elongations
        damping = -(self.feeds.T * c) @ self.rates
        return torch.cat([stiffness, damping], dim=1) - physical

    def coefficients(self) -> tuple[Tensor, Tensor]:
        """Return the linear springs k (N/m) and dashpots c (N s/m), (place,) each."""
        u, v, force = self.sizes
        return self.table[:, 0] * force / u, self.table[:, 1] * force / v

    def set_coefficients(self, k: Tensor, c: Tensor) -> None:
        """Set the linear springs (N/m) and dashpots (N s/m), (place,) each."""
        u, v, force = self.sizes
        with torch.no_grad():
            self.table[:, 0] = k * u / force
            self.table[:, 1] = c * v / force

    def laws(self, u: Tensor, v: Tensor) -> Tensor:
        """Return the nets' forces (N), (place, n), at elongations u (m) and rates v (m/s) of the same shape."""
        weight, bias, out = self.nets()
        at_rest = torch.bmm(torch.tanh(bias), out)  # (place, 1, 1)
        moving = torch.bmm(torch.tanh(torch.baddbmm(bias, self._inputs(u, v), weight)), out)
        return (moving - at_rest)[..., 0] * self.sizes[2, :, None]

    def forward(self, z: Tensor) -> Tensor:
        """Return the nets' part of q'' / b, (..., mode), at scaled states (..., 2 mode)."""
        force = self.laws(*self._elongations_and_rates(z.flatten(0, -2)))  # (place, n)
        return -(force.T @ self.feeds).reshape(*z.shape[:-1], -1)

    def slopes(self, z: Tensor) -> Tensor:
        """Return d forward / dz (n, mode, 2 mode) at scaled states (n, 2 mode)."""
        weight, bias, out = self.nets()
        weight = weight * (self.sizes[2] / self.sizes[:2]).T[..., None]  # (place, 2, hidden): N a unit of u and of v
        bent = torch.tanh(torch.baddbmm(bias, self._inputs(*self._elongations_and_rates(z)), self.nets()[0]))
        gains = weight * out.transpose(1, 2)  # (place, 2, hidden)
        slopes = gains.sum(dim=2)[:, None] - torch.bmm(bent.square(), gains.transpose(1, 2))  # (place, n, 2)
        columns = torch.stack([self.elongations, self.rates], dim=1)  # (place, 2, mode)
        each = self.feeds[:, None, :, None] * columns[:, :, None]  # (place, 2, mode, mode)
        modes = self.feeds.shape[1]
        by_u, by_v = (slopes[..., i].T @ each[:, i].flatten(1) for i in range(2))  # (n, mode * mode) each
        return -torch.cat([by_u.view(-1, modes, modes), by_v.view(-1, modes, modes)], dim=2)

    def parameter_slopes(self, z: Tensor) -> Tensor:
        """Return d force / d ``table`` (n, place, 2 + 4 hidden) in N at scaled states (n, 2 mode).

        The springs and dashpots count here as forces like the nets': what they do over a step, to first order.
        """
        weight, bias, out = self.nets()
        inputs = self._inputs(*self._elongations_and_rates(z))  # (place, n, 2)
        bent, at_rest = torch.tanh(torch.baddbmm(bias, inputs, weight)), torch.tanh(bias)
        steep, steep_at_rest = ((1 - x.square()) * out.transpose(1, 2) for x in (bent, at_rest))
        u, v = inputs[..., :1], inputs[..., 1:]
        slopes = torch.cat([u, v, steep * u, steep * v, steep - steep_at_rest, bent - at_rest], dim=2)
        return (slopes * self.sizes[2, :, None, None]).transpose(0, 1)

    def _elongations_and_rates(self, z: Tensor) -> tuple[Tensor, Tensor]:
        z1, z2 = z.chunk(2, dim=-1)  # (n, mode) each
        return self.elongations @ z1.T, self.rates @ z2.T

    def _inputs(self, u: Tensor, v: Tensor) -> Tensor:
        return torch.stack([u / self.sizes[0, :, None], v / self.sizes[1, :, None]], dim=-1)  # (place, n, 2)
