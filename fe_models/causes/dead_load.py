"""What a structure's own weight and prestress do to small motions: P-delta."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from fe_models.causes.base import Effect, parameter
from fe_models.causes.candidate import ChangeCandidate
from fe_models.causes.known import Known
from fe_models.causes.searched import Searched
from fe_models.errors import InputError
from fe_models.structure import Structure

MIN_FREQUENCY_CHANGE = 1e-4  # of squared frequencies: a dead load that changes none by more is not felt
# times what is drawn: no less weight than that, and no more, goes unnoticed
MIN_WEIGHT_FACTOR, MAX_WEIGHT_FACTOR = 0.5, 1.5


@dataclass(frozen=True)
class DeadLoad(Searched, Effect):
    """Small motions are about the state at rest under weight and prestress, not about the drawn geometry.

    K -> K + share (K_rest - K), K_rest the tangent at rest: see `fe_models.dead_load`. With a ``share`` of one it acts
    as the drawn masses and prestress have it; the shares of several add up. It gets no damping. A simulation under
    gravity has it by itself.
    """

    kind: ClassVar[str] = "dead_load"
    template: ClassVar[str] = (
        "the structure feels its own weight and prestress (P-delta), {share} times what is drawn; the model's natural"
        " modes leave them out"
    )
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

    @classmethod
    def candidates(cls, known: Known) -> list[ChangeCandidate]:
        """Return the weight as drawn; none where that is not felt, or nothing would stand."""
        effect, nominal = cls(), known.nominal
        if effect.faults(nominal.structure) or dead_load_share(nominal.structure):
            return []
        omega, _ = nominal.modes
        try:
            changes, loaded = nominal.changes_of(effect), nominal.frequencies_with(effect)
        except InputError:  # no state at rest, or none that stands
            return []
        # All modes give way to it, as a roller does.
        if np.all(np.abs(loaded**2 - omega**2) < MIN_FREQUENCY_CHANGE * omega**2):
            return []
        return [
            ChangeCandidate(
                kind=cls.kind,
                location=effect.location,
                names=("share",),
                build=cls,
                neutral=(0.0,),
                width=(1.0,),
                lower=(MIN_WEIGHT_FACTOR,),
                upper=(MAX_WEIGHT_FACTOR,),
                changes=changes,
            )
        ]


def dead_load_share(structure: Structure) -> float:
    """Return the sum of the shares of dead load that effects bring to small motions, 0 without any."""
    return sum((effect.share for effect in structure.effects if isinstance(effect, DeadLoad)), 0.0)
