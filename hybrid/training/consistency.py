"""Do all training recordings come from the same structure? A model identified from one must explain the others."""

from collections.abc import Callable, Sequence

import numpy as np
import torch
from torch import Tensor

from fe_models.arrays import FloatArray
from fe_models.progress import nothing
from hybrid.estimation.linear_calibration import Observer, fit_linear_rest, smooth


def unexplained_shares(
    observer: Observer, recordings: Sequence[Tensor], advance: Callable[[], object] = nothing
) -> FloatArray:
    """Return the median unexplained share of each recording's windows under each one's model, (model, recording).

    ``recordings``: windows (window, time, sensor) of each recording.
    """
    shares = np.empty((len(recordings), len(recordings)))
    for i, own in enumerate(recordings):
        fit = fit_linear_rest(observer, own, advance)
        observability = observer.matrix(torch.tensor(fit.rest), own.shape[1])
        for j, windows in enumerate(recordings):
            _, fitted = smooth(observability, windows)
            left = (fitted - windows).square().mean(dim=(1, 2)) / windows.square().mean(dim=(1, 2))
            shares[i, j] = float(left.median())
    return shares
