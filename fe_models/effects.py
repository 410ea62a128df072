"""Effects a simulation may lack, each defined once: name, parameters with units, and the force it exerts.

Hiding an effect in data (Exudyn), feeling it in a reduced model (NumPy, PyTorch) and writing it to a file all use the
definition here: `force` is plain arithmetic, so it takes floats, arrays, tensors and Exudyn's symbolic numbers alike.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from typing import Any, ClassVar, Literal


@dataclass(frozen=True)
class ConnectorEffect(ABC):
    """A force between a node and the ground, or between two nodes, in one direction.

    The elongation u = u_last - u_first (or u of the only node) and its rate v give the `force` that pulls the last node
    back and the first one forth.
    """

    kind: ClassVar[str]
    nodes: tuple[int] | tuple[int, int]
    direction: Literal["x", "y", "rz"]

    @abstractmethod
    def force(self, u: Any, v: Any) -> Any:
        """Return the restoring force (N) at elongation ``u`` (m) and rate ``v`` (m/s), any shape."""


@dataclass(frozen=True)
class CubicSpring(ConnectorEffect):
    """A hardening (or, negative, softening) spring without linear part: force = stiffness u^3."""

    kind: ClassVar[str] = "cubic_spring"
    stiffness: float = field(default=0.0, metadata={"unit": "N/m^3"})

    def force(self, u: Any, v: Any) -> Any:
        """Return stiffness * u^3 (N)."""
        return self.stiffness * u * u * u


Effect = CubicSpring
EFFECTS: dict[str, type[Effect]] = {effect.kind: effect for effect in (CubicSpring,)}
