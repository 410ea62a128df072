"""The motion of all supports together: an earthquake, a shaking table.

Displacements u relative to the moving base obey M u'' + C u' + K u + f(u, u') = -M r a(t), where a is the acceleration
of the base and r how all degrees of freedom move when the base moves by one as a rigid body. An accelerometer shows
u'' + r a (Clough and Penzien, Dynamics of Structures, on excitation by support motion).
"""

from dataclasses import dataclass, replace
from math import cos, hypot, inf, isfinite, radians, sin
from typing import TYPE_CHECKING, Literal

import numpy as np
from scipy.sparse import csr_array

from fe_models.arrays import FloatArray
from fe_models.dof_map import DofMap
from fe_models.errors import InputError
from fe_models.interpolant import Course, interpolant
from fe_models.structure import TRANSLATIONS

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

BaseDirection = Literal["x", "y", "z"] | float | tuple[float, ...]
"""Along an axis, at an angle (degrees) from x towards y, or along a vector (dx, dy), or (dx, dy, dz), of any length."""


Along = tuple[float, float] | tuple[float, float, float]
"""A vector of length one, of three components where it has a part along z."""


@dataclass(frozen=True, repr=False)
class BaseMotion:
    """The acceleration (m/s^2) of all supports together along one ``direction``; ``values`` (time,), one a sample.

    ``begun``: the velocity and displacement that it begins with, in m/s^2 times sampling intervals, once and twice:
    zero but of a `part` of a longer motion.
    """

    direction: BaseDirection
    values: FloatArray
    begun: tuple[float, float] = (0.0, 0.0)

    def __repr__(self) -> str:
        return f"BaseMotion(along {self.direction}, {len(self.values)} samples)"

    @property
    def along(self) -> Along:
        """The direction as a vector (dx, dy), or (dx, dy, dz), of length one."""
        return unit_vector(self.direction)

    def integrals(self, course: Course = "smooth") -> "tuple[BSpline, BSpline]":
        """Return velocity and displacement as functions of time in sampling intervals, in units of ``begun``."""
        velocity = interpolant(self.values, course=course).antiderivative()
        velocity.c = velocity.c + self.begun[0]  # the basis of a spline adds up to one
        displacement = velocity.antiderivative()
        displacement.c = displacement.c + self.begun[1]
        return velocity, displacement

    def part(self, begin: int, end: int | None, course: Course = "smooth") -> "BaseMotion":
        """Return the samples from ``begin`` to before ``end`` of a motion that takes this ``course`` between them."""
        velocity, displacement = self.integrals(course)
        begun = float(velocity(begin)), float(displacement(begin))
        return replace(self, values=self.values[begin:end], begun=begun)


def unit_vector(direction: object) -> Along:
    """Return a direction as a vector (dx, dy) of length one, (dx, dy, dz) where it has a part along z.

    `InputError` where it is none.
    """
    match direction:
        case "x":
            return 1.0, 0.0
        case "y":
            return 0.0, 1.0
        case int() | float() if isfinite(direction):
            return cos(radians(direction)), sin(radians(direction))
        case (int() | float() as x, int() | float() as y) if 0 < hypot(x, y) < inf:
            return x / hypot(x, y), y / hypot(x, y)
        case "z":
            return 0.0, 0.0, 1.0
        case (int() | float() as x, int() | float() as y, int() | float() as z) if 0 < hypot(x, y, z) < inf:
            length = hypot(x, y, z)
            return (x / length, y / length, z / length) if z else (x / length, y / length)
    raise InputError(
        f"direction = {direction!r} is none that a base moves in; expected 'x', 'y', an angle in degrees from x towards"
        " y, or a vector [dx, dy]; in space also 'z' or [dx, dy, dz]"
    )


def rigid_motion(dofs: DofMap, along: Along) -> FloatArray:
    """Return r (dof,): how all degrees of freedom move when the base moves by one ``along`` (dx, dy[, dz])."""
    moved = np.zeros(len(dofs))
    for axis, part in zip(TRANSLATIONS, along, strict=False):
        moved[dofs.direction == axis] = part
    return moved


def base_force(mass: csr_array, dofs: DofMap, along: Along) -> FloatArray:
    """Return -M r (dof,), N for an acceleration of 1 m/s^2.

    ``mass``: sparse (dof, dof) as if no support held the structure, so that what supports carry of a consistent mass
    pulls at its neighbours, too.
    """
    return np.asarray(-(mass @ rigid_motion(dofs, along)))
