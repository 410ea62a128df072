"""Noise that is not the same in all recordings: normalised ones, a share of each motion, another amplifier.

Each recording shows its noise itself, but to some ten per cent only, and takes what else is fast for it: too roughly to
say how well a model could forecast it. The pattern behind the levels is what all recordings show together.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from fe_models.arrays import TINY, FloatArray
from hybrid.diagnosis.recorded.batches import Batch, columns_of
from hybrid.diagnosis.recorded.config import NOISE, NOISE_LEVELS
from hybrid.diagnosis.recorded.noise import Band, noise_of_recordings, variance_of_log_noise


class Pattern(Enum):
    """What the noise of a channel goes with."""

    ALIKE = "nothing"
    RECORDING = "one factor for all channels of a recording"
    MOTION = "each channel's own motion in a recording"


@dataclass(frozen=True)
class NoiseLevels:
    """The logarithm of the noise's standard deviation: on average ``usual`` (sensor,), and the ``pattern`` behind it.

    ``centre`` (sensor,): mean of what the pattern says. Recordings are sampled at ``rate`` (Hz); ``band``: of the
    structure, see `noise_of_recordings`.
    """

    pattern: Pattern
    usual: FloatArray
    centre: FloatArray
    rate: float
    band: Band

    @classmethod
    def of(cls, batches: Sequence[Batch], rate: float, band: Band) -> "NoiseLevels":
        """Return the levels of free recordings (see `without_load_response`), all measured channels of them.

        They are alike unless another pattern is behind them, one that leaves no more than chance would: what differs
        without one may be motion, such as the ringing of a stop. One value in twenty may be astray: noise that is a
        share of all motion shows what a low-pass took away.
        """
        levels, motion = (
            np.concatenate(parts) for parts in zip(*[_estimated(b, rate, band) for b in batches], strict=True)
        )
        chance = np.concatenate([np.full(len(b.names), variance_of_log_noise(b.samples, rate, band)) for b in batches])
        fits = [(pattern, *_levels_by(pattern, levels, motion, chance)) for pattern in Pattern]
        pattern, astray, _, usual, centre = min(fits, key=lambda item: (item[1], item[0] is not Pattern.ALIKE, item[2]))
        if astray > levels.size // NOISE_LEVELS.values_per_outlier or pattern is Pattern.ALIKE:
            usual, centre = np.average(levels, axis=0, weights=1 / chance), np.zeros(levels.shape[1])
            pattern = Pattern.ALIKE
        return cls(pattern, usual, centre, rate, band)

    @property
    def are_alike(self) -> bool:
        """Whether all recordings have the same noise, as far as they show."""
        return self.pattern is Pattern.ALIKE

    def of_recordings(self, free: Batch) -> FloatArray:
        """Return the noise of each ``free`` recording (recording, sensor) over the usual one."""
        levels, motion = _estimated(free, self.rate, self.band)
        off = levels - self.usual
        level = _expected(self.pattern, off, motion) - self.centre
        most = NOISE_LEVELS.max_deviation_sigma * np.sqrt(variance_of_log_noise(free.samples, self.rate, self.band))
        own = self.pattern is Pattern.MOTION and np.abs(off - level) > most
        return np.asarray(np.exp(np.where(own, off, level)))

    def beside(self, batch: Batch, columns: Sequence[int]) -> Batch:
        """Return a free ``batch`` of all channels with the noise of each recording, as its measured ``columns`` show
        it.
        """
        if self.are_alike:
            return batch
        noise = np.ones((len(batch.names), batch.data.shape[2]))
        noise[:, list(columns)] = self.of_recordings(*columns_of((batch,), tuple(columns)))
        return replace(batch, noise=noise)


def _levels_by(
    pattern: Pattern, levels: FloatArray, motion: FloatArray, chance: FloatArray
) -> tuple[int, float, FloatArray, FloatArray]:
    """Return how many of the ``levels`` (recording, sensor) are astray if a pattern is behind the others, what
    these leave over what ``chance``, the variance of each recording's, does, and what `NoiseLevels` has of the pattern.
    """
    (recordings, sensors), weight = levels.shape, np.repeat(1 / chance[:, None], levels.shape[1], axis=1)
    for astray in range(1 + (0 if pattern is Pattern.RECORDING else levels.size // NOISE_LEVELS.values_per_outlier)):
        usual = np.average(levels, axis=0, weights=weight)
        expected = _expected(pattern, levels - usual, motion)
        centre = np.average(expected, axis=0, weights=weight)
        square = (levels - usual - expected + centre) ** 2 * weight
        free = (recordings - 1) * (sensors - (pattern is Pattern.RECORDING)) - astray
        if free > 0 and square.sum() <= free + NOISE.max_excess_sigma * np.sqrt(2 * free):
            return astray, float(square.sum() / free), usual, centre
        weight[np.unravel_index(square.argmax(), square.shape)] = 0.0
    return levels.size, np.inf, usual, centre


def _expected(pattern: Pattern, off: FloatArray, motion: FloatArray) -> FloatArray:
    """Return what a pattern says of the levels (recording, sensor), but for a constant of each sensor.

    ``off``: the levels, less the usual ones; ``motion``: logarithm of each channel's own size.
    """
    if pattern is Pattern.MOTION:
        return motion
    if pattern is Pattern.RECORDING:
        return np.broadcast_to(off.mean(axis=1, keepdims=True), off.shape)
    return np.zeros_like(off)


def _estimated(batch: Batch, rate: float, band: Band) -> tuple[FloatArray, FloatArray]:
    """Return the logarithms of the noise of each recording and of its channels' size, both (recording, sensor)."""
    single = [replace(batch.take([number]), noise=None) for number in range(len(batch.names))]
    noise = np.stack([noise_of_recordings((one,), rate, band) for one in single])
    return np.log(np.maximum(noise, TINY)), np.log(np.maximum(batch.recorded.std(axis=1), TINY))
