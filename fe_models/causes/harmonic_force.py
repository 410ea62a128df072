"""A harmonic force: a motor, a walking person, a shaker that nobody switched off."""

from dataclasses import dataclass
from functools import partial
from math import pi
from typing import Any, ClassVar

from fe_models.causes.arithmetic import sine
from fe_models.causes.base import Effect, node_faults, parameter
from fe_models.causes.candidate import HarmonicCandidate
from fe_models.causes.force_law import MemorylessLaw
from fe_models.causes.known import Known
from fe_models.causes.searched import Searched
from fe_models.structure import Direction, Structure


@dataclass(frozen=True)
class HarmonicForce(Searched, Effect, MemorylessLaw):
    """A force on a node in one direction: F(t) = amplitude sin(2 pi frequency t + phase), t from the motion's start.

    ``phase`` (rad) is therefore one recording's own; a source that runs through several has another in each.
    """

    kind: ClassVar[str] = "harmonic_force"
    template: ClassVar[str] = "a harmonic force of {amplitude} at {frequency} acts {at}: look for a machine"
    timed: ClassVar[bool] = True
    node: int
    direction: Direction
    amplitude: float = parameter("N", "N m")
    frequency: float = parameter("Hz")
    phase: float = parameter("rad", default=0.0)

    @property
    def pulls(self) -> tuple[tuple[int, Direction, float], ...]:
        """The node's degree of freedom."""
        return ((self.node, self.direction, 1.0),)

    def force(self, u: Any, v: Any, t: Any = 0.0) -> Any:
        """Return -F(t) (N), as a restoring force; it depends on neither ``u`` nor ``v``."""
        return -self.amplitude * sine(2 * pi * self.frequency * t + self.phase)

    def law(self, structure: Structure) -> MemorylessLaw:
        """Return the force itself."""
        return self

    def faults(self, structure: Structure) -> list[str]:
        """Return faults of the place and of the parameters."""
        faults = node_faults(structure, (self.node,), self.direction) + self.number_faults()
        return faults if self.frequency > 0 else [*faults, f"frequency = {self.frequency} Hz; must be positive"]

    @classmethod
    def candidates(cls, known: Known) -> list[HarmonicCandidate]:
        """Return one at each place against the ground; amplitude and phase are each recording's own.

        It turns once in a recording at least: a slower one would be any constant force or drift.
        """
        return [
            HarmonicCandidate(
                kind=cls.kind,
                location=place.location,
                names=("frequency",),
                build=partial(cls, place.nodes[0], place.direction, 1.0),
                neutral=(0.0,),
                width=(known.nominal.highest,),
                lower=(known.slowest,),
                pull=place.pull,
                twins=place.twins,
            )
            for place in known.places
            if len(place.nodes) == 1
        ]
