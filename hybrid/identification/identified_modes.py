"""Modes that were identified from a recording, each with its uncertainty, whatever moved the structure."""

from dataclasses import dataclass

import numpy as np

from fe_models.arrays import BoolArray, ComplexArray, FloatArray, IntArray


@dataclass(frozen=True)
class IdentifiedModes:
    """``roots`` (mode,), rad/s, by frequency, and complex ``shapes`` (sensor, mode), their ``reference`` (mode,) entry
    one. ``covariance`` (mode, parameter, parameter) of Re s, Im s, then Re and Im of each entry of the shape.
    ``energy`` (mode,) of each mode's own motion over the recording's; ``left``: share of the recording's energy that
    all of them do not explain. ``orders`` (sensor,): how often each signal is the derivative of a displacement, zeros
    where all show one quantity. ``sizes`` (sensor,): what signals are divided by where channels are added up
    (`channel_sizes`).
    """

    roots: ComplexArray
    shapes: ComplexArray
    reference: IntArray
    covariance: FloatArray
    energy: FloatArray
    left: float
    orders: IntArray
    sizes: FloatArray

    @property
    def phases(self) -> ComplexArray:
        """What a sensor's signal is multiplied by where the displacement is real, (sensor,): 1, i or -1."""
        return np.asarray(1j**self.orders)

    @property
    def frequencies(self) -> FloatArray:
        """Natural frequencies (mode,), Hz: |s| / 2 pi."""
        return np.asarray(np.abs(self.roots) / (2 * np.pi))

    @property
    def ratios(self) -> FloatArray:
        """Damping ratios (mode,): -Re s / |s|."""
        return np.asarray(-self.roots.real / np.abs(self.roots))

    @property
    def frequency_errors(self) -> FloatArray:
        """Standard deviations (mode,) of the natural frequencies, Hz."""
        return self.frequencies * np.sqrt(self.scatter[:, 0, 0])

    @property
    def ratio_errors(self) -> FloatArray:
        """Standard deviations (mode,) of the damping ratios."""
        return np.sqrt(self.scatter[:, 1, 1])

    @property
    def scatter(self) -> FloatArray:
        """The ``covariance`` with the logarithm of the frequency and the damping ratio instead of Re s and Im s."""
        size, s = np.abs(self.roots), self.roots
        turned = np.tile(np.eye(self.covariance.shape[1]), (len(s), 1, 1))
        turned[:, 0, 0], turned[:, 0, 1] = s.real / size**2, s.imag / size**2
        turned[:, 1, 0], turned[:, 1, 1] = -(s.imag**2) / size**3, s.real * s.imag / size**3
        return np.asarray(turned @ self.covariance @ turned.swapaxes(1, 2))

    @property
    def real_shapes(self) -> FloatArray:
        """Real shapes (sensor, mode), their largest entry one: turned to the phase that most sensors share.

        A velocity's entry is real although it is a quarter of a period ahead of the displacement, see ``phases``.
        """
        aligned = self.shapes / self.phases[:, None]
        together = np.sum((aligned / self.sizes[:, None]) ** 2, axis=0)
        turned = np.real(aligned * np.exp(-0.5j * np.angle(together)))
        largest = np.argmax(np.abs(turned), axis=0)
        return np.asarray(turned / np.take_along_axis(turned, largest[None], axis=0))

    @property
    def displacements(self) -> ComplexArray:
        """Complex shapes (sensor, mode) of displacements, of any scale, whatever sensors show."""
        return np.asarray(self.shapes / self.roots ** self.orders[:, None])

    @property
    def collinearity(self) -> FloatArray:
        """The `phase_collinearity` (mode,) of the shapes of displacements, each channel over its size."""
        turned = (self.roots / np.abs(self.roots)) ** self.orders[:, None]
        return phase_collinearity(self.shapes / self.sizes[:, None] / turned)

    def strongest(self, count: int) -> "IdentifiedModes":
        """Return the modes of most energy, at most so many, in the order that they have."""
        return self.take(np.sort(np.argsort(-self.energy)[:count]))

    def take(self, kept: BoolArray | IntArray) -> "IdentifiedModes":
        """Return some of the modes."""
        return IdentifiedModes(
            self.roots[kept],
            self.shapes[:, kept],
            self.reference[kept],
            self.covariance[kept],
            self.energy[kept],
            self.left,
            self.orders,
            self.sizes,
        )


def no_modes(orders: IntArray) -> IdentifiedModes:
    """Return no modes of sensors whose signals are derivatives of such ``orders`` (sensor,)."""
    shapes, whole = np.zeros((len(orders), 0), dtype=complex), 2 + 2 * len(orders)
    none = np.zeros(0, dtype=int)
    alike = np.ones(len(orders))
    return IdentifiedModes(shapes[0], shapes, none, np.zeros((0, whole, whole)), np.zeros(0), 1.0, orders, alike)


def phase_collinearity(shapes: ComplexArray) -> FloatArray:
    """Return the modal phase collinearity (mode,) of shapes (sensor, mode): one where all sensors are in phase.

    (|Re|^2 - |Im|^2)^2 + 4 (Re . Im)^2 over (|Re|^2 + |Im|^2)^2 (Pappa, Elliott and Schenk, J. Guidance 16(5), 1993).
    """
    return np.asarray(np.abs(np.sum(shapes**2, axis=0)) ** 2 / np.sum(np.abs(shapes) ** 2, axis=0) ** 2)
