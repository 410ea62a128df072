"""Cross-sections of beams and cables, with their material."""

from collections.abc import Callable
from dataclasses import dataclass
from math import pi

from fe_models.errors import InputError, raise_faults


@dataclass(frozen=True)
class Section:
    """Material and cross-section of a member.

    ``youngs_modulus`` E (Pa), ``density`` (kg/m^3), ``area`` A (m^2), ``second_moment`` I of area (m^4; 0 for cables).
    """

    name: str
    youngs_modulus: float
    density: float
    area: float
    second_moment: float = 0.0

    @property
    def axial_stiffness(self) -> float:
        """E A (N)."""
        return self.youngs_modulus * self.area

    @property
    def bending_stiffness(self) -> float:
        """E I (N m^2)."""
        return self.youngs_modulus * self.second_moment

    @property
    def mass_per_length(self) -> float:
        """Density times area (kg/m)."""
        return self.density * self.area


def square_tube(name: str, youngs_modulus: float, density: float, side: float, wall: float) -> Section:
    """Return the section of a square hollow tube, outer ``side`` and ``wall`` thickness in m."""
    _check_wall(wall, side)
    inner = side - 2 * wall
    return Section(name, youngs_modulus, density, side**2 - inner**2, (side**4 - inner**4) / 12)


def round_tube(name: str, youngs_modulus: float, density: float, diameter: float, wall: float) -> Section:
    """Return the section of a round hollow tube, outer ``diameter`` and ``wall`` thickness in m."""
    _check_wall(wall, diameter)
    inner = diameter - 2 * wall
    area, second_moment = pi * (diameter**2 - inner**2) / 4, pi * (diameter**4 - inner**4) / 64
    return Section(name, youngs_modulus, density, area, second_moment)


def rectangle(name: str, youngs_modulus: float, density: float, width: float, height: float) -> Section:
    """Return the section of a solid rectangle, ``height`` (m) in the plane of bending."""
    _check_positive(width=width, height=height)
    return Section(name, youngs_modulus, density, width * height, width * height**3 / 12)


def round_bar(name: str, youngs_modulus: float, density: float, diameter: float) -> Section:
    """Return the section of a solid round bar, ``diameter`` in m."""
    _check_positive(diameter=diameter)
    return Section(name, youngs_modulus, density, pi * diameter**2 / 4, pi * diameter**4 / 64)


def round_wire(name: str, youngs_modulus: float, density: float, diameter: float) -> Section:
    """Return the section of a wire without bending stiffness, ``diameter`` in m."""
    _check_positive(diameter=diameter)
    return Section(name, youngs_modulus, density, pi * diameter**2 / 4)


SHAPES: dict[str, Callable[..., Section]] = {
    shape.__name__: shape for shape in (square_tube, round_tube, rectangle, round_bar, round_wire)
}


def _check_positive(**lengths: float) -> None:
    raise_faults(f"{name} = {length} m; must be positive" for name, length in lengths.items() if not length > 0)


def _check_wall(wall: float, outer: float) -> None:
    if not 0 < wall <= outer / 2:
        raise InputError(f"wall = {wall} m; must be positive and at most half of the outer dimension, {outer} m")
