"""What may be hidden that no cause of the list is: stiffness that drifts or swings to and fro, a spring that creeps."""

from dataclasses import dataclass
from math import pi
from typing import TYPE_CHECKING, Any

from fe_models.causes import LawWithMemory, MemorylessLaw
from fe_models.causes.arithmetic import sine

if TYPE_CHECKING:
    from fe_models.structure import Direction

Pulls = tuple[tuple[int, "Direction", float], ...]


@dataclass(frozen=True)
class DriftingSpring(MemorylessLaw):
    """A spring whose stiffness grows in proportion to time: force = slope t u.

    ``along``: what its elongation u is made of, as in `ForceLaw.pulls`; ``slope`` in N/(m s).
    """

    along: Pulls
    slope: float
    timed = True

    @property
    def pulls(self) -> Any:
        """Those it was given."""
        return self.along

    def force(self, u: Any, v: Any, t: Any = 0.0) -> Any:
        """Return slope * t * u (N)."""
        return self.slope * t * u


@dataclass(frozen=True)
class SwingingSpring(MemorylessLaw):
    """A parametric excitation, a stiffness that swings to and fro: force = swing sin(2 pi frequency t) u.

    ``along``: as of `DriftingSpring`; ``swing`` in N/m, ``frequency`` in Hz.
    """

    along: Pulls
    swing: float
    frequency: float
    timed = True

    @property
    def pulls(self) -> Any:
        """Those it was given."""
        return self.along

    def force(self, u: Any, v: Any, t: Any = 0.0) -> Any:
        """Return swing * sin(2 pi frequency t) * u (N)."""
        return self.swing * sine(2 * pi * self.frequency * t) * u


@dataclass(frozen=True)
class CreepingSpring(LawWithMemory):
    """A spring in series with Norton's creep: force = k z, z' = v - (z / reach)^2 z / time.

    Unlike dry friction it gives way the more the longer it is loaded. ``stiffness`` k in N/m, ``reach`` in m, ``time``
    in s; ``along``: as of `DriftingSpring`.
    """

    along: Pulls
    stiffness: float
    reach: float
    time: float

    @property
    def pulls(self) -> Any:
        """Those it was given."""
        return self.along

    @property
    def largest(self) -> float:
        """No bound: the faster it is pulled, the farther."""
        return float("inf")

    def rate(self, v: Any, z: Any) -> Any:
        """Return z' (m/s)."""
        return v - (z / self.reach) ** 2 * z / self.time

    def force_of(self, z: Any) -> Any:
        """Return stiffness * z (N)."""
        return self.stiffness * z

    def pulled_to(self, u: Any) -> Any:
        """Return 0: a pull that lasts has crept away."""
        return 0.0 * u
