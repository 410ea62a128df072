"""The motion of every degree of freedom over time, as a simulation returns it."""

from dataclasses import dataclass

from fe_models.arrays import FloatArray
from fe_models.dof_map import DofMap
from fe_models.recordings import QUANTITIES, Quantity, Sensor
from fe_models.sensing import seen
from fe_models.structure import TRANSLATIONS


@dataclass(frozen=True)
class Response:
    """Motion about the state at rest, on equal steps of ``time`` (time,) in s.

    ``displacement`` (m), ``velocity`` (m/s), ``acceleration`` (m/s^2), in rad for rotations: (time, dof), or
    (realisation, time, dof) for many motions of one structure. Supports have their zeros. Where the base moves they are
    relative to it; ``ground`` (3, time, 3): its own displacement, velocity and acceleration in x, y and z.
    """

    time: FloatArray
    displacement: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    dofs: DofMap
    ground: FloatArray | None = None

    @property
    def sampling_rate(self) -> float:
        """Samples a second (Hz)."""
        return float((len(self.time) - 1) / (self.time[-1] - self.time[0]))

    def channel(self, node: int, direction: str, quantity: Quantity) -> FloatArray:
        """Return one quantity at one degree of freedom, (..., time); `KeyError` where the model has none there."""
        values: FloatArray = getattr(self, quantity)
        return values[..., self.dofs.row(node, direction)]

    def shown(self, sensor: Sensor) -> FloatArray:
        """Return what a sensor without fault shows, (..., time): the absolute motion, or that relative to the base."""
        values: FloatArray = getattr(self, sensor.quantity)
        relative = values @ seen(self.dofs, [sensor])[0]
        if self.ground is None or sensor.reference == "base" or sensor.turns:
            return relative
        along = [sensor.components.get(axis, 0.0) for axis in TRANSLATIONS]
        return relative + self.ground[QUANTITIES.index(sensor.quantity)] @ along
