"""The modes of what unknown, broad-band forces keep moving: frequency, damping ratio and shape, with uncertainty.

Correlations take the place of free decays (`output_correlations`). Where the slowest mode asks for more block rows than
there can be, slow modes are looked for in a band of their own, sampled more slowly (`ambient_band`). Lines of machines
are told from modes (`harmonics`). Forces give shapes no scale: nothing here knows a mass.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fe_models.arrays import FloatArray, IntArray
from fe_models.modes import mac
from hybrid.identification.ambient_band import lack_of_rows, modes_of_band, thinned_to
from hybrid.identification.config import AMBIENT, FREE_DECAY
from hybrid.identification.harmonics import Harmonic, harmonics_among
from hybrid.identification.identified_modes import IdentifiedModes
from hybrid.identification.stabilisation import Stabilisation


@dataclass(frozen=True)
class AmbientModes:
    """The ``modes``, by frequency, the poles that they come from (``stabilisation``), and lines of machines beside."""

    modes: IdentifiedModes
    stabilisation: Stabilisation
    harmonics: tuple[Harmonic, ...] = ()


def identify_ambient_modes(
    motions: Sequence[FloatArray],
    rate: float,
    first: float,
    highest: float,
    orders: IntArray | None = None,
    sizes: FloatArray | None = None,
) -> AmbientModes:
    """Return the modes of ``motions`` (time, sensor), sampled at ``rate`` Hz, up to ``highest`` Hz.

    ``first``: the structure's lowest natural frequency, Hz, which says what is a drift, and how long correlations last.
    ``orders`` (sensor,): of the derivatives of displacements that sensors show; left out, all show one quantity.
    ``sizes`` (sensor,): what channels are divided by where they are added up; left out, see `channel_sizes`.
    """
    orders = np.zeros(motions[0].shape[1], dtype=int) if orders is None else orders
    thinned, rate = thinned_to(motions, rate, highest)
    modes, stabilisation = modes_of_band(thinned, rate, first, highest, orders, sizes)
    top, sizes = highest, modes.sizes if len(modes.roots) else sizes
    while lack_of_rows(thinned, rate, first, top) > AMBIENT.max_lack_of_rows:
        top /= AMBIENT.band_ratio
        slow, poles = modes_of_band(thinned, rate, first, (1 + AMBIENT.band_overlap) * top, orders, sizes)
        modes = _joined(_of_all(slow, thinned, rate, top), modes, top)
        stabilisation = _both(poles, stabilisation, top)
    lines, harmonics = harmonics_among(modes, thinned, rate)
    found = modes.take(~lines & (modes.ratios > 0))
    return AmbientModes(found.take(np.argsort(found.frequencies)), stabilisation, harmonics)


def _of_all(slow: IdentifiedModes, motions: Sequence[FloatArray], rate: float, top: float) -> IdentifiedModes:
    """Return the modes of a lower band with their shares of the energy of all frequencies."""
    own, _ = thinned_to(motions, rate, (1 + AMBIENT.band_overlap) * top)
    part, whole = (
        sum(float(np.sum(np.var(each / slow.sizes, axis=0))) * len(each) for each in data) for data in (own, motions)
    )
    counts = [sum(map(len, data)) for data in (own, motions)]
    share = min(part / counts[0] / max(whole / counts[1], np.finfo(float).tiny), 1.0)
    return replace(slow, energy=slow.energy * share)


def _joined(slow: IdentifiedModes, fast: IdentifiedModes, top: float) -> IdentifiedModes:
    """Return the modes of two bands that meet at ``top`` Hz; what both have is the lower band's."""
    slow = slow.take(slow.frequencies <= (1 + AMBIENT.band_overlap) * top)
    fast = fast.take(fast.frequencies >= (1 - AMBIENT.band_overlap) * top)
    sizes = (slow if len(slow.roots) else fast).sizes
    alike = mac(slow.shapes / sizes[:, None], fast.shapes / sizes[:, None]) >= FREE_DECAY.min_mac_of_one_mode
    near = np.abs(slow.frequencies[:, None] / fast.frequencies - 1) < FREE_DECAY.max_relative_separation
    fast = fast.take(~np.any(alike & near, axis=0))
    energy = np.concatenate([slow.energy, fast.energy])
    return IdentifiedModes(
        np.concatenate([slow.roots, fast.roots]),
        np.concatenate([slow.shapes, fast.shapes], axis=1),
        np.concatenate([slow.reference, fast.reference]),
        np.concatenate([slow.covariance, fast.covariance]),
        energy,
        float(max(1 - energy.sum(), 0.0)),
        slow.orders,
        sizes,
    )


def _both(slow: Stabilisation, fast: Stabilisation, top: float) -> Stabilisation:
    """Return the poles of two bands that meet at ``top`` Hz."""
    low, high = (np.abs(poles.roots) / (2 * np.pi) <= top for poles in (slow, fast))
    parts = [(slow, low), (fast, ~high)]
    later = np.where(fast.mode >= 0, fast.mode + slow.mode.max(initial=-1) + 1, -1)
    return Stabilisation(
        np.concatenate([poles.order[kept] for poles, kept in parts]),
        np.concatenate([poles.roots[kept] for poles, kept in parts]),
        np.concatenate([poles.shapes[kept] for poles, kept in parts]),
        np.concatenate([slow.mode[low], later[~high]]),
    )
