"""A sensor with a wrong scale."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes.base import parameter
from fe_models.causes.sensor_fault import SensorEffect


@dataclass(frozen=True)
class SensorGain(SensorEffect):
    """A sensor with a wrong scale: shows factor y(t). A negative factor is a sensor mounted the other way round."""

    kind: ClassVar[str] = "sensor_gain"
    factor: float = parameter("1")

    def distort(self, channel: FloatArray, sampling_rate: float) -> FloatArray:
        """Return factor * channel."""
        return np.asarray(self.factor * channel)
