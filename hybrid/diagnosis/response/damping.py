"""What the uncertain factors of the damping ratios, and ratios that are assumed or replaced, are of C."""

import numpy as np

from fe_models.arrays import FloatArray
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.response.eigenmodes import Eigenmodes, eigenmodes


def more_damping(
    nominal: NominalModel, modes: Eigenmodes, M: FloatArray, C: FloatArray, factor: FloatArray
) -> FloatArray:
    """Return what the ``factor`` (variant, mode) of each mode's own damping ratio adds to C.

    ``modes``: those of a system whose mass and damping are M and C (variant, vector, vector).
    """
    omega, phi = modes.omega, modes.shapes
    own = np.sum(phi * (C @ phi), axis=1)  # 2 xi omega
    return _of_modes(M, phi, own * (_factors(nominal, factor, omega) - 1))


def assumed_damping(
    nominal: NominalModel,
    M: FloatArray,
    C: FloatArray,
    K: FloatArray,
    factor: FloatArray,
    replaced: list[tuple[int, FloatArray]],
    first_order: bool = False,
) -> FloatArray:
    """Return what is added to C by the damping ratios that are assumed, each times its ``factor``, and by those
    ``replaced``: modes of M and K (from 0), each with its ratio (variant,), whatever C says.

    ``first_order``: see `eigenmodes`.
    """
    if not (nominal.ratios.any() or replaced):
        return np.zeros_like(C)
    modes = eigenmodes(M, K, first_order)
    omega, phi = modes.omega, modes.shapes
    added = 2 * nominal.ratios_of(len(M[0])) * omega * _factors(nominal, factor, omega)
    for mode, ratio in replaced:
        shape = phi[:, :, mode]
        added[:, mode] = 2 * ratio * omega[:, mode] - np.einsum("pd,pde,pe->p", shape, C, shape)
    return _of_modes(M, phi, added)


def _factors(nominal: NominalModel, factor: FloatArray, omega: FloatArray) -> FloatArray:
    """Return the factor (variant, mode) of each mode's damping ratio, 1 of those beyond the ones that are uncertain.

    Above a low-pass, too: what it leaves of a mode says nothing of its damping, and would be taken for it.
    """
    count = omega.shape[1]
    known = np.pad(factor, ((0, 0), (0, max(count - factor.shape[1], 0))), constant_values=1.0)[:, :count]
    return np.where(omega < nominal.cutoff, known, 1.0)


def _of_modes(M: FloatArray, phi: FloatArray, added: FloatArray) -> FloatArray:
    """Return what modal damping 2 xi omega (variant, mode) is of C (variant, vector, vector)."""
    weighted = M @ phi
    return np.asarray((weighted * added[:, None]) @ weighted.transpose(0, 2, 1))
