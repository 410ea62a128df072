"""A spring that slides: joints and roller supports do it."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.causes.base import Cause, parameter
from fe_models.causes.candidate import FIRST_ORDER_STEP, LawCandidate
from fe_models.causes.connector import Connector, law_at
from fe_models.causes.force_law import LawWithMemory
from fe_models.causes.known import Known
from fe_models.causes.places import MovingPlace, Place
from fe_models.one_node import node_or_nodes
from fe_models.structure import Structure

SHARPNESS = (0.5, 2.0, 10.0)  # at least, usual (smooth), at most: beyond it no recording tells a kink from another
# of the rms elongation at its place: how far it moves before it slides; less is dry friction, more a spring
REACH_SHARES = (0.02, 10.0)
STARTING_REACHES = (0.1, 0.5, 2.0)  # likewise, where a search begins
LEAST_FORCE = 1e-9  # of the usual one: none at all has no reach
TABLE_SIZE, TABLE_END = 801, 30.0  # the curve ends where exp(-30) of the force is left to come


@node_or_nodes
@dataclass(frozen=True)
class HystereticSpring(Connector, LawWithMemory):
    """The hysteretic spring of Bouc and Wen: f = k z, z' = v [1 - |k z / F|^n (1 + sign(v z)) / 2].

    k is its ``stiffness`` while motion is small, F the ``slip`` force at which it slides, n its ``sharpness``: 1 gives
    way smoothly, for large ones it is a spring and a slider in series (Jenkins' element), which takes the energy
    4 F (a - F / k) a cycle of amplitude a. It unloads with k. Bouc, "Forced vibration of mechanical systems with
    hysteresis", 1967; Wen, "Method for random vibration of hysteretic systems", J. Eng. Mech. Div. 102, 1976.
    """

    kind: ClassVar[str] = "hysteretic_spring"
    template: ClassVar[str] = "a spring of {stiffness} that slides at {force} (sharpness {sharpness}) acts {at}"
    stiffness: float = parameter("N/m", "N m/rad")
    slip: float = parameter("N", "N m", word="force")
    sharpness: float = parameter("1")

    @property
    def reach(self) -> float:
        """The elongation F / k (m) at which z ends."""
        return self.slip / self.stiffness

    @property
    def largest(self) -> float:
        """The reach."""
        return self.reach

    def rate(self, v: Any, z: Any) -> Any:
        """Return v [1 - |z / reach|^n (1 + sign(v z)) / 2] (m/s); none where a step has led beyond the reach."""
        return v - v * np.minimum(np.abs(z / self.reach), 1.0) ** self.sharpness * (v * z > 0)

    def force_of(self, z: Any) -> Any:
        """Return stiffness * z (N)."""
        return self.stiffness * z

    def pulled_to(self, u: Any) -> Any:
        """Return z (m) on the curve dz / du = 1 - |z / reach|^n from rest (`loading_curve`)."""
        from scipy.interpolate import CubicHermiteSpline  # only here: it takes long to load

        elongation, share = loading_curve(self.sharpness)
        curve = CubicHermiteSpline(elongation, share, 1 - share**self.sharpness)
        return np.sign(u) * self.reach * curve(np.minimum(np.abs(u) / self.reach, elongation[-1]))

    @property
    def largest_slopes(self) -> tuple[float, float]:
        """The stiffness while it does not slide."""
        return self.stiffness, 0.0

    def faults(self, structure: Structure) -> list[str]:
        """Return faults of the place and of the parameters."""
        faults = super().faults(structure)
        values = {"stiffness": self.stiffness, "force": self.slip, "sharpness": self.sharpness}
        faults += [f"{name} = {value}; must be positive" for name, value in values.items() if value <= 0]
        return faults

    @classmethod
    def candidates(cls, known: Known) -> list[LawCandidate]:
        """Return one at each place that moves, that slides early, now and then, or hardly."""
        return [_spring_at(moving) for moving in known.moving_places]


@lru_cache(maxsize=256)
def loading_curve(sharpness: float) -> tuple[FloatArray, FloatArray]:
    """Return the elongations x = u / reach (point,) of a slow pull from rest and y = z / reach there: dy/dx = 1 - y^n.

    By x = the integral of dy / (1 - y^n) with y = 1 - exp(-s^2), in which it is smooth at both ends.
    """
    from scipy.integrate import cumulative_simpson  # only here: it takes long to load

    s = np.linspace(0.0, np.sqrt(TABLE_END), TABLE_SIZE)
    share, left = -np.expm1(-(s**2)), np.exp(-(s**2))
    with np.errstate(divide="ignore"):  # at rest the logarithm is -inf, and nothing is lost of the slope
        slope = -np.expm1(sharpness * np.log1p(-left))
    elongation = cumulative_simpson(2 * s * left / slope, x=s, initial=0.0)
    return np.asarray(elongation), share


def _spring_at(moving: MovingPlace) -> LawCandidate:
    """Return the candidate of a place; its search goes by the force, the elongation at which that is nearly reached,
    and the sharpness: the first enters linearly, whatever the others are.
    """
    place, size = moving.place, moving.size
    (least, usual, most), (nearest, farthest) = SHARPNESS, REACH_SHARES
    force = place.stiffness * size
    return law_at(
        place,
        ("force", "stiffness", "sharpness"),
        _spring(place),
        width=(force, size, usual),
        lower=(LEAST_FORCE * force, nearest * size, least),
        upper=(np.inf, farthest * size, most),
        neutral=(0.0, size, usual),
        starts=tuple((FIRST_ORDER_STEP * force, share * size, usual) for share in STARTING_REACHES),
    )


def _spring(place: Place) -> Callable[..., Cause]:
    return lambda force, reach, sharpness: HystereticSpring(*place.at, force / reach, force, sharpness)
