"""Springs whose force grows with a power of their elongation."""

from abc import ABC
from dataclasses import dataclass
from functools import partial
from typing import ClassVar

from fe_models.causes.candidate import UNBOUNDED, LawCandidate
from fe_models.causes.connector import ConnectorEffect, law_at
from fe_models.causes.known import Known


@dataclass(frozen=True)
class PowerSpring(ConnectorEffect, ABC):
    """A spring without linear part: force = stiffness u^``power``; stiffness of either sign."""

    power: ClassVar[int]

    @classmethod
    def candidates(cls, known: Known) -> list[LawCandidate]:
        """Return one at each place that moves, as stiff at the usual elongation as what is there."""
        return [
            law_at(
                moving.place,
                ("stiffness",),
                partial(cls, *moving.place.at),
                width=(moving.place.stiffness / (cls.power * moving.size ** (cls.power - 1)),),
                lower=UNBOUNDED,
            )
            for moving in known.moving_places
        ]
