"""A cable, or spring, that the model takes as a taut bar and that goes slack."""

from dataclasses import dataclass, replace
from functools import partial
from math import hypot
from typing import Any, ClassVar

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes.arithmetic import SMOOTHING, smooth_ramp
from fe_models.causes.base import Effect, element_faults, negative_faults, parameter
from fe_models.causes.candidate import LawCandidate
from fe_models.causes.force_law import MemorylessLaw
from fe_models.causes.known import Known
from fe_models.causes.places import LARGEST_QUANTILE, MIN_ELONGATION_SHARE, STARTING_SHARES
from fe_models.causes.searched import Searched
from fe_models.structure import Beam, Cable, Direction, Spring, Structure

MIN_PRETENSION_SHARE = 0.8  # of the pretension with which a cable never goes slack


@dataclass(frozen=True)
class SlackCable(Searched, Effect):
    """An element that carries ``pretension`` N0 at rest and no force once it is shortened beyond N0 / k.

    Its force is N0 + k u while taut, k its axial stiffness (E A / L of a cable), u its elongation from rest. The linear
    model has k u; what comes on top is -(N0 + k u) where that force would be compression: `SlackLaw`. In a nonlinear
    simulation it stands for the cable's own rule of slackness.
    """

    kind: ClassVar[str] = "slack_cable"
    template: ClassVar[str] = "{place} goes slack when its compression exceeds a pretension of {pretension}"
    element: int
    pretension: float = parameter("N")

    def extend(self, structure: Structure) -> Structure:
        """Return the structure with the cable as a bar, whose slackness the law then describes."""
        element = structure.elements[self.element - 1]
        if not isinstance(element, Cable):
            return structure
        elements = list(structure.elements)
        elements[self.element - 1] = replace(element, tension_only=False)
        return replace(structure, elements=tuple(elements))

    def law(self, structure: Structure) -> "SlackLaw | None":
        """Return the force on top of the bar's; None of an element that has lost its stiffness."""
        element = structure.elements[self.element - 1]
        assert not isinstance(element, Beam)  # see `faults`
        if isinstance(element, Spring):
            law = SlackLaw(element, (0.0, 0.0), element.stiffness, self.pretension)
        else:
            (x1, y1), (x2, y2) = (structure.nodes[node - 1] for node in element.nodes)
            vector = (x2 - x1, y2 - y1)
            law = SlackLaw(element, vector, element.section.axial_stiffness / hypot(*vector), self.pretension)
        return law if law.stiffness > 0 else None

    def faults(self, structure: Structure) -> list[str]:
        """Return faults of the element and the pretension."""
        faults = element_faults(structure, (self.element,)) + self.number_faults()
        faults += negative_faults(pretension=self.pretension)
        if not faults and isinstance(structure.elements[self.element - 1], Beam):
            faults.append(f"element {self.element} is a beam; expected a cable or a spring")
        return faults

    @classmethod
    def candidates(cls, known: Known) -> list[LawCandidate]:
        """Return each cable, or spring, that may go slack and whose elongation is felt."""
        found, nominal = [], known.nominal
        for number in range(1, len(nominal.structure.elements) + 1):
            effect = cls(number, 1.0)
            law = None if effect.faults(nominal.structure) else effect.law(nominal.built)
            if law is not None:
                pull = nominal.pull(law)
                u = known.motion.displacement @ pull
                if np.std(u) > known.least_elongation:
                    found.append(_slack_at(number, law.stiffness, pull, u, known.part_of((number,))))
        return found


@dataclass(frozen=True)
class SlackLaw(MemorylessLaw):
    """What slackness adds to a bar: force = stiffness ramp(-u - N0 / stiffness), pushing the nodes apart again.

    ``vector`` (m) leads along a cable. Contact with slackness sets in smoothly within 1 % of N0 / stiffness.
    """

    kind: ClassVar[str] = SlackCable.kind
    element: Cable | Spring
    vector: tuple[float, float]
    stiffness: float
    pretension: float

    @property
    def pulls(self) -> tuple[tuple[int, Direction, float], ...]:
        """The elongation of the element, linearised: along a spring's direction or a cable's line."""
        nodes = self.element.nodes
        if isinstance(self.element, Spring):
            along: tuple[tuple[Direction, float], ...] = ((self.element.direction, 1.0),)
        else:
            length = hypot(*self.vector)
            along = (("x", self.vector[0] / length), ("y", self.vector[1] / length))
        ends = ((nodes[0], -1.0), (nodes[-1], 1.0))[-len(nodes) :]
        return tuple((node, direction, sign * c) for node, sign in ends for direction, c in along if c)

    def force(self, u: Any, v: Any, t: Any = 0.0) -> Any:
        """Return stiffness * ramp(-u - N0 / stiffness) (N), which takes back the compression of the bar."""
        play = self.pretension / self.stiffness
        return self.stiffness * smooth_ramp(-u - play, SMOOTHING * play)

    def with_stiffness(self, factor: Any) -> "SlackLaw":
        """Return the law of an element ``factor`` times as stiff, with the same pretension."""
        return replace(self, stiffness=factor * self.stiffness)

    @property
    def largest_slopes(self) -> tuple[float, float]:
        """The stiffness that it takes away."""
        return self.stiffness, 0.0


def _slack_at(number: int, stiffness: float, pull: FloatArray, u: FloatArray, part: int | None) -> LawCandidate:
    """Return an element, by its number, that may go slack in a motion with its elongation ``u`` (m)."""
    most = max(float(np.quantile(-u, LARGEST_QUANTILE)), MIN_ELONGATION_SHARE * float(np.std(u))) * stiffness
    taut = 2.0 * most  # never slack
    return LawCandidate(
        kind=SlackCable.kind,
        location={"element": number},
        names=("pretension",),
        build=partial(SlackCable, number),
        neutral=(taut,),
        width=(most,),
        lower=(MIN_ELONGATION_SHARE * most,),
        starts=tuple((reach * most,) for reach in STARTING_SHARES),
        scalable=False,
        negligible=(MIN_PRETENSION_SHARE * taut,),
        pull=pull,
        part=part,
    )
