"""Do all training recordings come from the same structure? A model identified from one must explain the others."""

from collections.abc import Callable, Sequence

import numpy as np
import torch
from torch import Tensor

from fe_models.arrays import FloatArray
from fe_models.progress import nothing
from hybrid.estimation.linear_calibration import Observer, fit_linear_rest, free_part, smooth
from hybrid.neural_modal_ode.driving import Driving


def unexplained_shares(
    observer: Observer,
    recordings: Sequence[Tensor],
    advance: Callable[[], object] = nothing,
    drivings: Sequence[Driving | None] | None = None,
) -> FloatArray:
    """Return the median unexplained share of each recording's windows under each one's model, (model, recording).

    ``recordings``: windows (window, time, sensor) of each recording; ``drivings``: what drives them.
    """
    known = drivings or [None] * len(recordings)
    shares = np.empty((len(recordings), len(recordings)))
    for i, own in enumerate(recordings):
        fit = fit_linear_rest(observer, own, advance, known[i])
        rest = torch.tensor(fit.rest)
        observability = observer.matrix(rest, own.shape[1])
        for j, windows in enumerate(recordings):
            free = free_part(observer, rest, windows, known[j])
            _, fitted = smooth(observability, free)
            left = (fitted - free).square().mean(dim=(1, 2)) / windows.square().mean(dim=(1, 2))
            shares[i, j] = float(left.median())
    return shares
