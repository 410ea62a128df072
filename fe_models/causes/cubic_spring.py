"""A spring that grows stiffer, or softer, with its elongation."""

from dataclasses import dataclass
from typing import Any, ClassVar

from fe_models.causes.base import parameter
from fe_models.causes.power_spring import PowerSpring
from fe_models.one_node import node_or_nodes


@node_or_nodes
@dataclass(frozen=True)
class CubicSpring(PowerSpring):
    """A hardening (or, negative, softening) spring without linear part: force = stiffness u^3."""

    kind: ClassVar[str] = "cubic_spring"
    template: ClassVar[str] = "a cubic spring of {stiffness} acts {at} (positive: hardening)"
    power: ClassVar[int] = 3
    stiffness: float = parameter("N/m^3", "N m/rad^3")

    def force(self, u: Any, v: Any, t: Any = 0.0) -> Any:
        """Return stiffness * u^3 (N)."""
        return self.stiffness * u * u * u
