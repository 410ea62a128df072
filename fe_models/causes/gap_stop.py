"""A stop that is met beyond a gap."""

from dataclasses import dataclass
from typing import Any, ClassVar, Literal

from fe_models.causes.arithmetic import SMOOTHING, smooth_ramp
from fe_models.causes.base import negative_faults, parameter
from fe_models.causes.connector import ConnectorEffect
from fe_models.one_node import node_or_nodes
from fe_models.structure import Structure


@node_or_nodes
@dataclass(frozen=True)
class GapStop(ConnectorEffect):
    """A spring that is met only beyond a gap, on one side: force = side stiffness max(side u - gap, 0).

    ``side`` +1 stops motion in the direction, -1 motion against it. Contact sets in smoothly within 1 % of the gap
    (`arithmetic.smooth_ramp`), so that the force has a slope everywhere; without a gap it has a kink at rest.
    """

    kind: ClassVar[str] = "gap_stop"
    gap: float = parameter("m", "rad")
    stiffness: float = parameter("N/m", "N m/rad")
    side: Literal[1, -1] = parameter("1")

    def force(self, u: Any, v: Any, t: Any = 0.0) -> Any:
        """Return side * stiffness * ramp(side * u - gap) (N)."""
        return self.side * self.stiffness * smooth_ramp(self.side * u - self.gap, SMOOTHING * self.gap)

    @property
    def largest_slopes(self) -> tuple[float, float]:
        """The stiffness in contact."""
        return self.stiffness, 0.0

    def faults(self, structure: Structure) -> list[str]:
        """Return faults of the place and of the parameters."""
        faults = super().faults(structure) + negative_faults(gap=self.gap, stiffness=self.stiffness)
        return faults if self.side in (1, -1) else [*faults, f"side = {self.side}; must be 1 or -1"]
