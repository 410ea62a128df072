"""A mass that the model does not know of."""

from dataclasses import dataclass, replace
from functools import partial
from typing import ClassVar

import numpy as np

from fe_models.arrays import IntArray
from fe_models.causes.base import Part, node_faults, parameter
from fe_models.causes.candidate import ChangeCandidate
from fe_models.causes.known import Known, ModelForCauses
from fe_models.causes.searched import Searched
from fe_models.structure import TRANSLATIONS, PointMass, Structure

PRIOR_STD_SHARE_OF_MEAN = 0.5  # of a chain's mean mass: the prior standard deviation of an added one
PRIOR_STD_SHARE_OF_WHOLE = 0.05  # of a frame's whole mass: the same
MAX_REMOVED_SHARE = 0.95  # of what a node weighs: as much may be missing there


@dataclass(frozen=True)
class AddedMass(Searched, Part):
    """A mass (kg; negative: removed) at a node, felt by its translations: M_ii += mass."""

    kind: ClassVar[str] = "added_mass"
    template: ClassVar[str] = "{place} carries {mass} more than the model has"
    negative_template: ClassVar[str] = "{place} carries {mass} less than the model has"
    node: int
    mass: float = parameter("kg")

    def extend(self, structure: Structure) -> Structure:
        """Return the structure with the mass."""
        return replace(structure, point_masses=(*structure.point_masses, PointMass(self.node, self.mass)))

    def faults(self, structure: Structure) -> list[str]:
        """Return faults of the node and of the mass."""
        return node_faults(structure, (self.node,)) + self.number_faults()

    @classmethod
    def candidates(cls, known: Known) -> list[ChangeCandidate]:
        """Return a mass at each node that moves."""
        nominal, nothing = known.nominal, known.zeros
        masses = _masses(nominal)
        if nominal.is_chain:
            width = PRIOR_STD_SHARE_OF_MEAN * float(np.mean(list(masses.values())))
        else:
            width = PRIOR_STD_SHARE_OF_WHOLE * sum(masses.values())
        return [
            ChangeCandidate(
                kind=cls.kind,
                location={"node": node},
                names=("mass",),
                build=partial(cls, node),
                neutral=(0.0,),
                width=(width,),
                lower=(-MAX_REMOVED_SHARE * mass,),
                changes=(known.diagonal(_translations(nominal, node)), nothing, nothing),
            )
            for node, mass in masses.items()
        ]


def _masses(nominal: ModelForCauses) -> dict[int, float]:
    """Return what each node weighs, kg, in the direction in which it moves most; none of nodes that do not move."""
    dofs, diagonal, shapes = nominal.dofs, nominal.mass.diagonal(), nominal.modes[1]
    masses: dict[int, float] = {}
    for node in range(1, len(nominal.structure.nodes) + 1):
        rows = _translations(nominal, node)
        if len(rows):
            row = int(rows[np.argmax(np.abs(shapes[rows]).max(axis=1))])
            if dofs.free[row] and diagonal[row] > 0:
                masses[node] = float(diagonal[row])
    return masses


def _translations(nominal: ModelForCauses, node: int) -> IntArray:
    return np.flatnonzero((nominal.dofs.node == node) & np.isin(nominal.dofs.direction, TRANSLATIONS))
