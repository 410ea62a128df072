"""What may be hidden that no cause of the list is: a hysteretic spring and a stiffness that drifts."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from fe_models.causes import ForceLaw

if TYPE_CHECKING:
    from fe_models.structure import Direction

Pulls = tuple[tuple[int, "Direction", float], ...]


@dataclass(frozen=True)
class DriftingSpring(ForceLaw):
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
class HystereticSpring:
    """The spring of Bouc and Wen: force = k z, z' = v - (|v| |z| z / 2 + v z^2 / 2) / d^2.

    z (m) follows the elongation as long as it is small and stays below ``reach`` d (m), where the spring yields; k is
    its ``stiffness`` (N/m). ``along``: see `ForceLaw.pulls`.
    """

    along: Pulls
    stiffness: float
    reach: float

    def rate(self, v: Any, z: Any) -> Any:
        """Return z' (m/s)."""
        return v - 0.5 * (abs(v) * abs(z) * z + v * z**2) / self.reach**2

    def after(self, z: Any, before: Any, now: Any, step: float) -> Any:
        """Return z after a ``step`` (s) in which the rate of elongation goes from ``before`` to ``now`` (Heun)."""
        first = self.rate(before, z)
        return z + step / 2 * (first + self.rate(now, z + step * first))
