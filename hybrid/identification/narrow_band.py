"""One mode's motion, cut out of a recording: its complex amplitude over time.

y(t) = Re z(t) exp(i w t),   |f - w / 2 pi| < half of the band
"""

import numpy as np

from fe_models.arrays import ComplexArray, FloatArray


def amplitude_of(signal: FloatArray, rate: float, frequency: float, width: float) -> ComplexArray:
    """Return z (time, sensor) of a ``signal`` (time, sensor) in a band ``width`` Hz wide about a ``frequency`` (Hz).

    As many samples as tell all of it: two and more for each period of the band's width. The band's edges are Hann's,
    so that what stands still does not ring.
    """
    samples = len(signal)
    spectrum = np.fft.fft(signal, axis=0)
    middle = round(frequency * samples / rate)
    half = max(2, round(width * samples / rate))
    lines = np.arange(-half, half + 1)
    kept = spectrum[(middle + lines) % samples] * np.hanning(2 * half + 3)[1:-1, None]
    kept[(middle + lines <= 0) | (2 * (middle + lines) >= samples)] = 0
    return np.asarray(2 * np.fft.ifft(np.roll(kept, -half, axis=0), axis=0) * (2 * half + 1) / samples)
