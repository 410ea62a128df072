"""Which identified mode is which of the model's: by shape, frequency and energy together, each at most once.

A pair costs

    (1 - MAC) / mac_scale + |log(f / f_model)| / frequency_scale + |log10(energy)|

and all pairs together cost the least (linear assignment). A shape counts only as far as the sensors can tell shapes
apart: the MAC of a shape drawn at random at n sensors is beta distributed, with parameters 1/2 and (n - 1) / 2.
"""

from collections.abc import Collection

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.stats import beta

from fe_models.arrays import BoolArray, FloatArray
from hybrid.identification.config import COMPARISON, PAIRING
from hybrid.identification.identified_modes import IdentifiedModes


def displacements_of(modes: IdentifiedModes) -> FloatArray:
    """Return the real shapes (sensor, mode) of displacements, their largest entry one.

    Sensors of one quantity keep their shapes; sensors of several become comparable.
    """
    moved = modes.real_shapes / (2 * np.pi * modes.frequencies) ** modes.orders[:, None]
    largest = np.argmax(np.abs(moved), axis=0)
    return np.asarray(moved / np.take_along_axis(moved, largest[None], axis=0))


def paired(
    nominal: FloatArray,
    frequencies: FloatArray,
    energy: FloatArray,
    criterion: FloatArray,
    sensors: int,
    lasts: float,
    sums: Collection[int] = (),
) -> tuple[int, ...]:
    """Return the number of each nominal mode's identified one, -1 where none is (mode,).

    ``nominal`` (mode,) and ``frequencies`` (identified,), Hz; ``energy`` (identified,), shares of the recording's;
    ``criterion`` (mode, identified), MAC at so many ``sensors``. A mode of which a recording that ``lasts`` so many s
    holds too few periods is left out on either side, and one of the ``sums`` (numbers of identified ones, at sums or
    multiples of others' frequencies) is none whose frequency moved far.
    """
    found = np.full(len(nominal), -1)
    if not len(frequencies):
        return tuple(found.tolist())
    apart = np.abs(np.log(frequencies / nominal[:, None]))
    strength = np.log10(np.clip(energy, PAIRING.least_energy, 1.0))
    cost = (1 - criterion) / PAIRING.mac_scale + apart / PAIRING.frequency_scale - strength
    held = np.minimum.outer(nominal, frequencies) * lasts >= COMPARISON.min_periods
    near = apart <= -np.log1p(-COMPARISON.max_frequency_difference)
    alone = is_telling(criterion, sensors)
    alone[:, list(sums)] = False
    possible = held & (criterion >= COMPARISON.min_mac) & (near | alone)
    cost = np.where(possible & (cost < PAIRING.max_cost), cost, PAIRING.max_cost)
    modes, lines = linear_sum_assignment(cost)
    made = cost[modes, lines] < PAIRING.max_cost
    found[modes[made]] = lines[made]
    return tuple(found.tolist())


def is_telling(criterion: FloatArray, sensors: int) -> BoolArray:
    """Return where shapes agree so well, by their MAC at so many ``sensors``, that one drawn at random hardly would."""
    chance = beta.sf(criterion, 0.5, (sensors - 1) / 2) if sensors > 1 else np.ones_like(criterion)
    return np.asarray(chance <= PAIRING.max_chance)
