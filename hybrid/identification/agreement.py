"""Do recordings come from one structure? What was identified from each must explain the others."""

from collections.abc import Sequence

import numpy as np
from scipy.sparse.csgraph import connected_components

from fe_models.arrays import FloatArray
from hybrid.identification.config import AGREEMENT
from hybrid.identification.damped_cosines import amplitudes_of, columns_of
from hybrid.identification.identified_modes import IdentifiedModes


def window_of(models: Sequence[IdentifiedModes], lengths: Sequence[float]) -> float:
    """Return how many s of recordings, which last ``lengths`` s, one of the ``models`` is to explain at once."""
    slowest = min(float(model.frequencies[0]) for model in models)
    return min(max(AGREEMENT.window_s, AGREEMENT.min_periods / slowest), *lengths)


def shares_unexplained(
    models: Sequence[IdentifiedModes], recordings: Sequence[FloatArray], rates: Sequence[float], window: float
) -> FloatArray:
    """Return the share of each recording's energy that the modes of each one leave, (model, recording).

    ``recordings`` (time, sensor), sampled at ``rates`` (Hz), are cut into windows of so many s, in which the modes of
    the model, with its shapes, frequencies and damping, take the amplitudes and phases that fit best. The energy is
    that of all windows together, less what each sensor shows at rest, as the recording's own modes leave it.
    """
    shares = np.empty((len(models), len(recordings)))
    sizes = np.exp(np.mean([np.log(model.sizes) for model in models], axis=0))
    motions = [
        (data - amplitudes_of(data, own.roots, rate)[1]) / sizes
        for data, own, rate in zip(recordings, models, rates, strict=True)
    ]
    samples = [round(window * rate) for rate in rates]
    for i, model in enumerate(models):
        bases = {(rate, count): _basis(model, sizes, rate, count) for rate, count in zip(rates, samples, strict=True)}
        for j, (data, rate, length) in enumerate(zip(motions, rates, samples, strict=True)):
            count = len(data) // length
            windows = data[: count * length].reshape(count, -1)
            explained = np.sum((windows @ bases[rate, length]) ** 2)
            shares[i, j] = 1 - explained / np.sum(windows**2)
    return shares


def _basis(model: IdentifiedModes, sizes: FloatArray, rate: float, samples: int) -> FloatArray:
    """Return an orthonormal basis (time x sensor, amplitude) of what modes do in a window, each channel over its size.

    Of those below half the ``rate`` (Hz).
    """
    shown = model.take(model.frequencies < rate / 2)
    decays = columns_of(shown.roots, samples, rate).reshape(samples, 2, -1)  # (time, part, mode)
    shapes = shown.phases[:, None] * shown.real_shapes / sizes[:, None]
    waves = (decays[:, 0] - 1j * decays[:, 1])[:, None] * shapes
    columns = np.stack([waves.real, waves.imag], axis=2).reshape(samples * len(shapes), -1)
    return np.asarray(np.linalg.qr(columns).Q)


def largest_agreeing_group(shares: FloatArray) -> list[int]:
    """Return the numbers of the largest group of recordings whose models explain each other (the first, if tied).

    ``shares`` (model, recording): of each recording's energy that a model identified from one leaves. What a model
    leaves of its own recording says nothing against others, nor does what a recording's own model leaves of it: where
    motion is not linear, no linear model explains it, and none contradicts it.
    """
    own = np.diag(shares)
    beyond = np.maximum(shares, shares.T) - np.maximum(own[:, None], own)
    agree = beyond < AGREEMENT.max_unexplained_share
    count, group = connected_components(agree, directed=False)
    sizes = np.bincount(group, minlength=count)
    return [int(i) for i in np.flatnonzero(group == np.argmax(sizes))]
