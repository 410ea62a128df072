"""The motion of every degree of freedom over time, as a simulation returns it."""

from dataclasses import dataclass

from fe_models.arrays import FloatArray
from fe_models.dof_map import DofMap
from fe_models.recordings import Quantity


@dataclass(frozen=True)
class Response:
    """Motion about the state at rest, on equal steps of ``time`` (time,) in s.

    ``displacement`` (m), ``velocity`` (m/s), ``acceleration`` (m/s^2), in rad for "rz": (time, dof), or
    (realisation, time, dof) for many motions of one structure. Supports have their zeros.
    """

    time: FloatArray
    displacement: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    dofs: DofMap

    @property
    def sampling_rate(self) -> float:
        """Samples a second (Hz)."""
        return float((len(self.time) - 1) / (self.time[-1] - self.time[0]))

    def channel(self, node: int, direction: str, quantity: Quantity) -> FloatArray:
        """Return one quantity at one degree of freedom, (..., time); `KeyError` where the model has none there."""
        values: FloatArray = getattr(self, quantity)
        return values[..., self.dofs.row(node, direction)]
