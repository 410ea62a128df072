"""Force laws between a node and the ground, or between two nodes, in one direction."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from fe_models.effects.arithmetic import SMOOTHING, absolute, smooth_ramp
from fe_models.effects.base import Effect, ForceLaw, negative_faults, node_faults, parameter, setting

if TYPE_CHECKING:
    from fe_models.structure import Direction, Structure


@dataclass(frozen=True)
class ConnectorEffect(Effect, ForceLaw):
    """A force between a node and the ground, or between two nodes, in one direction.

    The elongation u = u_last - u_first (or u of the only node), measured from the state at rest, and its rate v give
    the `force` that pulls the last node back and the first one forth.
    """

    nodes: tuple[int] | tuple[int, int]
    direction: Literal["x", "y", "rz"]

    @property
    def pulls(self) -> tuple[tuple[int, "Direction", float], ...]:
        """The last node with 1, the first of two with -1."""
        last: tuple[tuple[int, Direction, float], ...] = ((self.nodes[-1], self.direction, 1.0),)
        return last if len(self.nodes) == 1 else ((self.nodes[0], self.direction, -1.0), *last)

    def law(self, structure: "Structure") -> ForceLaw:
        """Return the connector itself."""
        return self

    def faults(self, structure: "Structure") -> list[str]:
        """Return faults of the place and of the parameters."""
        return node_faults(structure, self.nodes, self.direction) + self.number_faults()


@dataclass(frozen=True)
class CubicSpring(ConnectorEffect):
    """A hardening (or, negative, softening) spring without linear part: force = stiffness u^3."""

    kind: ClassVar[str] = "cubic_spring"
    stiffness: float = parameter("N/m^3", "N m/rad^3")

    def force(self, u: Any, v: Any, t: Any = 0.0) -> Any:
        """Return stiffness * u^3 (N)."""
        return self.stiffness * u * u * u


@dataclass(frozen=True)
class QuadraticDamper(ConnectorEffect):
    """Drag, as of air or water: force = coefficient v |v|."""

    kind: ClassVar[str] = "quadratic_damper"
    coefficient: float = parameter("N s^2/m^2", "N m s^2/rad^2")

    def force(self, u: Any, v: Any, t: Any = 0.0) -> Any:
        """Return coefficient * v * |v| (N)."""
        return self.coefficient * v * absolute(v)

    def faults(self, structure: "Structure") -> list[str]:
        """Return faults; a negative coefficient would feed energy in."""
        return super().faults(structure) + negative_faults(coefficient=self.coefficient)


@dataclass(frozen=True)
class CoulombFriction(ConnectorEffect):
    """Dry friction: force = F v / sqrt(v^2 + v0^2), which tends to F sign(v).

    The ``regularisation`` v0 (m/s) takes the place of sticking: at |v| = v0 the force is 0.71 F, at 7 v0 99 % of F, and
    a body that would stick creeps against a dashpot F / v0. Choose about 1 % of the velocities that matter; smaller
    ones need smaller steps.
    """

    kind: ClassVar[str] = "coulomb_friction"
    friction: float = parameter("N", "N m", word="force")
    regularisation: float = setting("m/s", 1e-3)

    def force(self, u: Any, v: Any, t: Any = 0.0) -> Any:
        """Return F v / sqrt(v^2 + v0^2) (N)."""
        return self.friction * v / (v * v + self.regularisation * self.regularisation) ** 0.5

    @property
    def largest_slopes(self) -> tuple[float, float]:
        """The dashpot F / v0 that it is at rest."""
        return 0.0, self.friction / self.regularisation

    def faults(self, structure: "Structure") -> list[str]:
        """Return faults; a negative force would feed energy in."""
        faults = super().faults(structure) + negative_faults(force=self.friction)
        if self.regularisation <= 0:
            faults.append(f"regularisation = {self.regularisation}; must be positive, about 1 % of usual velocities")
        return faults


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

    def faults(self, structure: "Structure") -> list[str]:
        """Return faults of the place and of the parameters."""
        faults = super().faults(structure) + negative_faults(gap=self.gap, stiffness=self.stiffness)
        return faults if self.side in (1, -1) else [*faults, f"side = {self.side}; must be 1 or -1"]
