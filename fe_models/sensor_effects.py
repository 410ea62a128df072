"""What falsifies a recording and is no part of the structure: a sensor's gain, delay and drift."""

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.interpolate import CubicSpline

from fe_models.arrays import FloatArray
from fe_models.effects.base import Cause, parameter
from fe_models.errors import InputError


@dataclass(frozen=True)
class SensorEffect(Cause):
    """A fault of one sensor, named as in the dataset."""

    sensor: str

    @abstractmethod
    def distort(self, channel: FloatArray, sampling_rate: float) -> FloatArray:
        """Return what the sensor shows of the true ``channel`` (..., time), sampled at ``sampling_rate`` (Hz)."""

    def apply(self, data: FloatArray, names: Sequence[str], sampling_rate: float) -> FloatArray:
        """Return recordings (..., time, sensor) with this fault in its own channel; ``names`` are the sensors'."""
        if self.sensor not in names:
            raise InputError(f"{self.kind}: there is no sensor {self.sensor!r}; the sensors are {', '.join(names)}")
        result = np.array(data, dtype=float)
        column = list(names).index(self.sensor)
        result[..., column] = self.distort(result[..., column], sampling_rate)
        return result

    def faults(self, names: Sequence[str]) -> list[str]:
        """Return what does not fit a dataset with sensors of these ``names``."""
        faults = [] if self.sensor in names else [f"there is no sensor {self.sensor!r}; expected {', '.join(names)}"]
        return faults + self.number_faults()


@dataclass(frozen=True)
class SensorGain(SensorEffect):
    """A sensor with a wrong scale: shows factor y(t). A negative factor is a sensor mounted the other way round."""

    kind: ClassVar[str] = "sensor_gain"
    factor: float = parameter("1")

    def distort(self, channel: FloatArray, sampling_rate: float) -> FloatArray:
        """Return factor * channel."""
        return np.asarray(self.factor * channel)


@dataclass(frozen=True)
class SensorDelay(SensorEffect):
    """A clock that is off: shows y(t - delay), delay > 0 being late.

    Between samples a cubic spline (not-a-knot), of order 4 in the sampling interval: off by 1e-3 of the amplitude at 8
    samples a period and 1e-4 at 14. The recording does not hold what lies up to |delay| outside of it; the end cubics
    go on there, which is good for about one sample: leave out the first (last) ``delay`` seconds where it matters.
    """

    kind: ClassVar[str] = "sensor_delay"
    delay: float = parameter("s")

    def distort(self, channel: FloatArray, sampling_rate: float) -> FloatArray:
        """Return the channel at t - delay."""
        samples = np.arange(channel.shape[-1], dtype=float)
        return np.asarray(CubicSpline(samples, channel, axis=-1)(samples - self.delay * sampling_rate))


@dataclass(frozen=True)
class SensorDrift(SensorEffect):
    """A sensor that drifts: shows y(t) + slope t, t (s) from the start of each recording.

    ``slope`` is in the sensor's own unit per second.
    """

    kind: ClassVar[str] = "sensor_drift"
    slope: float = parameter("unit/s")

    def distort(self, channel: FloatArray, sampling_rate: float) -> FloatArray:
        """Return channel + slope * t."""
        return np.asarray(channel + self.slope * np.arange(channel.shape[-1]) / sampling_rate)
