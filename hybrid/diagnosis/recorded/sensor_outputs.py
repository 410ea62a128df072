"""What a motion is read by: sensors, how often they are sampled, and which of the measured ones they are."""

from dataclasses import dataclass
from typing import Self

from fe_models.recordings import Sensor


@dataclass(frozen=True)
class SensorOutputs:
    """The ``sensors``, their ``rate`` (Hz), and for each its position among the measured ones, -1 where it is none.

    Only measured sensors have faults: a gain, a delay, a drift.
    """

    sensors: tuple[Sensor, ...]
    rate: float
    positions: tuple[int, ...]

    @classmethod
    def measured(cls, sensors: tuple[Sensor, ...], rate: float) -> Self:
        """Return the sensor outputs whose ``sensors`` are the measured ones, and all of them."""
        return cls(sensors, rate, tuple(range(len(sensors))))

    @classmethod
    def faultless(cls, sensors: tuple[Sensor, ...], rate: float) -> Self:
        """Return the sensor outputs of ``sensors`` none of which is measured."""
        return cls(sensors, rate, (-1,) * len(sensors))
