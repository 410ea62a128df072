"""The propagator's loop for a net with one layer of tanh, with everything linear around the tanh folded into it.

    h_k = tanh(z_k into + bias),    z_k+1 = z_k free + h_k now + h_k-1 before + drift + push_k,    h_-1 = h_0

Four small operations a step, and a backward pass written out: a loop that autograd records costs ten times as much.
"""

from typing import Any

import torch
from torch import Tensor
from torch.autograd.function import once_differentiable


class TanhRecursion(torch.autograd.Function):
    """States (time, batch, state) of the recursion above.

    Arguments: z0 (batch, state), free (state, state), now and before (hidden, state), drift (state,), into (state,
    hidden), bias (hidden,), the number of samples, and the pushes (samples - 1, batch, state), None for none. The
    gradient is that of the whole trajectory.
    """

    @staticmethod
    def forward(
        ctx: Any,
        z0: Tensor,
        free: Tensor,
        now: Tensor,
        before: Tensor,
        drift: Tensor,
        into: Tensor,
        bias: Tensor,
        samples: int,
        pushes: Tensor | None = None,
    ) -> Tensor:
        """Return the states (samples, batch, state)."""
        z = z0.new_empty(samples, *z0.shape)
        h = z0.new_empty(samples, len(z0), len(bias))
        z[0] = z0
        states, bent = z.unbind(), h.unbind()
        for k in range(samples - 1):
            torch.tanh(torch.addmm(bias, states[k], into), out=bent[k])
            move = torch.addmm(drift, bent[k], now).addmm_(bent[max(k - 1, 0)], before)
            if pushes is not None:
                move += pushes[k]
            torch.addmm(move, states[k], free, out=states[k + 1])
        ctx.save_for_backward(z, h, free, now, before, into)
        ctx.is_pushed = pushes is not None
        return z

    @staticmethod
    @once_differentiable
    def backward(ctx: Any, *gradients: Tensor) -> tuple[Tensor | None, ...]:
        """Return the gradient of each argument, by the adjoint recursion."""
        z, h, free, now, before, into = ctx.saved_tensors
        steps = len(z) - 1
        free_T, into_T = free.T.contiguous(), into.T.contiguous()
        both_T = torch.cat([now, before]).T.contiguous()  # (state, 2 hidden)
        bend = 1 - h.square()  # dh/d(z into + bias), (time, batch, hidden)
        kick = torch.empty_like(h)  # d loss / d(z into + bias)
        kick[steps:] = 0  # the last state bends nothing
        adjoint = gradients[0].clone()  # becomes d loss / dz_k, of all that follows
        later: Tensor | float = 0.0
        lambdas, kicks, bends = adjoint.unbind(), kick.unbind(), bend.unbind()
        for k in range(steps - 1, -1, -1):
            by_now, by_before = (lambdas[k + 1] @ both_T).chunk(2, dim=1)  # (batch, hidden) each
            through = by_now + later
            if k == 0:
                through = through + by_before
            torch.mul(through, bends[k], out=kicks[k])
            later = by_before
            lambdas[k].addmm_(lambdas[k + 1], free_T).addmm_(kicks[k], into_T)
        ahead = adjoint[1:].flatten(0, 1)  # (steps * batch, state)
        from_now, from_before = h[:-1].flatten(0, 1), torch.cat([h[:1], h[:-2]])[:steps].flatten(0, 1)
        kicked = kick[:-1].flatten(0, 1)
        states = z[:-1].flatten(0, 1)
        return (
            adjoint[0],
            states.T @ ahead,
            from_now.T @ ahead,
            from_before.T @ ahead,
            ahead.sum(dim=0),
            states.T @ kicked,
            kicked.sum(dim=0),
            None,
            adjoint[1:] if ctx.is_pushed else None,
        )
