"""Damping ratios of single modes that differ from the model's."""

from dataclasses import dataclass
from functools import partial
from typing import ClassVar

from fe_models.causes.base import Effect, count_faults, parameter, value_of
from fe_models.causes.candidate import ModeCandidate
from fe_models.causes.known import Known
from fe_models.causes.searched import Searched
from fe_models.structure import Structure

PRIOR_STD = 0.05  # the prior standard deviation of a damping ratio
MAX_RATIO = 0.99  # an effect's ratio is below one


@dataclass(frozen=True)
class ModalDamping(Searched, Effect):
    """Modes (numbered from 1, of the structure with all its linear effects) whose damping ratio is ``ratio``.

    C -> C + sum of 2 omega_i (ratio_i - xi_i) M phi_i phi_i^T M over these modes, xi_i = phi_i^T C phi_i / (2 omega_i)
    what they have without the effect: all other modes keep their damping. ``ratio`` is one for all, or one for each.
    """

    kind: ClassVar[str] = "modal_damping"
    template: ClassVar[str] = "{place} is damped with a ratio of {ratio}"
    modes: tuple[int, ...]
    ratio: float | tuple[float, ...] = parameter("1")

    @property
    def ratios(self) -> tuple[tuple[int, float], ...]:
        """Each mode's number and ratio."""
        return tuple((mode, value_of(self.ratio, position)) for position, mode in enumerate(self.modes))

    def faults(self, structure: Structure) -> list[str]:
        """Return faults of the modes and the ratios."""
        faults = [] if self.modes else ["modes: there are none; give their numbers, from 1"]
        faults += [f"mode {mode} does not exist; modes are numbered from 1" for mode in self.modes if mode < 1]
        if len(set(self.modes)) < len(self.modes):
            faults.append(f"modes = {list(self.modes)}: give each mode once")
        faults += count_faults("ratio", self.ratio, self.modes)
        ratios = self.ratio if isinstance(self.ratio, tuple) else (self.ratio,)
        faults += [f"ratio = {ratio}; expected 0 <= ratio < 1 (0.01 is 1 %)" for ratio in ratios if not 0 <= ratio < 1]
        return faults

    @classmethod
    def candidates(cls, known: Known) -> list[ModeCandidate]:
        """Return another ratio of each mode that recordings can show."""
        return [
            ModeCandidate(
                kind=cls.kind,
                location={"modes": [mode + 1]},
                names=("ratio",),
                build=partial(cls, (mode + 1,)),
                neutral=(float(ratio),),
                width=(PRIOR_STD,),
                lower=(0.0,),
                upper=(max(MAX_RATIO, float(ratio)),),
                mode=mode,
            )
            for mode, ratio in enumerate(known.nominal.own_ratios[: known.nominal.below])
        ]


def replaced_ratios(structure: Structure) -> tuple[tuple[int, float], ...]:
    """Return number and damping ratio of each mode that has its own; of two for one mode the later."""
    return tuple(sorted({m: r for e in structure.effects if isinstance(e, ModalDamping) for m, r in e.ratios}.items()))
