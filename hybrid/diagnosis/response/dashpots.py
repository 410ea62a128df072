"""What dashpots do in the modes of a frame that are not followed: they trail those that are.

A dashpot pulls all modes. Those that are followed decay hardly otherwise whether others give way or not, but wherever
these bend, sensors show a motion that is early or late. Each of the system's decaying oscillations takes the others
along at its own root (dynamic condensation: Leung, Int. J. Numer. Meth. Engng 12, 1978, 1705-1715).
"""

from dataclasses import dataclass

import numpy as np

from fe_models.arrays import BoolArray, FloatArray
from hybrid.diagnosis.response.config import TRAILING
from hybrid.diagnosis.response.eigenmodes import Eigenmodes, natural_frequencies
from hybrid.diagnosis.response.system import is_defective


@dataclass(frozen=True)
class Trailing:
    """The modes that are not followed: ``square`` (variant, mode) of natural frequencies, ``shapes`` (variant, dof,
    mode), mass-normalised; their damping among themselves, ``own`` (variant, mode, mode), and with those that are
    followed, ``coupling`` (variant, mode, followed).
    """

    square: FloatArray
    shapes: FloatArray
    own: FloatArray
    coupling: FloatArray

    def along(self, A: FloatArray) -> FloatArray | None:
        """Return X (variant, mode, state): the coordinates X z of these modes in the motions z' = A z of those that are
        followed, the first entries of z. None where eigenvectors fall together.
        """
        roots, vectors = np.linalg.eig(A)
        if is_defective(vectors):
            return None
        fast = np.abs(roots) / (TRAILING.cutoff_ratio * natural_frequencies(self.square)[:, :1])
        taking = -roots / (1 + fast**TRAILING.cutoff_order)
        pulled = self.coupling @ vectors[:, : self.coupling.shape[2]] * taking[:, None]
        stiff = roots[:, :, None, None] * self.own[:, None]  # (variant, root, mode, mode)
        every = np.arange(self.square.shape[1])
        stiff[:, :, every, every] += self.square[:, None] + roots[:, :, None] ** 2
        taken = np.linalg.solve(stiff, pulled.transpose(0, 2, 1)[..., None])[..., 0]  # (variant, root, mode)
        return np.real(taken.transpose(0, 2, 1) @ np.linalg.inv(vectors))

    def shown(self, X: FloatArray, A: FloatArray, rows: FloatArray, kinds: BoolArray) -> FloatArray:
        """Return what sensors show of X z, where z' = A z, (variant, sensor, state).

        ``rows`` (sensor, dof): what each picks; ``kinds`` (3, sensor): displacement, velocity or acceleration.
        """
        seen, shown = rows @ self.shapes, np.zeros((len(A), len(rows), A.shape[2]))
        for kind in kinds:
            shown[:, kind] = seen[:, kind] @ X
            X = X @ A
        return shown


def trailing_of(modes: Eigenmodes, followed: FloatArray, damping: FloatArray, shapes: FloatArray) -> Trailing:
    """Return what trails the ``followed`` modes (variant, vector, mode), the first of the ``modes``.

    ``damping`` (variant, vector, vector) in the basis of ``shapes`` (dof, vector).
    """
    size = followed.shape[2]
    others = modes.shapes[:, :, size:]
    felt = others.transpose(0, 2, 1) @ damping
    return Trailing(modes.omega2[:, size:], shapes @ others, felt @ others, felt @ followed)


def with_trailing(A: FloatArray, trailing: Trailing) -> tuple[FloatArray, FloatArray]:
    """Return A (variant, state, state) of mass-normalised modes with what trails them pulling back, and X of
    `Trailing.along`.
    """
    n, alone = trailing.coupling.shape[2], A
    X = np.zeros((len(A), trailing.square.shape[1], A.shape[1]))
    for _ in range(TRAILING.rounds):
        found = trailing.along(A)
        if found is None:
            return alone, np.zeros_like(X)
        rates, X, A = found @ A, found, alone.copy()
        A[:, n : 2 * n] -= trailing.coupling.transpose(0, 2, 1) @ rates
    return A, X
