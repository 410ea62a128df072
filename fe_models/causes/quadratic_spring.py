"""A spring that resists more one way than the other."""

from dataclasses import dataclass
from typing import Any, ClassVar

from fe_models.causes.base import parameter
from fe_models.causes.power_spring import PowerSpring
from fe_models.one_node import node_or_nodes


@node_or_nodes
@dataclass(frozen=True)
class QuadraticSpring(PowerSpring):
    """The asymmetry of a spring, without its linear part: force = stiffness u^2.

    With a positive stiffness the spring hardens under positive elongation and softens under negative.
    """

    kind: ClassVar[str] = "quadratic_spring"
    template: ClassVar[str] = "a quadratic spring of {stiffness} acts {at} (positive: harder where it is elongated)"
    power: ClassVar[int] = 2
    stiffness: float = parameter("N/m^2", "N m/rad^2")

    def force(self, u: Any, v: Any, t: Any = 0.0) -> Any:
        """Return stiffness * u^2 (N)."""
        return self.stiffness * u * u
