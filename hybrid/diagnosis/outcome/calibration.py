"""What the recordings say of the nominal values that their owner holds uncertain."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes.wording import place_words
from hybrid.diagnosis.fitting.config import CALIBRATION
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.outcome.config import MENTION
from hybrid.diagnosis.response.dispersion import shift, step_of


@dataclass(frozen=True)
class Calibrated:
    """A ``quantity`` ("stiffness", "mass", "damping") at a ``location`` is ``factor`` times its nominal value.

    ``std``: standard deviation of the factor. Of an element by itself it comes on top of its group's.
    """

    quantity: str
    location: dict[str, Any]
    factor: float
    std: float


def calibration_of(nominal: NominalModel, theta: FloatArray, covariance: FloatArray) -> tuple[Calibrated, ...]:
    """Return each uncertain value at ``theta`` (parameter,) with its ``covariance`` (parameter, parameter).

    No standard deviation is larger than the one stated: recordings cannot tell less than nothing. Of modes beyond a
    low-pass nothing is told.
    """
    own, rest = slice(0, nominal.factors), slice(nominal.factors, nominal.values)
    weights, factors = nominal.scatter.weights, _factors(nominal, theta)
    deviation = np.minimum(np.sqrt(np.diag(covariance)[own]), nominal.spread[own]) * factors[: nominal.factors]
    scattered = np.sqrt(np.einsum("pe,pq,qe->e", weights, covariance[rest, rest], weights))
    scattered = np.minimum(scattered, np.linalg.norm(nominal.spread[rest, None] * weights, axis=0))
    return tuple(
        Calibrated(quantity, location, float(factor), float(std))
        for (quantity, location), factor, std in zip(
            _places(nominal), factors, np.append(deviation, scattered), strict=True
        )
        if quantity != "damping" or location["modes"][0] <= nominal.below
    )


def far_off(item: Fit) -> list[str]:
    """Return a note on each nominal value that a fit has further off than usual, in stated standard deviations."""
    nominal = item.hypothesis.nominal
    return [
        f"{quantity} of {place_words(location)} is {abs(deviation):.1f} of its stated standard deviations"
        f" {'below' if deviation < 0 else 'above'} its nominal value: rare, but likelier than any cause"
        for (quantity, location), deviation in zip(_places(nominal), item.deviations[: nominal.factors], strict=False)
        if abs(deviation) > CALIBRATION.max_deviation_sigma
    ]


def dispersion_of(item: Fit, temper: float) -> list[str]:
    """Return a note where recordings tell a fit's dispersion, with their values over ``temper``."""
    nominal = item.hypothesis.nominal
    if not nominal.disperses:
        return []
    amount, variance = item.theta[nominal.dispersion], item.covariance[nominal.dispersion, nominal.dispersion]
    if abs(amount) < MENTION.min_dispersion_sigma * np.sqrt(temper * variance):
        return []
    highest = float(nominal.modes[0][max(nominal.below - 1, 0)])  # rad/s
    share, side = abs(shift(amount, highest, nominal.rate)), "lower" if amount > 0 else "higher"
    why = f"recordings simulated in steps of {step_of(amount, nominal.rate):.2g} s, or a" if amount > 0 else "a"
    return [
        f"natural frequencies are {side} than the model's in proportion to their square, by {share:.2%} at"
        f" {highest / (2 * np.pi):.3g} Hz ({why} coarse mesh, do so): taken into account, but not built into the"
        " extended model"
    ]


def astray(item: Fit, normal: float) -> list[str]:
    """Return a note on the nominal value that a fit with causes has furthest off, if that is more than is ``normal``,
    in stated standard deviations: something else is wrong there, or all that is.

    Of elements that are off by themselves, of which nothing was stated, that which is off most.
    """
    nominal, deviations = item.hypothesis.nominal, item.deviations
    worst = int(np.argmax(np.abs(deviations)))
    if abs(deviations[worst]) <= normal:
        return []
    places, factors = _places(nominal), _factors(nominal, item.theta)
    if worst >= nominal.factors:
        worst = nominal.factors + int(np.argmax(np.abs(factors[nominal.factors :] - 1)))
        size, from_there = f"{abs(factors[worst] - 1):.1%}", "that of its group"
    else:
        size, from_there = f"{abs(deviations[worst]):.1f} of its stated standard deviations", "its nominal value"
    quantity, location = places[worst]
    side = "below" if factors[worst] < 1 else "above"
    return [
        f"beside what is named, {quantity} of {place_words(location)} had to go {size} {side} {from_there}: "
        "something else is wrong, or it all is there"
    ]


def _places(nominal: NominalModel) -> list[tuple[str, dict[str, Any]]]:
    """Return quantity and location of each uncertain factor, then of each element by itself."""
    parts = [(part.quantity, part.location) for part in nominal.parts]
    damping = [("damping", {"modes": [mode + 1]}) for mode in range(len(nominal.ratios))]
    return [*parts, *damping, *(("stiffness", {"element": number}) for number in nominal.scatter.elements)]


def _factors(nominal: NominalModel, theta: FloatArray) -> FloatArray:
    """Return the factor of each of them at ``theta`` (parameter,)."""
    by_itself = theta[nominal.factors : nominal.values] @ nominal.scatter.weights
    return np.append(np.exp(theta[: nominal.factors]), 1 + by_itself)
