"""A sensor with a wrong scale."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar, Literal

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes.base import parameter
from fe_models.causes.candidate import SensorCandidate
from fe_models.causes.known import Known
from fe_models.causes.sensor_fault import SensorEffect
from fe_models.causes.wording import sentence
from fe_models.structure import Structure

PRIOR_STD = 0.3  # the prior standard deviation of a gain about one
REVERSED_GAIN = -1.0  # the gain of a sensor that is mounted the wrong way round
DEAD_GAIN = 1e-4  # of a sensor that is not connected, or of a unit as good as that: micrometres for metres
DEAD = "{place} shows next to nothing of the motion ({factor} times the truth): check its cable, then its unit"


@dataclass(frozen=True)
class SensorGain(SensorEffect):
    """A sensor with a wrong scale: shows factor y(t). A negative factor is a sensor mounted the other way round."""

    kind: ClassVar[str] = "sensor_gain"
    template: ClassVar[str] = "{place} shows {factor} times the truth: check its unit, calibration and mounting"
    quantity: ClassVar[Literal["gain", "delay", "drift"]] = "gain"
    factor: float = parameter("1")

    def distort(self, channel: FloatArray, sampling_rate: float) -> FloatArray:
        """Return factor * channel."""
        return np.asarray(self.factor * channel)

    def sentence(self, values: Mapping[str, str], structure: Structure) -> str:
        """Return what to do; of a sensor that shows nothing a factor would say too much."""
        if abs(self.factor) > DEAD_GAIN:
            return super().sentence(values, structure)
        return sentence(DEAD, self.location, **values)

    @classmethod
    def candidates(cls, known: Known) -> list[SensorCandidate]:
        """Return it at each measured sensor."""
        return [
            cls.at_sensor(position, channel, neutral=1.0, width=PRIOR_STD, far=(REVERSED_GAIN,))
            for position, channel in enumerate(known.channels)
        ]

    def inverse(self) -> "SensorGain":
        """Return the fault that takes this one back."""
        return replace(self, factor=1 / self.factor)
