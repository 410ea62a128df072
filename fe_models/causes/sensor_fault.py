"""What falsifies a recording and is no part of the structure: the fault of one sensor."""

from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import ClassVar, Literal

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes.base import Cause
from fe_models.causes.candidate import UNBOUNDED, SensorCandidate
from fe_models.causes.known import Channel
from fe_models.causes.searched import Searched
from fe_models.errors import InputError


@dataclass(frozen=True)
class SensorEffect(Searched, Cause):
    """A fault of one sensor, named as in the dataset; ``quantity``: which number of the sensor its parameter is."""

    quantity: ClassVar[Literal["gain", "delay", "drift"]]
    sensor: str

    @classmethod
    def at_sensor(
        cls, position: int, channel: Channel, neutral: float, width: float, far: tuple[float, ...] = ()
    ) -> SensorCandidate:
        """Return the fault at one sensor, by its position among the measured ones, with its prior: see `Candidate`."""
        build: Callable[..., SensorEffect] = partial(cls, channel.name)
        return SensorCandidate(
            kind=cls.kind,
            location={"sensor": channel.name},
            names=tuple(build(neutral).units),
            build=build,
            neutral=(neutral,),
            width=(width,),
            lower=UNBOUNDED,
            far=far,
            sensor=position,
            quantity=cls.quantity,
        )

    @abstractmethod
    def inverse(self) -> "SensorEffect":
        """Return the fault that takes this one back."""

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
