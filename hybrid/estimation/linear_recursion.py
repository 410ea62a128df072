"""x_k+1 = x_k T + p_k over many samples, in few operations, as one that autograd records costs more than its sums."""

import torch
from torch import Tensor
from torch.nn.functional import pad

BLOCK = 16  # samples: in blocks by doubling, from block to block by a loop; both take about as long


def linear_recursion(start: Tensor, pushes: Tensor, transition: Tensor) -> Tensor:
    """Return x (batch, time + 1, state) from ``start`` (batch, state) under ``pushes`` p (batch, time, state).

    ``transition`` T (state, state). Within a block x_k gains x_k-1 T, then x_k-2 T^2, then x_k-4 T^4 and so on.
    """
    count = pushes.shape[1]
    x = pad(pushes, (0, 0, 0, -count % BLOCK)).unflatten(1, (-1, BLOCK))  # (batch, block, sample, state), from rest
    power, reach = transition, 1
    while reach < BLOCK:
        x = torch.cat([x[:, :, :reach], x[:, :, reach:] + x[:, :, :-reach] @ power], dim=2)
        power, reach = power @ power, 2 * reach
    begun = [start]  # each block's first state
    for last in x[:, :-1, -1].unbind(dim=1):
        begun.append(torch.addmm(last, begun[-1], power))
    powers = [transition]
    while len(powers) < BLOCK:
        powers.append(powers[-1] @ transition)
    carried = (torch.stack(begun, dim=1) @ torch.cat(powers, dim=1)).unflatten(2, (BLOCK, -1))
    return torch.cat([start[:, None], (x + carried).flatten(1, 2)[:, :count]], dim=1)
