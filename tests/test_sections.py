"""Areas and second moments of area against integrals over the shape, and against limits that coincide."""

from math import pi

import numpy as np
import pytest

from fe_models.errors import InputError
from fe_models.sections import Section, rectangle, round_bar, round_tube, round_wire, square_tube

E, RHO = 2.1e11, 7850.0


def properties(section: Section) -> tuple[float, float]:
    return section.area, section.second_moment


def integrate(widths: np.ndarray, heights: np.ndarray) -> tuple[float, float]:
    """Return the integrals of b(z) and of b(z) z^2 by the midpoint rule; ``heights`` are the midpoints."""
    step = heights[1] - heights[0]
    return float(widths.sum() * step), float((widths * heights**2).sum() * step)


STRIPS = 20_000
# Midpoint errors at 20,000 strips: 1e-8 where the width is smooth, 1e-6 at the vertical tangents of a circle.
TOLERANCE = 1e-5


def midpoints(height: float) -> np.ndarray:
    return (np.arange(STRIPS) + 0.5) / STRIPS * height - height / 2


def chord(diameter: float, z: np.ndarray) -> np.ndarray:
    return 2 * np.sqrt(np.maximum((diameter / 2) ** 2 - z**2, 0.0))


def test_shapes_match_their_integrals() -> None:
    z = midpoints(0.2)
    assert properties(rectangle("r", E, RHO, 0.1, 0.2)) == pytest.approx(
        integrate(np.full(STRIPS, 0.1), z), rel=TOLERANCE
    )
    assert properties(round_bar("b", E, RHO, 0.2)) == pytest.approx(integrate(chord(0.2, z), z), rel=TOLERANCE)
    tube = chord(0.2, z) - chord(0.16, z)
    assert properties(round_tube("t", E, RHO, 0.2, 0.02)) == pytest.approx(integrate(tube, z), rel=TOLERANCE)
    walls = np.where(abs(z) < 0.08, 0.04, 0.2)
    assert properties(square_tube("s", E, RHO, 0.2, 0.02)) == pytest.approx(integrate(walls, z), rel=1e-4)  # 2 steps


def test_full_walls_make_solid_sections() -> None:
    # Equal but for rounding: the hollow disappears.
    assert properties(square_tube("s", E, RHO, 0.2, 0.1)) == pytest.approx(properties(rectangle("r", E, RHO, 0.2, 0.2)))
    assert properties(round_tube("s", E, RHO, 0.2, 0.1)) == pytest.approx(properties(round_bar("r", E, RHO, 0.2)))


def test_a_wire_has_no_bending_stiffness_and_the_stiffness_of_its_area() -> None:
    wire = round_wire("w", E, RHO, 0.002)
    assert wire.bending_stiffness == 0.0
    assert wire.axial_stiffness == pytest.approx(E * pi * 1e-6)
    assert wire.mass_per_length == pytest.approx(RHO * pi * 1e-6)


def test_impossible_dimensions_are_bad_input() -> None:
    with pytest.raises(InputError, match=r"wall = 0.11 m; must be positive and at most half of .* 0.2 m"):
        square_tube("s", E, RHO, 0.2, 0.11)
    with pytest.raises(InputError, match=r"diameter = -1.0 m; must be positive"):
        round_wire("w", E, RHO, -1.0)
    with pytest.raises(InputError) as caught:
        rectangle("r", E, RHO, 0.0, -1.0)
    assert len(caught.value.faults) == 2
