"""The anti-aliasing filter that recordings have passed, as it acts on motions that are known: without phase shift."""

from dataclasses import dataclass
from math import ceil

import numpy as np

from fe_models.dofs import ComplexArray, FloatArray
from fe_models.measurement import FILTER_ORDER

USUAL = 2 * FILTER_ORDER  # steepness of the filter of `measurement.lowpassed`, which runs forwards and backwards
SETTLED = 30.0  # steepness times periods of the cutoff until the impulse response is 1e-4 of its area
FINE = 4096  # frequencies at which a kernel is told


@dataclass(frozen=True)
class LowPass:
    """Leaves 1 / (1 + (f / ``cutoff``)^``steepness``) of a motion at f (Hz); steepness a multiple of 8."""

    cutoff: float
    steepness: int = USUAL

    def gain(self, roots: ComplexArray) -> ComplexArray:
        """Return what is left of motions exp(root t); ``roots`` in 1/s, any shape.

        A motion that decays far slower than the filter's own response is passed as one that does not decay.
        """
        return np.asarray(1 / (1 + (roots / (2 * np.pi * self.cutoff)) ** self.steepness))

    def kernel(self, sampling_rate: float) -> FloatArray:
        """Return the impulse response (2 half + 1,) at samples, for a convolution.

        Of the filter as it acts before sampling: one run at this rate would bend its upper end.
        """
        roots = np.asarray(2j * np.pi * np.fft.fftfreq(FINE, 1 / sampling_rate), dtype=np.complex128)
        response = np.fft.ifft(self.gain(roots)).real
        half = self.settled(sampling_rate)
        return np.concatenate([response[-half:], response[: half + 1]])

    def settled(self, sampling_rate: float) -> int:
        """Return the number of samples before and after one that the filter reaches to."""
        return min(ceil(SETTLED * self.steepness / USUAL**2 * sampling_rate / self.cutoff), FINE // 2 - 1)

    def reach(self, left: float) -> float:
        """Return the frequency (Hz) at which a share ``left`` of a motion is left."""
        return self.cutoff * float((1 / left - 1) ** (1 / self.steepness))
