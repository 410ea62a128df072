"""The harmonic force that was found in each recording: amplitude, phase, and where it acts at all."""

from dataclasses import dataclass

import numpy as np

from fe_models.arrays import BoolArray
from fe_models.causes.candidate import HarmonicCandidate
from hybrid.diagnosis.fitting.config import HARMONIC
from hybrid.diagnosis.fitting.least_squares import Fit


@dataclass(frozen=True)
class HarmonicAmplitude:
    """``amplitude`` (N) in the recordings where it acts, its standard deviation ``error``, ``phase`` (rad) in the first
    of them; ``acting`` (recording,).
    """

    amplitude: float
    error: float
    phase: float
    acting: BoolArray

    @property
    def is_significant(self) -> bool:
        """Whether the amplitude differs from zero beyond chance."""
        return self.amplitude > HARMONIC.min_amplitude_sigma * self.error


def harmonic_amplitude(fit: Fit, number: int) -> HarmonicAmplitude:
    """Return the force of candidate ``number`` of a fit, from its two entries of the initial states.

    They are F(0) = (a sin(phase), a cos(phase)) and noise, of which the square of the amplitude is freed. The error is
    that of each recording's own two, and of the parameters common to all.
    """
    later = sum(isinstance(c, HarmonicCandidate) for c in fit.hypothesis.candidates[number + 1 :])
    own = slice(-2 * later - 2, -2 * later or None)  # the last ones: how many come before differs between recordings
    components = np.concatenate([states[:, own] for states in fit.states])  # (recording, 2)
    errors = np.concatenate([part[:, own] for part in fit.state_errors])
    slopes = np.concatenate([part[..., own] for part in fit.state_slopes], axis=1)  # (parameter, recording, 2)
    amplitudes = np.linalg.norm(components, axis=1)
    spread = np.sqrt(np.mean(errors**2, axis=1))
    usual = float(np.median(amplitudes[amplitudes >= amplitudes.max() / 2]))
    acting = ~(
        (amplitudes < HARMONIC.absent_share * usual) & (usual - amplitudes > HARMONIC.min_difference_sigma * spread)
    )
    count = int(acting.sum())
    amplitude = float(np.sqrt(max(np.mean(amplitudes[acting] ** 2 - 2 * spread[acting] ** 2), 0.0)))
    along = np.mean(np.sum(slopes * components / amplitudes[:, None], axis=2)[:, acting], axis=1)  # (parameter,)
    variance = float(np.mean(spread[acting] ** 2)) / count + float(along @ fit.covariance @ along)
    phase = float(np.arctan2(*components[int(np.argmax(acting))]))
    return HarmonicAmplitude(amplitude, float(np.sqrt(variance)), phase, acting)
