"""Slopes of force laws that act at places, and of what they do to the modal state."""

from collections.abc import Callable

import torch
from torch import Tensor


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
