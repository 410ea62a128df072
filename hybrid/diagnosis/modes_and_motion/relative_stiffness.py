"""Stiffnesses that are surely off beside the others of the structure, though what all have in common is not known.

Frequencies and shapes tell ratios of stiffnesses; a factor of all of them is one of all masses, too. Of part i

    c_i = t_i - mean_j t_j,   t: logarithms of factors, j: the stiffnesses that are not off themselves,

is free of that factor.
"""

from dataclasses import dataclass

import numpy as np
from scipy.stats import norm

from fe_models.arrays import TINY, FloatArray
from hybrid.diagnosis.modal.config import CONCLUSION
from hybrid.diagnosis.modal.evidence import ModalFit
from hybrid.diagnosis.modal.modal_data import ModalData


@dataclass(frozen=True)
class RelativeStiffness:
    """A nominal ``part``, by its number, that has ``factor`` times its stiffness beside the others; ``error``: the
    standard deviation of that.
    """

    part: int
    factor: float
    error: float


def relatively_off(measured: ModalData, fit: ModalFit) -> list[RelativeStiffness]:
    """Return the stiffnesses that are so off by more than is normal, surely: the surest first, then what is off beside
    the rest, as long as that is the greater half.
    """
    nominal = measured.nominal
    stiffnesses = [number for number, part in enumerate(nominal.parts) if part.quantity == "stiffness"]
    rest, found = list(stiffnesses), list[int]()
    while len(rest) > max(len(stiffnesses) / 2, 1):
        certainty = [_certainty(measured, fit, part, rest) for part in rest]
        if max(certainty) < norm.ppf(CONCLUSION.min_probability):
            break
        found.append(rest.pop(int(np.argmax(certainty))))
    return [_relative(measured, fit, part, rest) for part in found]


def _certainty(measured: ModalData, fit: ModalFit, part: int, rest: list[int]) -> float:
    """Return by how many of its standard deviations a part is off beyond what is normal, beside the ``rest``."""
    contrast = _contrast(part, rest, fit.nuisances)
    spread = measured.nominal.spread[: fit.nuisances]
    normal = CONCLUSION.normal_sigma * float(np.linalg.norm(contrast * spread))
    off, error = _off(measured, fit, contrast)
    return (abs(off) - normal) / max(error, TINY)


def _relative(measured: ModalData, fit: ModalFit, part: int, rest: list[int]) -> RelativeStiffness:
    off, error = _off(measured, fit, _contrast(part, rest, fit.nuisances))
    return RelativeStiffness(part, float(np.exp(off)), float(np.exp(off)) * error)


def _contrast(part: int, rest: list[int], nuisances: int) -> FloatArray:
    """Return the weights (nuisance,) of c_i: one of the part, and less the mean of the ``rest`` but for it."""
    others = [other for other in rest if other != part]
    contrast = np.zeros(nuisances)
    contrast[part], contrast[others] = 1.0, -1 / len(others)
    return contrast


def _off(measured: ModalData, fit: ModalFit, contrast: FloatArray) -> tuple[float, float]:
    """Return c_i and its standard deviation."""
    first = fit.nuisances
    off = float(contrast @ (fit.theta[:first] + measured.offset))
    return off, float(np.sqrt(contrast @ fit.covariance[:first, :first] @ contrast))
