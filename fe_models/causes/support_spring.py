"""A spring to the ground: a restraint that the model lacks, or a support that is too soft."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import ClassVar, cast

import numpy as np
from scipy.sparse import csr_array

from fe_models.causes.base import Cause, Part, negative_faults, node_faults, parameter
from fe_models.causes.candidate import ChangeCandidate, SupportCandidate
from fe_models.causes.known import Known, ModelForCauses, outer
from fe_models.causes.places import Place
from fe_models.causes.searched import Searched
from fe_models.causes.wording import sentence
from fe_models.structure import Direction, Spring, Structure, Support

SOFT_SUPPORT_TEMPLATE = "{place} is held by {stiffness} only, where the model holds it rigidly"
PRIOR_STD_SHARE = 0.5  # of what is felt at a place: the prior standard deviation of a spring's stiffness
SCANNED_SIGMAS = (-20.0, -5.0, 5.0, 20.0)  # prior standard deviations: as far as a scan looks for a spring
# how probable a spring to the ground is beside one that the structure has: that one would be off instead
PARALLEL_SPRING_WEIGHT = 0.1
MIN_COMPLIANCE_SHARE = 1e-4  # of a structure's own compliance at a support: as good as rigid
# of it: the prior standard deviation of a support's own; at ten times as much it is as good as lost
PRIOR_STD_COMPLIANCE_SHARE = 5.0
# of a structure's own compliance: what a scan tries below the prior standard deviation, as a support that is but a
# little soft changes modes much more than they err, and one that is softer than the structure is as good as lost
SCANNED_COMPLIANCE_SHARES = (0.003, 0.01, 0.03)
# of the stiffness at a support: what rounding leaves of a structure's own where nothing else holds it
MIN_STIFFNESS_SHARE = 1e-9


@dataclass(frozen=True)
class SupportSpring(Searched, Part):
    """A spring between a node and the ground: K_ii += stiffness.

    Where a support holds the node in that direction, the spring takes the support's place (a support too soft; 0:
    lost). Elsewhere it is a restraint that the model lacks, or, negative, takes something from one that it has.
    """

    kind: ClassVar[str] = "support_spring"
    template: ClassVar[str] = "{place} is held by {stiffness} that the model lacks"
    negative_template: ClassVar[str] = "{place} is held by {stiffness} less than in the model"
    node: int
    direction: Direction
    stiffness: float = parameter("N/m", "N m/rad")

    def extend(self, structure: Structure) -> Structure:
        """Return the structure with the spring, and without the support in its direction."""
        supports = []
        for support in structure.supports:
            if support.node == self.node:
                kept = tuple(direction for direction in support.directions if direction != self.direction)
                support = Support(support.node, kept)
            if support.directions:
                supports.append(support)
        spring = Spring((self.node,), self.direction, self.stiffness, group=self.kind)
        return replace(structure, elements=(*structure.elements, spring), supports=tuple(supports))

    def faults(self, structure: Structure) -> list[str]:
        """Return faults of the place and of the stiffness."""
        faults = node_faults(structure, (self.node,), self.direction) + self.number_faults()
        return faults + (negative_faults(stiffness=self.stiffness) if self.is_support_of(structure) else [])

    @classmethod
    def candidates(cls, known: Known) -> list[ChangeCandidate | SupportCandidate]:
        """Return a spring at each place against the ground, supports that give way, and those that resist rotation."""
        springs = [_spring_at(place, known) for place in known.places if len(place.nodes) == 1]
        return [*springs, *_soft_supports(known), *_stiff_pins(known)]

    def sentence(self, values: Mapping[str, str], structure: Structure) -> str:
        """Return the sentence: of a support that is too soft, or of a spring that the model lacks."""
        if self.is_support_of(structure):
            return sentence(SOFT_SUPPORT_TEMPLATE, self.location, **values)
        return super().sentence(values, structure)

    def is_support_of(self, structure: Structure) -> bool:
        """Return whether it takes the place of a support of a structure."""
        return any(s.node == self.node and self.direction in s.directions for s in structure.supports)


def _spring_at(place: Place, known: Known, lower: float = -np.inf) -> ChangeCandidate:
    """Return a spring to the ground at a place, of a stiffness of ``lower`` at least."""
    structure, spring, own = known.nominal.structure, outer(place.pull), (*place.nodes, place.direction)
    drawn = [(*e.nodes, e.direction) for e in structure.elements if isinstance(e, Spring)]
    width = PRIOR_STD_SHARE * place.stiffness
    return ChangeCandidate(
        kind=SupportSpring.kind,
        location=place.location,
        names=("stiffness",),
        build=partial(SupportSpring, place.nodes[0], place.direction),
        neutral=(0.0,),
        width=(width,),
        lower=(lower,),
        far=tuple(size * width for size in SCANNED_SIGMAS),
        changes=(known.zeros, csr_array(structure.damping.stiffness_factor * spring), spring),
        twins=place.twins,
        weight=PARALLEL_SPRING_WEIGHT if own in drawn else 1.0,
    )


def _soft_supports(known: Known) -> list[SupportCandidate]:
    """Return the supports that may be too soft, each by its compliance: 0 as drawn."""
    found, nominal = [], known.nominal
    leaned_on = nominal.stiffness.diagonal() > 0  # a cable's end does not lean on what holds it from turning
    for row in np.flatnonzero(~nominal.dofs.free & leaned_on):
        node, direction = int(nominal.dofs.node[row]), cast(Direction, str(nominal.dofs.direction[row]))
        soft = _softness(nominal, int(row))
        here = known.diagonal(np.array([row]))
        damped = csr_array(nominal.structure.damping.stiffness_factor * here)  # as all that is stiff
        found.append(
            SupportCandidate(
                kind=SupportSpring.kind,
                location={"node": node, "direction": direction},
                names=("stiffness",),
                build=_by_compliance(node, direction),
                neutral=(0.0,),
                width=(PRIOR_STD_COMPLIANCE_SHARE * soft,),
                lower=(MIN_COMPLIANCE_SHARE * soft,),
                starts=((10 * MIN_COMPLIANCE_SHARE * soft,),),
                far=tuple(share * soft for share in SCANNED_COMPLIANCE_SHARES),
                changes=(known.zeros, damped, here),
                row=int(row),
                brings=1,
            )
        )
    return found


def _stiff_pins(known: Known) -> list[ChangeCandidate]:
    """Return the supports that may resist rotation, though they are drawn to turn freely: base plates, rusty pins."""
    nominal, dofs = known.nominal, known.nominal.dofs
    supported = [support.node for support in nominal.structure.supports]
    turning = dofs.free & (dofs.direction == "rz") & np.isin(dofs.node, supported)
    springs = [e for e in nominal.structure.effects if isinstance(e, SupportSpring)]
    found = []
    for row in np.flatnonzero(turning & (nominal.stiffness.diagonal() > 0)):
        node, pull = int(dofs.node[row]), np.zeros(len(dofs))
        pull[row] = 1.0
        stiffness = 1 / float(nominal.static(pull[:, None])[row, 0])
        place = Place({"node": node, "direction": "rz"}, (node,), "rz", pull, stiffness, coefficient=0.0)
        own = sum(e.stiffness for e in springs if (e.node, e.direction) == (node, "rz"))
        found.append(_spring_at(place, known, lower=-own))  # a pin turns freely, or resists as drawn
    return found


def _softness(nominal: ModelForCauses, row: int) -> float:
    """Return the compliance (m/N, rad/(N m)) of a structure where a support gives, by which to size the support's own.

    What stands on this support alone has none, as a mast: then that at which it rocks as slowly as it sways.
    """
    shape = nominal.released(row)
    stiffness = float(shape @ (nominal.stiffness @ shape))
    if stiffness < MIN_STIFFNESS_SHARE * float(nominal.stiffness[row, row]):
        stiffness = float(nominal.modes[0][0] ** 2 * (shape @ (nominal.mass @ shape)))
    return 1 / stiffness


def _by_compliance(node: int, direction: Direction) -> Callable[..., Cause]:
    return lambda compliance: SupportSpring(node, direction, 1 / compliance)
