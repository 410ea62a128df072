"""How the frequency of one mode changes while it decays: its backbone curve, from a recording alone.

In each span of time, a few periods long, the mode's damped cosine is fitted anew beside the other modes, whose
frequencies and damping stay those of the whole recording: its frequency belongs to the amplitude in the middle.
"""

from dataclasses import dataclass

import numpy as np

from fe_models.arrays import FloatArray
from hybrid.identification.config import BACKBONE
from hybrid.identification.damped_cosines import amplitudes_of, fit_roots
from hybrid.identification.free_decay_modes import IdentifiedModes


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
    longest = max(
        min(BACKBONE.span_periods, BACKBONE.max_span_share * len(data) / rate * frequency), BACKBONE.min_span_periods
    )
    span = round(longest / frequency * rate)
    spans = 1 + int((len(data) - span) // (BACKBONE.step_share * span))
    if spans < 2:
        return Backbone(np.zeros(0), np.zeros(0), np.zeros(0))
    own, others = modes.roots[[mode]], np.delete(modes.roots, mode)
    rows: list[tuple[float, float, float]] = []
    for begin in np.linspace(0, len(data) - span, spans).round().astype(int):
        part = data[begin : begin + span]
        root = fit_roots(part, own, rate, others)
        amplitudes, _ = amplitudes_of(part, np.concatenate([root, others]), rate)
        middle = np.abs(amplitudes[0] @ shape) / (shape @ shape) * np.exp(root[0].real * span / 2 / rate)
        if rows and middle < BACKBONE.min_amplitude_share * max(row[0] for row in rows):
            break
        rows.append((float(middle), float(abs(root[0]) / (2 * np.pi)), float(-root[0].real / abs(root[0]))))
    amplitude, found, ratio = np.array(rows).T
    return Backbone(amplitude, found, ratio)
