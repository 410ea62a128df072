"""A sensor that drifts."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes.base import parameter
from fe_models.causes.sensor_fault import SensorEffect


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
