"""What recordings were measured with, sensors, rate and noise, and what they show."""

from dataclasses import dataclass

from fe_models.arrays import FloatArray
from fe_models.recordings import Sensor
from hybrid.diagnosis.recorded.readout import Readout


@dataclass(frozen=True)
class Gauge:
    """The fitted ``sensors``, their ``rate`` (Hz), and ``sigma`` (sensor,) of the noise.

    Where noise differs from recording to recording, ``sigma`` is that of a usual one: see `Batch.sigma`.
    """

    sensors: tuple[Sensor, ...]
    rate: float
    sigma: FloatArray

    @property
    def readout(self) -> Readout:
        """What the fitted sensors show."""
        return Readout.measured(self.sensors, self.rate)

    @property
    def view(self) -> "View":
        """The view of recordings that show the fitted sensors and no others."""
        return View(self.sensors, tuple(range(len(self.sensors))), self)


@dataclass(frozen=True)
class View:
    """The ``sensors`` that recordings show, the columns of those ``measured``, and the ``gauge`` with these alone.

    The others are held out: what they show is forecast, and tells nothing.
    """

    sensors: tuple[Sensor, ...]
    measured: tuple[int, ...]
    gauge: Gauge

    @property
    def readout(self) -> Readout:
        """What the measured sensors and the held-out ones show."""
        positions = (self.measured.index(i) if i in self.measured else -1 for i in range(len(self.sensors)))
        return Readout(self.sensors, self.gauge.rate, tuple(positions))
