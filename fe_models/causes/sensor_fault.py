"""What falsifies a recording and is no part of the structure: the fault of one sensor."""

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes.base import Cause
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
