"""A stop that is met beyond a gap."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np

from fe_models.causes.arithmetic import SMOOTHING, smooth_ramp
from fe_models.causes.base import Cause, negative_faults, parameter
from fe_models.causes.candidate import FIRST_ORDER_STEP, LawCandidate
from fe_models.causes.connector import ConnectorEffect, law_at
from fe_models.causes.known import Known
from fe_models.causes.places import LARGEST_QUANTILE, MIN_ELONGATION_SHARE, STARTING_SHARES, MovingPlace, Place
from fe_models.causes.wording import sentence
from fe_models.one_node import node_or_nodes
from fe_models.structure import Structure

SIDES: tuple[Literal[1, -1], ...] = (1, -1)


@node_or_nodes
@dataclass(frozen=True)
class GapStop(ConnectorEffect):
    """A spring that is met only beyond a gap, on one side: force = side stiffness max(side u - gap, 0).

    ``side`` +1 stops motion in the direction, -1 motion against it. Contact sets in smoothly within 1 % of the gap
    (`arithmetic.smooth_ramp`), so that the force has a slope everywhere; without a gap it has a kink at rest.
    """

    kind: ClassVar[str] = "gap_stop"
    template: ClassVar[str] = "a stop of {stiffness} acts {at} beyond a gap of {gap} that closes as {closing}"
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

    def faults(self, structure: Structure) -> list[str]:
        """Return faults of the place and of the parameters."""
        faults = super().faults(structure) + negative_faults(gap=self.gap, stiffness=self.stiffness)
        return faults if self.side in (1, -1) else [*faults, f"side = {self.side}; must be 1 or -1"]

    @classmethod
    def candidates(cls, known: Known) -> list[LawCandidate]:
        """Return a stop on either side of each place that moves, at several gaps."""
        return [_stop_at(moving, side) for moving in known.moving_places for side in SIDES]

    def sentence(self, values: Mapping[str, str], structure: Structure) -> str:
        """Return the sentence, with the motion that meets the stop."""
        against = "" if len(self.nodes) == 1 else f" against node {self.nodes[0]}"
        closing = f"node {self.nodes[-1]} moves in {'+' if self.side > 0 else '-'}{self.direction}{against}"
        return sentence(self.template, self.location, closing=closing, **values)


def _stop_at(moving: MovingPlace, side: Literal[1, -1]) -> LawCandidate:
    place, size = moving.place, moving.size
    farthest = max(float(np.quantile(side * moving.elongation, LARGEST_QUANTILE)), MIN_ELONGATION_SHARE * size)
    return law_at(
        place,
        ("stiffness", "gap"),
        _stop(place, side),
        width=(place.stiffness, size),
        lower=(0.0, MIN_ELONGATION_SHARE * size),
        starts=tuple((FIRST_ORDER_STEP * place.stiffness, reach * farthest) for reach in STARTING_SHARES),
        side=side,
    )


def _stop(place: Place, side: Literal[1, -1]) -> Callable[..., Cause]:
    return lambda stiffness, gap: GapStop(place.nodes, place.direction, gap, stiffness, side)
