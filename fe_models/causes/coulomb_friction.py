"""Dry friction."""

from dataclasses import dataclass
from typing import Any, ClassVar

from fe_models.causes.base import negative_faults, parameter, setting
from fe_models.causes.connector import ConnectorEffect
from fe_models.one_node import node_or_nodes
from fe_models.structure import Structure


@node_or_nodes
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

    def faults(self, structure: Structure) -> list[str]:
        """Return faults; a negative force would feed energy in."""
        faults = super().faults(structure) + negative_faults(force=self.friction)
        if self.regularisation <= 0:
            faults.append(f"regularisation = {self.regularisation}; must be positive, about 1 % of usual velocities")
        return faults
