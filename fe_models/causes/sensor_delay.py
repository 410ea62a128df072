"""A sensor whose clock is off."""

from dataclasses import dataclass, replace
from typing import ClassVar, Literal

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes.base import parameter
from fe_models.causes.candidate import SensorCandidate
from fe_models.causes.known import Known
from fe_models.causes.sensor_fault import SensorEffect

PRIOR_STD_PERIODS = 0.03  # of a period: the prior standard deviation of a delay


@dataclass(frozen=True)
class SensorDelay(SensorEffect):
    """A clock that is off: shows y(t - delay), delay > 0 being late.

    Between samples a cubic spline (not-a-knot), of order 4 in the sampling interval: off by 1e-3 of the amplitude at 8
    samples a period and 1e-4 at 14. The recording does not hold what lies up to |delay| outside of it; the end cubics
    go on there, which is good for about one sample: leave out the first (last) ``delay`` seconds where it matters.
    """

    kind: ClassVar[str] = "sensor_delay"
    template: ClassVar[str] = "{place} is late by {delay}: check its clock"
    negative_template: ClassVar[str] = "{place} is early by {delay}: check its clock"
    quantity: ClassVar[Literal["gain", "delay", "drift"]] = "delay"
    delay: float = parameter("s")

    def distort(self, channel: FloatArray, sampling_rate: float) -> FloatArray:
        """Return the channel at t - delay."""
        from scipy.interpolate import CubicSpline  # here, as it takes longer to load than a dataset to read

        samples = np.arange(channel.shape[-1], dtype=float)
        return np.asarray(CubicSpline(samples, channel, axis=-1)(samples - self.delay * sampling_rate))

    @classmethod
    def candidates(cls, known: Known) -> list[SensorCandidate]:
        """Return it at each measured sensor."""
        return [
            cls.at_sensor(position, channel, neutral=0.0, width=PRIOR_STD_PERIODS * known.period)
            for position, channel in enumerate(known.channels)
        ]

    def inverse(self) -> "SensorDelay":
        """Return the fault that takes this one back."""
        return replace(self, delay=-self.delay)
