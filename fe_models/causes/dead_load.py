"""What a structure's own weight and prestress do to small motions: P-delta."""

from dataclasses import dataclass
from typing import ClassVar

from fe_models.causes.base import Effect, parameter
from fe_models.structure import Structure


@dataclass(frozen=True)
class DeadLoad(Effect):
    """Small motions are about the state at rest under weight and prestress, not about the drawn geometry.

    K -> K + share (K_rest - K), K_rest the tangent at rest: see `fe_models.dead_load`. With a ``share`` of one it acts
    as the drawn masses and prestress have it; the shares of several add up. It gets no damping. A simulation under
    gravity has it by itself.
    """

    kind: ClassVar[str] = "dead_load"
    share: float = parameter("1", default=1.0)

    def faults(self, structure: Structure) -> list[str]:
        """Return a fault where the structure cannot sink, or the share is no number of times its weight."""
        faults = self.number_faults()
        if not faults and self.share < 0:
            faults.append(f"share = {self.share}; must not be negative (1 is the weight as drawn)")
        if not {"x", "y"} <= set(structure.directions):
            moves = ", ".join(structure.directions)
            faults.append(f"nodes move in {moves} only; weight changes small motions where they move in x and y")
        return faults


def dead_load_share(structure: Structure) -> float:
    """Return the sum of the shares of dead load that effects bring to small motions, 0 without any."""
    return sum((effect.share for effect in structure.effects if isinstance(effect, DeadLoad)), 0.0)
