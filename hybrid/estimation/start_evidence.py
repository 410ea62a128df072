"""How well a recording explains the first samples of a window, whatever the window's size.

A start x = s u is Gaussian with u ~ N(0, V) and a size s of which nothing is known, p(s) ~ 1/s. Integrated over s:

    log p(x) = -1/2 log|V| - n/2 log(x^T V^-1 x) + a constant      (n numbers in x)

V is the covariance of the recording's own starts, each divided by its size. It holds what the first samples say of a
structure: how its sensors move together, and how fast.
"""

import numpy as np
import torch
from torch import Tensor, nn

from fe_models.arrays import FloatArray
from hybrid.estimation.config import LINEAR_CALIBRATION, STATE


class StartEvidence(nn.Module):
    """The evidence that starts x (time * channel) give for one recording, up to a constant that all recordings share.

    ``root``: the inverse Cholesky factor of V, (n, n), so that |root x|^2 = x^T V^-1 x.
    """

    def __init__(self, root: Tensor) -> None:
        super().__init__()
        self.root: Tensor
        self.register_buffer("root", root.to(torch.get_default_dtype()))

    def forward(self, x: Tensor) -> Tensor:
        """Return log p (batch,) of x (batch, n)."""
        distance = (x @ self.root.T).square().sum(dim=1).clamp(min=STATE.least_square)
        return self.root.diagonal().log().sum() - 0.5 * x.shape[1] * distance.log()


def evidence_of(starts: FloatArray) -> StartEvidence:
    """Return the evidence for the recording that has ``starts`` (start, n), none of them silent."""
    units = starts / np.sqrt(np.mean(starts**2, axis=1, keepdims=True))
    V = units.T @ units / len(units)
    V += LINEAR_CALIBRATION.covariance_shrinkage * np.trace(V) / len(V) * np.eye(len(V))
    return StartEvidence(torch.tensor(np.linalg.inv(np.linalg.cholesky(V))))
