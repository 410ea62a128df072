"""Damping of a structure as a whole: Rayleigh's two factors, and modal ratios as a matrix where one is needed."""

from math import pi

import numpy as np
from scipy.linalg import eigh

from fe_models.arrays import FloatArray
from fe_models.errors import InputError
from fe_models.linear import LinearModel
from fe_models.structure import Damping

LARGEST_DENSE = 3000
"""Free degrees of freedom up to which a full matrix is formed (72 MB each)."""


def rayleigh_damping(ratio: float, first: float, second: float) -> Damping:
    """Return Rayleigh damping with the damping ratio ``ratio`` at both frequencies ``first`` and ``second`` (Hz).

    xi(omega) = a0 / (2 omega) + a1 omega / 2, so that a0 = 2 ratio w1 w2 / (w1 + w2) and a1 = 2 ratio / (w1 + w2).
    """
    w1, w2 = 2 * pi * first, 2 * pi * second
    return Damping(mass_factor=2 * ratio * w1 * w2 / (w1 + w2), stiffness_factor=2 * ratio / (w1 + w2))


def ratios_of_modes(ratios: tuple[float, ...], count: int) -> FloatArray:
    """Return one modal damping ratio for each of ``count`` modes: beyond the list, its last number goes on."""
    if not ratios:
        return np.zeros(count)
    return np.array([ratios[min(mode, len(ratios) - 1)] for mode in range(count)])


def replace_ratios(ratios: FloatArray, replaced: tuple[tuple[int, float], ...]) -> FloatArray:
    """Return damping ratios (mode,) with those of ``replaced`` modes (numbered from 1) in their places."""
    result = ratios.copy()
    for mode, ratio in replaced:
        if mode <= len(result):
            result[mode - 1] = ratio
    return result


def full_damping(model: LinearModel) -> FloatArray:
    """Return C (free, free), the modal part included, as a full matrix.

    C = C_model + M Phi diag(2 xi omega) Phi^T M, Phi all the mass-normalised modes, xi the modal ratios; of a mode
    whose ratio is replaced, xi is what brings it there. The second term couples every degree of freedom with every
    other, which is why `LinearModel` keeps the ratios and not their matrix.
    """
    size = model.mass.shape[0]
    if size > LARGEST_DENSE:
        raise InputError(
            f"the full damping matrix of {size} degrees of freedom would take {8e-9 * size**2:.0f} GB: "
            f"use Rayleigh damping, or at most {LARGEST_DENSE} degrees of freedom"
        )
    damping: FloatArray = model.damping.toarray()
    if model.has_modal_damping:
        mass = model.mass.toarray()
        # M Phi = mu K Phi, mu = 1 / omega^2, also works where M is singular: mu = 0 there, and that mode is left out.
        compliance, shapes = eigh(mass, model.stiffness.toarray())
        real = compliance > 1e-14 * compliance[-1]
        omega = 1 / np.sqrt(compliance[real][::-1])
        shapes = shapes[:, real][:, ::-1] * omega  # eigh scales to Phi^T K Phi = I
        own = np.einsum("di,di->i", shapes, damping @ shapes) / (2 * omega)
        added = replace_ratios(own + ratios_of_modes(model.modal_ratios, len(omega)), model.replaced_ratios) - own
        mass_shapes = mass @ shapes
        damping += (mass_shapes * (2 * added * omega)) @ mass_shapes.T
    return damping
