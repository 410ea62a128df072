"""The anti-aliasing filter that recordings have passed, as it acts on motions that are known: without phase shift."""

from dataclasses import dataclass
from functools import lru_cache
from math import ceil

import numpy as np

from fe_models.arrays import ComplexArray, FloatArray
from fe_models.measurement import FILTER_ORDER

# steepness of the filter of `measurement.lowpassed`, which runs forwards and backwards
USUAL_STEEPNESS = 2 * FILTER_ORDER
SETTLING_PERIODS = 30.0  # steepness times periods of the cutoff until the impulse response is 1e-4 of its area
KERNEL_FREQUENCIES = 4096  # frequencies at which a kernel is computed


@dataclass(frozen=True)
class LowPass:
    """Leaves 1 / (1 + (f / ``cutoff``)^``steepness``) of a motion at f (Hz); steepness a multiple of 8."""

    cutoff: float
    steepness: int = USUAL_STEEPNESS

    def gain(self, roots: ComplexArray) -> ComplexArray:
        """Return what is left of motions exp(root t); ``roots`` in 1/s, any shape.

        A motion that decays far slower than the filter's own response is passed as one that does not decay.
        """
        return np.asarray(1 / (1 + (roots / (2 * np.pi * self.cutoff)) ** self.steepness))

    def log_slope(self, roots: ComplexArray) -> ComplexArray:
        """Return how the logarithm of `gain` changes with each root (s)."""
        some = np.where(roots == 0, 1.0, roots)  # at 0 nothing changes
        return np.asarray(-self.steepness * (1 - self.gain(roots)) / some)

    def kernel(self, sampling_rate: float) -> FloatArray:
        """Return the impulse response (2 half + 1,) at samples, for a convolution.

        Of the filter as it acts before sampling: one run at this rate would bend its upper end.
        """
        return _kernel(self, sampling_rate)

    def settled(self, sampling_rate: float) -> int:
        """Return the number of samples before and after one that the filter reaches to."""
        samples = ceil(SETTLING_PERIODS * self.steepness / USUAL_STEEPNESS**2 * sampling_rate / self.cutoff)
        return min(samples, KERNEL_FREQUENCIES // 2 - 1)

    def reach(self, left: float) -> float:
        """Return the frequency (Hz) at which a share ``left`` of a motion is left."""
        return self.cutoff * float((1 / left - 1) ** (1 / self.steepness))


@lru_cache(maxsize=8)
def _kernel(lowpass: LowPass, sampling_rate: float) -> FloatArray:
    roots = np.asarray(2j * np.pi * np.fft.fftfreq(KERNEL_FREQUENCIES, 1 / sampling_rate), dtype=np.complex128)
    response = np.fft.ifft(lowpass.gain(roots)).real
    half = lowpass.settled(sampling_rate)
    kernel = np.concatenate([response[-half:], response[: half + 1]])
    kernel.flags.writeable = False  # it is shared
    return kernel
