"""How the frequency of one mode changes while it decays: its backbone curve, from a recording alone.

A mode's own motion is what its shape picks of the channels; a Gaussian band about its frequency leaves its complex
envelope A(t) exp(i phi(t)), of which the slope of phi over a span of time is the frequency at the mean amplitude there.
"""

from dataclasses import dataclass

import numpy as np

from fe_models.arrays import FloatArray

BAND = 0.35  # Hz: standard deviation of the band; a third of what parts the closest lines that are strong
SPAN = 3.0  # s over which a frequency is told
STEP = 1.5  # s from one to the next
FAINTEST = 0.02  # of the largest amplitude: below, other lines and noise pull at the phase
ENDS = 1.5  # s at both ends, which the band blurs: three standard deviations of its response in time


@dataclass(frozen=True)
class Backbone:
    """``amplitude`` (time,) in the channels' units at the shape's largest entry, ``frequency`` (time,) Hz there and the
    ``ratio`` (time,) of damping that the amplitude's fall tells.
    """

    amplitude: FloatArray
    frequency: FloatArray
    ratio: FloatArray


def backbone_of(data: FloatArray, shape: FloatArray, frequency: float, rate: float) -> Backbone:
    """Return the backbone of the mode with a ``shape`` (sensor,), near ``frequency`` (Hz), in data (time, sensor)."""
    motion = data @ shape / float(shape @ shape)
    spectrum = np.fft.fft(motion)
    frequencies = np.fft.fftfreq(len(motion), 1 / rate)
    envelope = np.fft.ifft(2 * spectrum * np.exp(-0.5 * ((frequencies - frequency) / BAND) ** 2))
    size, phase = np.abs(envelope), np.unwrap(np.angle(envelope))
    span, first = round(SPAN * rate), round(ENDS * rate)
    time = (np.arange(span) - (span - 1) / 2) / rate
    rows = []
    for begin in range(first, len(motion) - first - span + 1, round(STEP * rate)):
        own = slice(begin, begin + span)
        mean = float(np.exp(np.mean(np.log(size[own]))))
        if mean < FAINTEST * size[first:].max():
            break
        weight = size[own] ** 2
        centred = time - np.average(time, weights=weight)
        slopes = [
            np.sum(weight * centred * part) / np.sum(weight * centred**2) for part in (phase[own], np.log(size[own]))
        ]
        rows.append((mean, slopes[0] / (2 * np.pi), -slopes[1] / slopes[0]))
    amplitude, tones, ratios = np.array(rows).reshape(-1, 3).T
    return Backbone(amplitude, tones, ratios)
