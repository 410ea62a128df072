"""Force laws between a node and the ground, or between two nodes, in one direction."""

from collections.abc import Callable
from dataclasses import dataclass

from fe_models.causes.base import Cause, Effect, node_faults
from fe_models.causes.candidate import LawCandidate
from fe_models.causes.force_law import ForceLaw, MemorylessLaw
from fe_models.causes.places import Place
from fe_models.causes.searched import Searched
from fe_models.structure import Direction, Structure


@dataclass(frozen=True)
class Connector(Searched, Effect, ForceLaw):
    """A force between a node and the ground, or between two nodes, in one direction.

    It follows from the elongation u = u_last - u_first (or u of the only node), measured from the state at rest, and
    pulls the last node back and the first one forth.
    """

    nodes: tuple[int] | tuple[int, int]
    direction: Direction

    @property
    def pulls(self) -> tuple[tuple[int, Direction, float], ...]:
        """The last node with 1, the first of two with -1."""
        last: tuple[tuple[int, Direction, float], ...] = ((self.nodes[-1], self.direction, 1.0),)
        return last if len(self.nodes) == 1 else ((self.nodes[0], self.direction, -1.0), *last)

    def law(self, structure: Structure) -> ForceLaw:
        """Return the connector itself."""
        return self

    def faults(self, structure: Structure) -> list[str]:
        """Return faults of the place and of the parameters."""
        return node_faults(structure, self.nodes, self.direction) + self.number_faults()


@dataclass(frozen=True)
class ConnectorEffect(Connector, MemorylessLaw):
    """A connector whose elongation and rate v give the `force`."""


def law_at(
    place: Place,
    names: tuple[str, ...],
    build: Callable[..., Cause],
    *,
    width: tuple[float, ...],
    lower: tuple[float, ...],
    upper: tuple[float, ...] = (),
    neutral: tuple[float, ...] = (),
    starts: tuple[tuple[float, ...], ...] = (),
    **more: int,
) -> LawCandidate:
    """Return a force law at a place, see `Candidate`; ``more``: what distinguishes two of a kind there."""
    return LawCandidate(
        kind=build(*width).kind,
        location=place.location | more,
        names=names,
        build=build,
        neutral=neutral or (0.0,) * len(names),
        width=width,
        lower=lower,
        upper=upper,
        starts=starts,
        pull=place.pull,
        twins=tuple(twin | more for twin in place.twins),
    )
