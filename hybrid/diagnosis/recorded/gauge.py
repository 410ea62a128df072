"""What recordings were measured with: sensors, rate and noise."""

from dataclasses import dataclass

from fe_models.dofs import FloatArray
from fe_models.recordings import Sensor


@dataclass(frozen=True)
class Gauge:
    """The fitted ``sensors``, their ``rate`` (Hz), and ``sigma`` (sensor,) of the noise.

    Where noise differs from recording to recording, ``sigma`` is that of a usual one: see `Batch.sigma`.
    """

    sensors: tuple[Sensor, ...]
    rate: float
    sigma: FloatArray

    @property
    def positions(self) -> tuple[int, ...]:
        """Each sensor's position among the measured ones: its own."""
        return tuple(range(len(self.sensors)))
