"""A structure that is far from its drawing: whole groups off by much more than the dataset states.

Stiffness of each spring, of deck and towers and of each pair of mirrored cables; mass of deck, towers and of each point
mass of a chain; damping ratio of every mode. Factors are normal about 1, cut off where no real structure would be.
"""

from dataclasses import dataclass, replace
from math import inf
from typing import Any, Literal

import numpy as np
from scipy.stats import truncnorm

from fe_models.arrays import FloatArray
from fe_models.dofs import structure_dofs
from fe_models.structure import Cable, Structure
from fe_models.uncertain_parts import uncertain_parts


@dataclass(frozen=True)
class Spread:
    """Factors with the standard deviation ``std`` about 1, of which none is below ``least`` or above ``most``."""

    std: float
    least: float
    most: float

    def draw(self, count: int, rng: np.random.Generator) -> FloatArray:
        """Return ``count`` factors from the truncated normal distribution."""
        least, most = ((end - 1) / self.std for end in (self.least, self.most))
        return np.asarray(truncnorm.rvs(least, most, loc=1.0, scale=self.std, size=count, random_state=rng))


SPREADS = {
    "stiffness": Spread(0.2, 0.4, 1.8),  # three deviations to softer, four to stiffer: nothing is lost or doubled
    "mass": Spread(0.1, 0.6, 1.5),
    "damping": Spread(0.4, 0.3, inf),  # a negative ratio, 2.5 deviations down, would let motions grow without end
}


@dataclass(frozen=True)
class TrueFactor:
    """``what`` of the truth is ``factor`` times the drawn one at a ``location``, in the words of a report."""

    what: Literal["stiffness", "mass", "damping"]
    location: dict[str, Any]
    factor: float


@dataclass(frozen=True)
class FarTruth:
    """A ``structure`` far from its drawing, ``ratios`` (mode,) of its damping to the drawn one, and all ``factors``."""

    structure: Structure
    ratios: FloatArray
    factors: tuple[TrueFactor, ...]


def far_from(design: Structure, rng: np.random.Generator) -> FarTruth:
    """Return a structure far from ``design``."""
    built, factors = _cables_in_pairs(design), list[TrueFactor]()
    for part in uncertain_parts(built):
        factor = float(SPREADS[part.quantity].draw(1, rng)[0])
        built = part.scaled(built, factor)
        factors.append(TrueFactor(part.quantity, part.location, factor))
    ratios = SPREADS["damping"].draw(len(structure_dofs(design).free_rows), rng)
    damping = (
        TrueFactor("damping", {"modes": [mode]}, float(ratio)) for mode, ratio in enumerate(ratios.tolist(), start=1)
    )
    return FarTruth(built, ratios, (*factors, *damping))


def _cables_in_pairs(design: Structure) -> Structure:
    """Return the design with each cable and its mirror image, the first with the last and so on, as one group."""
    elements = list(design.elements)
    cables = [(number, element) for number, element in enumerate(elements, start=1) if isinstance(element, Cable)]
    for (number, cable), (mirrored, _) in zip(cables, reversed(cables), strict=True):
        pair = sorted((number, mirrored))
        elements[number - 1] = replace(cable, group=f"cables {pair[0]} and {pair[1]}")
    return replace(design, elements=tuple(elements))
