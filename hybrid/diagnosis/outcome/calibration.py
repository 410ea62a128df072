"""What the recordings say of the nominal values that their owner holds uncertain."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from fe_models.dofs import FloatArray
from hybrid.diagnosis.fitting.fitting import Fit
from hybrid.diagnosis.fitting.forecasting import DEVIATION
from hybrid.diagnosis.nominal.plant import Plant
from hybrid.diagnosis.outcome.findings import place_words


@dataclass(frozen=True)
class Calibrated:
    """A ``quantity`` ("stiffness", "mass", "damping") at a ``location`` is ``factor`` times its nominal value.

    ``std``: standard deviation of the factor. Of an element by itself it comes on top of its group's.
    """

    quantity: str
    location: dict[str, Any]
    factor: float
    std: float


def calibration_of(plant: Plant, theta: FloatArray, covariance: FloatArray) -> tuple[Calibrated, ...]:
    """Return each uncertain value at ``theta`` (parameter,) with its ``covariance`` (parameter, parameter).

    No standard deviation is larger than the one stated: recordings cannot tell less than nothing. Of modes beyond a
    low-pass nothing is told.
    """
    names = [*_factors(plant), *(("stiffness", {"element": number}) for number in plant.scatter.elements)]
    own, rest = slice(0, plant.factors), slice(plant.factors, plant.values)
    weights = plant.scatter.weights
    factors = np.append(np.exp(theta[own]), 1 + theta[rest] @ weights)
    deviation = np.minimum(np.sqrt(np.diag(covariance)[own]), plant.spread[own]) * factors[: plant.factors]
    scattered = np.sqrt(np.einsum("pe,pq,qe->e", weights, covariance[rest, rest], weights))
    scattered = np.minimum(scattered, np.linalg.norm(plant.spread[rest, None] * weights, axis=0))
    return tuple(
        Calibrated(quantity, location, float(factor), float(std))
        for (quantity, location), factor, std in zip(names, factors, np.append(deviation, scattered), strict=True)
        if quantity != "damping" or location["modes"][0] <= plant.below
    )


def far_off(item: Fit) -> list[str]:
    """Return a note on each nominal value that a fit has further off than usual, in stated standard deviations."""
    return [
        f"{quantity} of {place_words(location)} is {abs(deviation):.1f} of its stated standard deviations"
        f" {'below' if deviation < 0 else 'above'} its nominal value: rare, but likelier than any cause"
        for (quantity, location), deviation in zip(_factors(item.hypothesis.plant), item.deviations, strict=False)
        if abs(deviation) > DEVIATION
    ]


def astray(item: Fit, normal: float) -> list[str]:
    """Return a note on the nominal value that a fit with causes has furthest off, if more than is ``normal``, in stated
    standard deviations: something else is wrong there, or all that is.
    """
    plant = item.hypothesis.plant
    rest, weights = slice(plant.factors, plant.values), plant.scatter.weights
    by_itself = item.theta[rest] @ weights / np.linalg.norm(plant.spread[rest, None] * weights, axis=0)  # (element,)
    deviations = np.append(item.deviations[: plant.factors], by_itself)
    places = [*_factors(plant), *(("stiffness", {"element": number}) for number in plant.scatter.elements)]
    worst = int(np.argmax(np.abs(deviations)))
    if abs(deviations[worst]) <= normal:
        return []
    quantity, location = places[worst]
    side = "below" if deviations[worst] < 0 else "above"
    return [
        f"beside what is named, {quantity} of {place_words(location)} had to go {abs(deviations[worst]):.1f} of its "
        f"stated standard deviations {side} its nominal value: something else is wrong, or it all is there"
    ]


def _factors(plant: Plant) -> list[tuple[str, dict[str, Any]]]:
    """Return quantity and location of each uncertain factor."""
    parts = [(part.quantity, part.location) for part in plant.parts]
    return [*parts, *(("damping", {"modes": [mode + 1]}) for mode in range(len(plant.ratios)))]
