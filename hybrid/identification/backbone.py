"""How the frequency of one mode changes while it decays: its backbone curve, from a recording alone.

In each span of time, a few periods long, the mode's damped cosine is fitted anew beside the other modes, whose
frequencies and damping stay those of the whole recording: its frequency belongs to the amplitude in the middle.
"""

from dataclasses import dataclass

import numpy as np

from fe_models.arrays import ComplexArray, FloatArray
from hybrid.identification.channel_sizes import are_several, rms_of_each
from hybrid.identification.config import BACKBONE
from hybrid.identification.damped_cosines import amplitudes_of, columns_of, fit_roots
from hybrid.identification.identified_modes import IdentifiedModes


@dataclass(frozen=True)
class Backbone:
    """``amplitude`` (span,) in the channels' units at the shape's largest entry, in the middle of each span of time;
    ``frequency`` (span,) Hz and damping ``ratio`` (span,) there. ``deviation`` (span,) Hz and ``ratio_deviation``
    (span,): their standard deviations, from what the fit leaves of the channels (`standard_deviations`).
    """

    amplitude: FloatArray
    frequency: FloatArray
    ratio: FloatArray
    deviation: FloatArray
    ratio_deviation: FloatArray


def backbone_of(data: FloatArray, modes: IdentifiedModes, mode: int, rate: float) -> Backbone:
    """Return the backbone of number ``mode`` (from 0) of a recording's ``modes``, in data (time, sensor).

    It ends where the motion has become too small to tell a frequency, and is empty where the recording holds no more
    than one span. Channels of several quantities count over the noise of each.
    """
    noise = _noise(data, modes, rate)
    data, shape = data / noise, modes.phases * modes.real_shapes[:, mode] / noise
    frequency = modes.frequencies[mode]
    longest = max(
        min(BACKBONE.span_periods, BACKBONE.max_span_share * len(data) / rate * frequency), BACKBONE.min_span_periods
    )
    span = round(longest / frequency * rate)
    spans = 1 + int((len(data) - span) // (BACKBONE.step_share * span))
    if spans < 2:
        return Backbone(*np.zeros((5, 0)))
    own, others = modes.roots[[mode]], np.delete(modes.roots, mode)
    rows: list[tuple[float, float, float, float, float]] = []
    for begin in np.linspace(0, len(data) - span, spans).round().astype(int):
        part = data[begin : begin + span]
        root = fit_roots(part, own, rate, others)
        amplitudes, _ = amplitudes_of(part, np.concatenate([root, others]), rate)
        begins = np.abs(amplitudes[0] @ shape.conj()) / np.linalg.norm(shape) ** 2
        middle = begins * np.exp(root[0].real * span / 2 / rate)
        if rows and middle < BACKBONE.min_amplitude_share * max(row[0] for row in rows):
            break
        found, size = complex(root[0]), float(abs(root[0]))
        deviations = standard_deviations(part, found, others, rate)
        if deviations[0] > BACKBONE.max_frequency_error * size / (2 * np.pi):
            break
        rows.append((float(middle), size / (2 * np.pi), -found.real / size, *deviations))
    return Backbone(*np.array(rows).reshape(-1, 5).T)


def _noise(data: FloatArray, modes: IdentifiedModes, rate: float) -> FloatArray:
    """Return what all modes leave of ``data`` (time, sensor), rms by quantity, (sensor,); ones of one quantity."""
    if not are_several(modes.orders):
        return np.ones(data.shape[1])
    columns = np.hstack([columns_of(modes.roots, len(data), rate), np.ones((len(data), 1))])
    Q = np.linalg.qr(columns).Q
    noise = rms_of_each(data - Q @ (Q.T @ data), modes.orders)
    return np.asarray(np.where(noise > 0, noise, 1.0))


def standard_deviations(data: FloatArray, root: complex, others: ComplexArray, rate: float) -> tuple[float, float]:
    """Return those of the frequency |s| / 2 pi (Hz) and damping ratio -Re s / |s| of one ``root`` s fitted to ``data``.

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
    size = abs(root)
    gradients = np.array(
        [
            np.array([root.real, root.imag]) / size / (2 * np.pi),
            np.array([-(root.imag**2), root.real * root.imag]) / size**3,
        ]
    )
    frequency, ratio = np.sqrt(np.diag(gradients @ inverse @ scatter @ inverse @ gradients.T)).tolist()
    return frequency, ratio
