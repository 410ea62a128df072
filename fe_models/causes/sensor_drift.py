"""A sensor that drifts."""

from dataclasses import dataclass, replace
from typing import ClassVar, Literal

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes.base import parameter
from fe_models.causes.candidate import SensorCandidate
from fe_models.causes.known import Known
from fe_models.causes.sensor_fault import SensorEffect


@dataclass(frozen=True)
class SensorDrift(SensorEffect):
    """A sensor that drifts: shows y(t) + slope t, t (s) from the start of each recording.

    ``slope`` is in the sensor's own unit per second.
    """

    kind: ClassVar[str] = "sensor_drift"
    template: ClassVar[str] = "{place} drifts by {slope}"
    quantity: ClassVar[Literal["gain", "delay", "drift"]] = "drift"
    slope: float = parameter("unit/s")

    def distort(self, channel: FloatArray, sampling_rate: float) -> FloatArray:
        """Return channel + slope * t."""
        return np.asarray(channel + self.slope * np.arange(channel.shape[-1]) / sampling_rate)

    @classmethod
    def candidates(cls, known: Known) -> list[SensorCandidate]:
        """Return it at each measured sensor."""
        return [
            cls.at_sensor(position, channel, neutral=0.0, width=channel.rms / channel.duration)
            for position, channel in enumerate(known.channels)
        ]

    def inverse(self) -> "SensorDrift":
        """Return the fault that takes this one back."""
        return replace(self, slope=-self.slope)
