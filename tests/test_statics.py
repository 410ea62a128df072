"""States at rest against closed forms: large rotations, slack and prestressed cables, P-delta."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from fe_models.assembly import linearise
from fe_models.errors import InputError
from fe_models.modes import natural_modes
from fe_models.sections import Section
from fe_models.statics import PointLoad, rest_state
from fe_models.structure import Cable, PointMass, Spring, Structure, Support
from tests.problems import TIMBER, WIRE, cantilever

EI, EA = TIMBER.bending_stiffness, TIMBER.axial_stiffness


@pytest.mark.parametrize("turns", [0.25, 1.0])
def test_tip_moment_rolls_a_cantilever_into_a_circle(turns: float) -> None:
    parts, length, angle = 20, 2.0, 2 * np.pi * turns
    structure = cantilever(length, divisions=parts)
    state = rest_state(structure, gravity=0.0, loads=(PointLoad(2, "rz", EI * angle / length),))
    # Each part keeps its length as the chord, turned by the mean of its ends' rotations: a polygon about the circle.
    chords = angle * (np.arange(parts) + 0.5) / parts
    tip = length / parts * np.array([np.cos(chords).sum(), np.sin(chords).sum()]) - [length, 0.0]
    np.testing.assert_allclose(state[3:6], [*tip, angle], atol=1e-9)  # Newton leaves 1e-11
    circle = length / angle * np.array([np.sin(angle), 1 - np.cos(angle)]) - [length, 0.0]
    # A polygon of 20 chords is off the arc by (angle / 20)^2 / 24 of the radius.
    assert np.abs(state[3:5] - circle).max() < 1.1 * length / angle * (angle / parts) ** 2 / 24 * 2


def test_small_tip_load_bends_as_in_the_textbook() -> None:
    force, length = 1e-3, 2.0
    state = rest_state(cantilever(length), gravity=0.0, loads=(PointLoad(2, "y", force),))
    # F L^3 / (3 E I) and F L^2 / (2 E I); large-displacement terms are (v / L)^2 = 1e-10.
    np.testing.assert_allclose(state[4:6], [force * length**3 / (3 * EI), force * length**2 / (2 * EI)], rtol=1e-6)


def test_own_weight_sags_a_cantilever() -> None:
    length, gravity = 2.0, 1e-3
    state = rest_state(cantilever(length), gravity)
    load = TIMBER.mass_per_length * gravity
    # w L^4 / (8 E I), exact at the nodes whatever the mesh; large-displacement terms are (v / L)^2 = 1e-12.
    assert state[4] == pytest.approx(-load * length**4 / (8 * EI), rel=1e-9)


def tug(prestress: float, tension_only: bool) -> Structure:
    """A node between two equal cables along x, held across them by a soft spring."""
    return Structure(
        "tug",
        ((-1.0, 0.0), (0.0, 0.0), (1.0, 0.0)),
        (
            Cable((1, 2), WIRE, prestress, tension_only),
            Cable((2, 3), WIRE, prestress, tension_only),
            Spring((2,), "y", 10.0),
        ),
        point_masses=(PointMass(2, 1.0),),
        supports=(Support(1, ("x", "y")), Support(3, ("x", "y"))),
        directions=("x", "y"),
    )


def test_slack_cable_carries_nothing() -> None:
    force, stiffness = 20.0, WIRE.axial_stiffness / 1.0
    (both, one, prestressed) = (
        rest_state(tug(prestress, slack), gravity=0.0, loads=(PointLoad(2, "x", force),))[2]
        for prestress, slack in ((0.0, False), (0.0, True), (force, True))
    )
    # Strains are 3e-5, and so the differences between strain measures.
    assert both == pytest.approx(force / (2 * stiffness), rel=1e-4)
    assert one == pytest.approx(force / stiffness, rel=1e-4)
    assert prestressed == pytest.approx(force / (2 * stiffness), rel=1e-4)  # neither goes slack
    released = rest_state(tug(force / 4, True), gravity=0.0, loads=(PointLoad(2, "x", force),))[2]
    # Slack once moved by N / k; the taut one then carries all: F = k u + N.
    assert released == pytest.approx((force - force / 4) / stiffness, rel=1e-4)


def test_tangent_forgets_a_slack_cable() -> None:
    structure = tug(0.0, True)
    pulled = rest_state(structure, gravity=0.0, loads=(PointLoad(2, "x", 20.0),))
    taut = linearise(structure).stiffness.toarray()[0, 0]
    assert linearise(structure, pulled).stiffness.toarray()[0, 0] == pytest.approx(taut / 2, rel=1e-4)  # strain 3e-5


def test_taut_string_vibrates_by_its_prestress() -> None:
    parts, tension, span = 40, 500.0, 4.0
    nodes = tuple((span * i / parts, 0.0) for i in range(parts + 1))
    string = Structure(
        "string",
        nodes,
        tuple(Cable((i, i + 1), WIRE, tension) for i in range(1, parts + 1)),
        supports=(Support(1, ("x", "y")), Support(parts + 1, ("x", "y"))),
        directions=("x", "y"),
    )
    state = rest_state(string, gravity=0.0)
    found = natural_modes(linearise(string, state), 3).frequencies
    exact = np.array([1, 2, 3]) / (2 * span) * np.sqrt(tension / WIRE.mass_per_length)
    # Linear shapes with consistent mass: (k h)^2 / 24 = 2e-3 of the frequency for the third.
    np.testing.assert_allclose(found, exact, rtol=2.5e-3)
    assert (found > exact).all()


@pytest.mark.parametrize("load", [0.3, 0.7])
def test_weight_softens_a_column(load: float) -> None:
    """A massless column with a mass m on top: omega^2 = k(P) / m, P = m g.

    k(P) = P / (L (tan(a) / a - 1)), a = L sqrt(P / (E I)), which vanishes at Euler's load, nearly as 1 - P / Pcr.
    """
    length = 2.0
    critical = np.pi**2 * EI / (4 * length**2)
    mass = load * critical / 9.81
    column = replace(
        cantilever(length, 8, replace(TIMBER, density=0.0)),
        nodes=((0.0, 0.0), (0.0, length)),
        point_masses=(PointMass(2, mass),),
    )
    without_load_response = natural_modes(linearise(column), 1).omega[0]
    assert without_load_response == pytest.approx(np.sqrt(3 * EI / length**3 / mass), rel=1e-9)
    loaded = natural_modes(linearise(column, rest_state(column)), 1).omega[0]
    a = np.pi / 2 * np.sqrt(load)
    exact = np.sqrt(load * critical / (length * (np.tan(a) / a - 1)) / mass)
    assert loaded == pytest.approx(exact, rel=5e-3)  # order 2: the element's geometric stiffness is linear in shape
    assert loaded / without_load_response == pytest.approx(np.sqrt(1 - load), rel=0.02)  # the textbook's approximation


def test_column_buckles_at_euler_s_load() -> None:
    length = 2.0
    column = replace(cantilever(length, 16), nodes=((0.0, 0.0), (0.0, length)))

    def softest(load: float) -> float:
        state = rest_state(column, gravity=0.0, loads=(PointLoad(2, "y", -load),))
        return float(np.linalg.eigvalsh(linearise(column, state).stiffness.toarray())[0])

    critical = np.pi**2 * EI / (4 * length**2)
    assert brentq(softest, 0.9 * critical, 1.1 * critical) == pytest.approx(critical, rel=3e-3)  # order 2, 16 parts


@pytest.mark.parametrize("divisions", [1, 40])
def test_heavy_sections_come_to_rest_under_light_loads(divisions: int) -> None:
    heavy = Section("bridge girder", 2.1e11, 7850.0, 1.5, 3.0)
    length, force = 400.0, 100.0
    state = rest_state(cantilever(length, divisions, heavy), gravity=0.0, loads=(PointLoad(2, "y", force),))
    expected = force * length**3 / (3 * heavy.bending_stiffness)
    assert state[4] == pytest.approx(expected, rel=1e-4)  # rounding of E A times the strain is 1e-2 N of the 100 N


def test_refuses_loads_that_do_not_fit() -> None:
    loads = (PointLoad(9, "y", 1.0), PointLoad(1, "x", 1.0), PointLoad(2, "y", np.nan))
    with pytest.raises(InputError) as caught:
        rest_state(cantilever(), loads=loads)
    missing, held, endless = caught.value.faults
    assert "node 9 has no degree of freedom 'y'; the nodes are 1 to 2" in missing
    assert "node 1 in x: a support holds the node there" in held
    assert "nan is not a force" in endless


def test_says_what_to_do_where_nothing_comes_to_rest() -> None:
    pendulum = replace(tug(0.0, True), elements=tug(0.0, True).elements[:2])  # nothing holds the node across the cables
    with pytest.raises(InputError, match="no state at rest found"):
        rest_state(pendulum, loads=(PointLoad(2, "y", 5.0),))
