"""Natural modes of many variants of a structure, and coordinates that keep their meaning while these modes mix.

Variants of a Jacobian hardly differ from the first one: their modes follow from its modes to first order, which takes a
few products where each would take an eigenvalue problem. With mass-normalised modes V and Lambda = diag(lambda) of M
and K, and E = V^T dK V - V^T dM V Lambda,

    d lambda_j = E_jj,   dV = V D,   D_ij = E_ij / (lambda_j - lambda_i),   D_jj = - (V^T dM V)_jj / 2

(Fox and Kapoor, AIAA J. 6, 1968, 2426-2429).
"""

from dataclasses import dataclass

import numpy as np

from fe_models.arrays import TINY, FloatArray
from hybrid.diagnosis.response.config import EIGENMODES


@dataclass(frozen=True)
class Eigenmodes:
    """Squared natural frequencies ``omega2`` (variant, mode) and mass-normalised ``shapes`` (variant, vector, mode).

    ``first_order``: whether those of all variants follow from those of the first to first order.
    """

    omega2: FloatArray
    shapes: FloatArray
    first_order: bool = False

    @property
    def omega(self) -> FloatArray:
        """Natural frequencies (variant, mode), rad/s."""
        return natural_frequencies(self.omega2)


def natural_frequencies(omega2: FloatArray) -> FloatArray:
    """Return natural frequencies (variant, mode), rad/s, of their squares; next to nothing where it buckles."""
    least = EIGENMODES.min_eigenvalue_share * np.abs(omega2).max(axis=1, keepdims=True)
    return np.asarray(np.sqrt(np.maximum(omega2, least)))


def eigenmodes(M: FloatArray, K: FloatArray, first_order: bool = False) -> Eigenmodes:
    """Return the modes of M and K (variant, vector, vector).

    ``first_order``: variants are a Jacobian's. Where modes of nearly equal frequency mix in them nevertheless, each
    is solved by itself.
    """
    near = _near_the_first(M, K) if first_order and len(M) > 1 else None
    return _each(M, K) if near is None else near


def aligned_modes(modes: Eigenmodes, kept: int) -> FloatArray:
    """Return T (variant, vector, mode): the ``kept`` lowest ``modes``, turned as close as can be to the first shapes.

    Coordinates then mean the same in all variants, however the modes mix (orthogonal Procrustes problem).
    """
    lowest = modes.shapes[:, :, :kept]
    along = lowest[:, :kept].swapaxes(1, 2)
    return np.asarray(lowest @ (_turns_near_the_first(along) if modes.first_order else _turns(along)))


def _each(M: FloatArray, K: FloatArray) -> Eigenmodes:
    inverse = np.linalg.inv(np.linalg.cholesky(M))
    omega2, vectors = np.linalg.eigh(inverse @ K @ inverse.swapaxes(-1, -2))
    return Eigenmodes(omega2, np.asarray(inverse.swapaxes(-1, -2) @ vectors))


def _near_the_first(M: FloatArray, K: FloatArray) -> Eigenmodes | None:
    """Return the modes of variants that hardly differ; None where they do."""
    first = _each(M[:1], K[:1])
    omega2, V = first.omega2[0], first.shapes[0]
    dM, dK = (V.T @ (part - part[0]) @ V for part in (M, K))
    E = dK - dM * omega2
    every = np.arange(len(omega2))
    apart = omega2 - omega2[:, None]
    apart[every, every] = 1.0
    with np.errstate(divide="ignore", invalid="ignore"):  # of modes whose frequencies are equal
        D = E / apart
    D[:, every, every] = -0.5 * dM[:, every, every]
    if not np.abs(D).max() < EIGENMODES.max_mixing:
        return None
    return Eigenmodes(omega2 + E[:, every, every], V + V @ D, first_order=True)


def _turns(along: FloatArray) -> FloatArray:
    """Return the orthogonal matrix next to each of ``along`` (variant, mode, mode): its polar factor."""
    left, _, right = np.linalg.svd(along)
    return np.asarray(left @ right)


def _turns_near_the_first(along: FloatArray) -> FloatArray:
    """Return the same of variants that hardly differ, to first order.

    With the singular value decomposition L diag(s) R of the first the change d of another moves its polar factor L R by
    L Y R, where Y_ij = (F_ij - F_ji) / (s_i + s_j) and F = L^T d R^T.
    """
    left, sizes, right = np.linalg.svd(along[0])
    F = left.T @ (along - along[0]) @ right.T
    both = np.maximum(sizes[:, None] + sizes, TINY)
    return np.asarray(left @ (np.eye(len(sizes)) + (F - F.swapaxes(1, 2)) / both) @ right)
