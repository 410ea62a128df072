"""Cross-sections of beams and cables, with their material."""

from dataclasses import dataclass
from math import pi


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
    inner = side - 2 * wall
    return Section(name, youngs_modulus, density, side**2 - inner**2, (side**4 - inner**4) / 12)


def round_wire(name: str, youngs_modulus: float, density: float, diameter: float) -> Section:
    """Return the section of a wire without bending stiffness, ``diameter`` in m."""
    return Section(name, youngs_modulus, density, pi * diameter**2 / 4)
