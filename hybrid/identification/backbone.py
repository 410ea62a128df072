"""How the frequency of one mode changes while it decays: its backbone curve, from a recording alone.

In each span of time, a few periods long, the mode's damped cosine is fitted anew beside the other modes, whose
frequencies and damping stay those of the whole recording: its frequency belongs to the amplitude in the middle.
"""

from dataclasses import dataclass

import numpy as np

from fe_models.arrays import ComplexArray, FloatArray
from hybrid.identification.config import BACKBONE
from hybrid.identification.damped_cosines import amplitudes_of, columns_of, fit_roots
from hybrid.identification.free_decay_modes import IdentifiedModes


@dataclass(frozen=True)
class Backbone:
    """``amplitude`` (span,) in the channels' units at the shape's largest entry, in the middle of each span of time;
    ``frequency`` (span,) Hz and damping ``ratio`` (span,) there. ``deviation`` (span,) Hz: standard deviation of the
    frequency, from what the fit leaves of the channels (`frequency_deviation`).
    """

    amplitude: FloatArray
    frequency: FloatArray
    ratio: FloatArray
    deviation: FloatArray


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
        return Backbone(*np.zeros((4, 0)))
    own, others = modes.roots[[mode]], np.delete(modes.roots, mode)
    rows: list[tuple[float, float, float, float]] = []
    for begin in np.linspace(0, len(data) - span, spans).round().astype(int):
        part = data[begin : begin + span]
        root = fit_roots(part, own, rate, others)
        amplitudes, _ = amplitudes_of(part, np.concatenate([root, others]), rate)
        middle = np.abs(amplitudes[0] @ shape) / (shape @ shape) * np.exp(root[0].real * span / 2 / rate)
        if rows and middle < BACKBONE.min_amplitude_share * max(row[0] for row in rows):
            break
        deviation = frequency_deviation(part, complex(root[0]), others, rate)
        rows.append((float(middle), float(abs(root[0]) / (2 * np.pi)), float(-root[0].real / abs(root[0])), deviation))
    return Backbone(*np.array(rows).T)


def frequency_deviation(data: FloatArray, root: complex, others: ComplexArray, rate: float) -> float:
    """Return the standard deviation (Hz) of the frequency |s| / 2 pi of one root s = ``root`` fitted to ``data``.

    Of least squares with white residuals, of a variance v_c in each channel c: with J_c (time, 2), the slopes for Re s
    and Im s less what the linear amplitudes take up, cov = H^-1 (sum_c v_c J_c^T J_c) H^-1, H = sum_c J_c^T J_c.
    ``others`` (pole,) are held; ``data`` (time, sensor) is sampled at ``rate`` Hz.
    """
    roots, time = np.concatenate([[root], others]), np.arange(len(data)) / rate
    columns = np.hstack([columns_of(roots, len(data), rate), np.ones((len(data), 1))])
    Q = np.linalg.qr(columns).Q
    left = data - Q @ (Q.T @ data)
    variance = np.sum(left**2, axis=0) / max(1, len(data) - columns.shape[1])  # (sensor,)
    amplitudes, _ = amplitudes_of(data, roots, rate)
    slope = (time * np.exp(root * time))[:, None] * amplitudes[0]  # (time, sensor), complex: d / d s
    slopes = np.stack([slope.real, -slope.imag])  # d / d Re s, d / d Im s
    slopes = slopes - np.einsum("tq,qu,kuc->ktc", Q, Q.T, slopes, optimize=True)
    information = np.einsum("ktc,ltc->kl", slopes, slopes)
    scatter = np.einsum("ktc,ltc,c->kl", slopes, slopes, variance)
    inverse = np.linalg.pinv(information)
    gradient = np.array([root.real, root.imag]) / abs(root) / (2 * np.pi)
    return float(np.sqrt(gradient @ inverse @ scatter @ inverse @ gradient))
