"""What recordings were measured with, sensors, rate and noise, and what they show."""

from dataclasses import dataclass

from fe_models.arrays import FloatArray
from fe_models.recordings import Sensor
from hybrid.diagnosis.recorded.sensor_outputs import SensorOutputs


@dataclass(frozen=True, eq=False)  # two are never equal, so that what was made with one can be looked up by it
class NoiseModel:
    """The fitted ``sensors``, their ``rate`` (Hz), and ``sigma`` (sensor,) of the noise.

    Where noise differs from recording to recording, ``sigma`` is that of a usual one: see `Batch.sigma`.
    """

    sensors: tuple[Sensor, ...]
    rate: float
    sigma: FloatArray

    @property
    def outputs(self) -> SensorOutputs:
        """What the fitted sensors show."""
        return SensorOutputs.measured(self.sensors, self.rate)

    @property
    def roles(self) -> "SensorRoles":
        """The view of recordings that show the fitted sensors and no others."""
        return SensorRoles(self.sensors, tuple(range(len(self.sensors))), self)


@dataclass(frozen=True)
class SensorRoles:
    """The ``sensors`` that recordings show, the columns of those ``measured``, and the ``noise_model`` with these
    alone.

    The others are held out: what they show is forecast, and says nothing.
    """

    sensors: tuple[Sensor, ...]
    measured: tuple[int, ...]
    noise_model: NoiseModel

    @property
    def outputs(self) -> SensorOutputs:
        """What the measured sensors and the held-out ones show."""
        positions = (self.measured.index(i) if i in self.measured else -1 for i in range(len(self.sensors)))
        return SensorOutputs(self.sensors, self.noise_model.rate, tuple(positions))
