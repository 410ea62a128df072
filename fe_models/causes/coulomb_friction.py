"""Dry friction."""

from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

import numpy as np

from fe_models.causes.base import negative_faults, parameter, setting
from fe_models.causes.candidate import FIRST_ORDER_STEP, LawCandidate
from fe_models.causes.connector import ConnectorEffect, law_at
from fe_models.causes.known import Known
from fe_models.causes.places import MovingPlace
from fe_models.one_node import node_or_nodes
from fe_models.structure import Structure

# of the rms rate at its place: below it friction is a dashpot; at least (less would need
# steps finer than a search can afford), usual, at most
CREEP_SHARES = (0.005, 0.01, 0.1)
PRIOR_STD_SHARE = 0.3  # of a usual dashpot's force: the usual friction


@node_or_nodes
@dataclass(frozen=True)
class CoulombFriction(ConnectorEffect):
    """Dry friction: force = F v / sqrt(v^2 + v0^2), which tends to F sign(v).

    The ``regularisation`` v0 (m/s) takes the place of sticking: at |v| = v0 the force is 0.71 F, at 7 v0 99 % of F, and
    a body that would stick creeps against a dashpot F / v0. Choose about 1 % of the velocities that matter; smaller
    ones need smaller steps.
    """

    kind: ClassVar[str] = "coulomb_friction"
    template: ClassVar[str] = "dry friction of {force} acts {at}"
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

    @classmethod
    def candidates(cls, known: Known) -> list[LawCandidate]:
        """Return friction at each place that moves; how softly it sets in is searched for, too."""
        return [_friction_at(moving) for moving in known.moving_places]


def _friction_at(moving: MovingPlace) -> LawCandidate:
    place, rate = moving.place, moving.speed
    rubbing, (least, usual, most) = PRIOR_STD_SHARE * place.coefficient * rate, (share * rate for share in CREEP_SHARES)
    return law_at(
        place,
        ("force", "regularisation"),
        partial(CoulombFriction, *place.at),
        width=(rubbing, usual),
        lower=(0.0, least),
        upper=(np.inf, most),
        neutral=(0.0, usual),
        starts=((FIRST_ORDER_STEP * rubbing, usual),),
    )
