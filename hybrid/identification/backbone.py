"""How the frequency of one mode changes while it decays: its backbone curve, from a recording alone.

In each span of time, a few periods long, the mode's damped cosine is fitted anew beside the other modes, whose
frequencies and damping stay those of the whole recording: its frequency belongs to the amplitude in the middle.
"""

from dataclasses import dataclass

import numpy as np

from fe_models.arrays import FloatArray
from hybrid.identification.damped_cosines import amplitudes_of, fit_roots
from hybrid.identification.free_decay_modes import IdentifiedModes

SPAN_PERIODS = 12.0  # of the mode, in which a frequency is fitted ...
SPAN_SHARE = 0.5  # ... or half of the recording where that is less ...
MIN_SPAN_PERIODS = 1.5  # ... but no less than a frequency needs to be distinguished from its damping and an offset
STEP_SHARE = 0.5  # of a span, from one to the next
MIN_AMPLITUDE = 0.02  # of the largest: below, other modes and noise pull at the frequency


@dataclass(frozen=True)
class Backbone:
    """``amplitude`` (span,) in the channels' units at the shape's largest entry, in the middle of each span of time;
    ``frequency`` (span,) Hz and damping ``ratio`` (span,) there.
    """

    amplitude: FloatArray
    frequency: FloatArray
    ratio: FloatArray


def backbone_of(data: FloatArray, modes: IdentifiedModes, mode: int, rate: float) -> Backbone:
    """Return the backbone of number ``mode`` (from 0) of a recording's ``modes``, in data (time, sensor).

    It is empty where the recording holds no more than one span.
    """
    frequency, shape = modes.frequencies[mode], modes.shapes[:, mode]
    longest = max(min(SPAN_PERIODS, SPAN_SHARE * len(data) / rate * frequency), MIN_SPAN_PERIODS)
    span = round(longest / frequency * rate)
    spans = 1 + int((len(data) - span) // (STEP_SHARE * span))
    if spans < 2:
        return Backbone(np.zeros(0), np.zeros(0), np.zeros(0))
    own, others = modes.roots[[mode]], np.delete(modes.roots, mode)
    rows: list[tuple[float, float, float]] = []
    for begin in np.linspace(0, len(data) - span, spans).round().astype(int):
        part = data[begin : begin + span]
        root = fit_roots(part, own, rate, others)
        amplitudes, _ = amplitudes_of(part, np.concatenate([root, others]), rate)
        middle = np.abs(amplitudes[0] @ shape) / (shape @ shape) * np.exp(root[0].real * span / 2 / rate)
        if rows and middle < MIN_AMPLITUDE * max(row[0] for row in rows):
            break
        rows.append((float(middle), float(abs(root[0]) / (2 * np.pi)), float(-root[0].real / abs(root[0]))))
    amplitude, found, ratio = np.array(rows).T
    return Backbone(amplitude, found, ratio)
