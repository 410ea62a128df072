"""Force laws against closed forms and an independent integrator, in Exudyn and in the reduced model."""

from dataclasses import fields, replace
from typing import Any

import numpy as np
import pytest
import torch
from scipy.optimize import brentq

from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import (
    CoulombFriction,
    CubicSpring,
    Effect,
    GapStop,
    HarmonicForce,
    MemorylessLaw,
    QuadraticDamper,
    QuadraticSpring,
    SlackCable,
)
from fe_models.causes.laws import force_laws
from fe_models.causes.slack_cable import SlackLaw
from fe_models.damping import full_damping
from fe_models.errors import InputError
from fe_models.simulation import FreeConfig, ReleaseConfig, simulate_free, simulate_release
from fe_models.statics import PointLoad, rest_state
from fe_models.structure import Cable, Damping, PointMass, Spring, Structure, Support
from tests.problems import WIRE, chain_motion, held_mass

OMEGA = np.sqrt(100.0 / 2.0)  # rad/s, of `held_mass`
PERIOD = 2 * np.pi / OMEGA

CHAIN_EFFECTS: dict[str, Effect] = {
    "cubic": CubicSpring((2, 4), "x", 0.7),
    "softening": CubicSpring((1,), "x", -0.1),
    "asymmetric": QuadraticSpring((1, 2), "x", 0.2),
    "quadratic": QuadraticDamper((3,), "x", 0.3),
    "quadratic between": QuadraticDamper((1, 2), "x", 0.3),
    "friction": CoulombFriction((2,), "x", 0.2, regularisation=0.05),
    "stop": GapStop((4,), "x", 0.4, 5.0, 1),
    "stop behind, between": GapStop((1, 3), "x", 0.3, 5.0, -1),
    "slack": SlackCable(3, 0.5),
    "slack to the ground": SlackCable(1, 0.2),
    "harmonic": HarmonicForce(2, "x", 0.5, 0.3, 0.7),
}
PULLS = {  # of the elongation in the chain's four displacements, by hand
    "cubic": (0, -1, 0, 1),
    "softening": (1, 0, 0, 0),
    "asymmetric": (-1, 1, 0, 0),
    "quadratic": (0, 0, 1, 0),
    "quadratic between": (-1, 1, 0, 0),
    "friction": (0, 1, 0, 0),
    "stop": (0, 0, 0, 1),
    "stop behind, between": (-1, 0, 1, 0),
    "slack": (0, -1, 1, 0),
    "slack to the ground": (1, 0, 0, 0),
    "harmonic": (0, 1, 0, 0),
}


def law_of(structure: Structure) -> MemorylessLaw:
    """The only force law of a structure."""
    (law,) = force_laws(structure)
    assert isinstance(law, MemorylessLaw)
    return law


def peaks(x: FloatArray) -> FloatArray:
    """The largest values of each swing (sample,), by parabolas through three samples."""
    inside = np.flatnonzero((x[1:-1] >= x[:-2]) & (x[1:-1] > x[2:])) + 1
    left, top, right = x[inside - 1], x[inside], x[inside + 1]
    return np.asarray(top + (right - left) ** 2 / (8 * (2 * top - left - right)))


def swing(effect: Effect, duration: float, step: float, start: float = 1.0) -> FloatArray:
    """Displacement (time,) of the held mass, without damping, let go at ``start``."""
    config = FreeConfig(duration, 1 / step, step)
    structure = held_mass(100.0).with_effects(effect)
    return simulate_free(structure, np.array([[start]]), np.zeros((1, 1)), config).displacement[0, :, 0]


@pytest.mark.parametrize("name", CHAIN_EFFECTS)
def test_chain_with_an_effect_follows_an_independent_integrator(name: str) -> None:
    structure = four_dof().with_effects(CHAIN_EFFECTS[name])
    law = law_of(structure)
    pull = np.array(PULLS[name], dtype=float)
    x0, v0 = np.array([1.0, -0.6, 0.8, 0.5]), np.array([0.2, 0.4, -0.5, 0.1])
    response = simulate_free(structure, x0[None], v0[None], FreeConfig(8.0, 20.0, 0.0025))
    model = linearise(structure)
    matrices = model.mass.toarray(), full_damping(model), model.stiffness.toarray()

    def force(u: FloatArray, v: FloatArray, t: float) -> FloatArray:
        return np.asarray(law.force(pull @ u, pull @ v, t)) * pull

    expected = chain_motion(matrices, force, np.concatenate([x0, v0]), response.time)
    found = np.concatenate([response.displacement[0], response.velocity[0]], axis=-1)
    # Order 6 where the force is smooth (1e-10); jumps of its slope, at a stop and at v = 0 of drag, leave 1e-6.
    np.testing.assert_allclose(found, expected, atol=3e-6)
    silent = chain_motion(matrices, lambda u, v, t: np.zeros(4), np.concatenate([x0, v0]), response.time)
    assert np.abs(silent - expected).max() > 0.05  # the effect matters here
    slopes = np.gradient(response.velocity[0], 0.05, axis=0)[5:-5]
    np.testing.assert_allclose(slopes, response.acceleration[0, 5:-5], atol=0.25)  # f is in the accelerations, too


def test_dry_friction_takes_a_fixed_amplitude_a_cycle() -> None:
    friction = CoulombFriction((1,), "x", 2.0, regularisation=1e-3)
    found = peaks(swing(friction, 4.5 * PERIOD, 5e-4))[:4]
    # 4 F / k = 0.08 m a cycle. Below v0 = 1e-3 m/s of 7 m/s it rubs less: 1e-4 of it.
    np.testing.assert_allclose(found, 1.0 - 0.08 * np.arange(1, 5), atol=2e-5)


def test_drag_takes_what_the_closed_form_says() -> None:
    """Of x'' + mu x'|x'| + omega^2 x = 0: from a to -b with (1 - 2 mu b) e^(2 mu b) = (1 + 2 mu a) e^(-2 mu a)."""
    mu = 0.8 / 2.0
    x = swing(QuadraticDamper((1,), "x", 0.8), 2.2 * PERIOD, 2e-3)
    expected, a = [], 1.0
    for _ in range(4):
        goal = (1 + 2 * mu * a) * np.exp(-2 * mu * a)
        a = brentq(lambda b, goal=goal: (1 - 2 * mu * b) * np.exp(2 * mu * b) - goal, 0.0, a, xtol=1e-14)
        expected.append(a)
    found = [peaks(-x)[0], peaks(x)[0], peaks(-x)[1], peaks(x)[1]]
    np.testing.assert_allclose(found, expected, atol=1e-6)  # parabola through samples 2e-3 s apart


@pytest.mark.parametrize("side", [1, -1])
def test_a_stop_turns_motion_where_its_energy_says(side: int) -> None:
    """Where k a^2 = k x^2 + k_s (x - gap)^2, after pi / 2 + asin(gap / a) of free oscillation."""
    stop = GapStop((1,), "x", 0.5, 400.0, 1 if side == 1 else -1)
    x = side * swing(stop, PERIOD, 1e-3, start=-side * 1.0)
    turn = brentq(lambda x: 100 * x**2 + 400 * (x - 0.5) ** 2 - 100, 0.5, 1.0)
    # Setting in over 1 % of the gap changes the energy by k_s (gap / 100)^2 / 6: 2e-5 of it.
    assert peaks(x)[0] == pytest.approx(turn, abs=2e-5)
    touching = np.flatnonzero(x > 0.5)[0] * 1e-3
    assert touching == pytest.approx((np.pi / 2 + np.arcsin(0.5)) / OMEGA, abs=1.01e-3)  # a sample
    assert swing(stop, 0.4 * PERIOD, 1e-3, start=side * 0.49).min() < 0.49  # from within the gap: free all the way


def test_a_slack_cable_lets_the_mass_fly() -> None:
    """Beyond N0 / k it pushes with N0 only: k a^2 / 2 = k p^2 / 2 + N0 (x - p) at the turn, p = N0 / k."""
    x = swing(SlackCable(1, 30.0), PERIOD, 1e-3)
    p = 0.3
    turn = p + 100 * (1 - p**2) / (2 * 30.0)
    # Going slack over 1 % of p changes the energy by k (p / 100)^2 / 6, 3e-8 of it.
    assert peaks(-x)[0] == pytest.approx(turn, abs=1e-5)


def test_a_harmonic_force_keeps_its_steady_state() -> None:
    """Started on it: x = |H| A sin(W t + phase + arg H), H = 1 / (k - m W^2 + i c W)."""
    frequency, phase, drag = 1.4, 0.6, 3.0
    W = 2 * np.pi * frequency
    H = 1 / (100.0 - 2.0 * W**2 + 1j * drag * W)
    structure = replace(held_mass(100.0), damping=Damping(mass_factor=drag / 2.0))
    force = HarmonicForce(1, "x", 5.0, frequency, phase)
    exact = 5.0 * np.imag(H * np.exp(1j * (W * (t := np.linspace(0, 5, 501)) + phase)))
    rate = 5.0 * np.imag(1j * W * H * np.exp(1j * phase))
    config = FreeConfig(5.0, 100.0, 0.01)
    found = simulate_free(structure.with_effects(force), exact[:1][None], np.array([[rate]]), config)
    np.testing.assert_allclose(found.time, t, atol=1e-12)
    np.testing.assert_allclose(found.displacement[0, :, 0], exact, atol=1e-8)  # order 6: (0.09)^6
    np.testing.assert_allclose(found.acceleration[0, :, 0], -(W**2) * exact, atol=1e-6)


def test_an_inclined_cable_that_goes_slack_pulls_along_its_line() -> None:
    """Its elongation takes part of x and of y, which Exudyn cannot evaluate by itself in a small system."""
    structure = Structure(
        "tripod",
        ((0.0, 0.0), (3.0, 4.0), (1.0, 4.0)),
        (Cable((1, 2), replace(WIRE, youngs_modulus=2e9)), Spring((2,), "x", 300.0), Spring((2,), "y", 900.0)),
        point_masses=(PointMass(2, 2.0),),
        supports=(Support(1, ("x", "y")),),
        directions=("x", "y"),
    )
    structure = replace(structure, nodes=structure.nodes[:2]).with_effects(SlackCable(1, 20.0))
    x0, v0 = np.array([[0.2, -0.1]]), np.array([[0.0, 3.0]])
    response = simulate_free(structure, x0, v0, FreeConfig(2.0, 50.0, 0.002))
    model = linearise(structure)
    along, k = np.array([0.6, 0.8]), 2e9 * WIRE.area / 5.0

    def force(u: FloatArray, v: FloatArray, t: float) -> FloatArray:
        return along * max(-20.0 - k * along @ u, 0.0)  # its compression beyond 20 N, taken back

    matrices = model.mass.toarray(), 0 * model.mass.toarray(), model.stiffness.toarray()
    expected = chain_motion(matrices, force, np.concatenate([x0[0], v0[0]]), response.time)
    # It goes slack over 1 % of 20 N / k, here 2e-4 m.
    free = response.displacement[0][:, model.dofs.free]
    np.testing.assert_allclose(free, expected[:, :2], atol=1e-4)
    assert (expected[:, :2] @ along).min() < -5 * 20.0 / k


RELEASED: dict[str, Effect] = {
    "cubic": CubicSpring((1,), "y", 3e3),
    "quadratic": QuadraticDamper((1,), "y", 2.0),
    "friction": CoulombFriction((1,), "y", 1.0, regularisation=0.02),
    "stop": GapStop((1,), "y", 0.05, 500.0, 1),
    "slack": SlackCable(1, 4.0),
    "harmonic": HarmonicForce(1, "y", 3.0, 1.0, 0.3),
}


@pytest.mark.parametrize("name", RELEASED)
def test_a_release_under_gravity_moves_about_rest_as_without(name: str) -> None:
    """Elongations count from the state at rest, 0.2 m below the drawn geometry."""
    spring = Spring((1,), "y", 100.0)
    structure = replace(held_mass(), elements=(spring,), supports=(Support(1, ("x",)),), directions=("x", "y"))
    structure = replace(structure, damping=Damping(stiffness_factor=2e-3)).with_effects(RELEASED[name])
    np.testing.assert_allclose(rest_state(structure), [0.0, -2.0 * 9.81 / 100.0], rtol=1e-9)  # the law is silent
    pull = (PointLoad(1, "y", -12.0 if name == "stop" else 12.0),)
    released = simulate_release(structure, pull, ReleaseConfig(1.5, 200.0, 1e-3))
    start = released.displacement[0, 1]
    law = law_of(structure)
    held = 0.0 if law.timed else float(law.force(start, 0.0))
    assert 100.0 * start + held == pytest.approx(pull[0].force, abs=1e-6)  # Newton's tolerance
    free = simulate_free(structure, np.array([[start]]), np.zeros((1, 1)), FreeConfig(1.5, 200.0, 5e-4))
    # The trapezoidal rule of the release: (omega h)^2 / 12 in the period, 4e-6 times 10 rad; stiffer in contact.
    np.testing.assert_allclose(released.displacement[:, 1], free.displacement[0, :, 1], atol=3e-4 * abs(start))


def test_a_prestressed_cable_goes_slack_at_its_own_pretension() -> None:
    """A mass between a prestressed cable and a spring: about rest it moves as the linear model with the law."""
    structure = Structure(
        "bouncer",
        ((0.0, 0.0), (1.0, 0.0)),
        (Cable((1, 2), WIRE, prestress=500.0), Spring((2,), "x", 1e5)),
        point_masses=(PointMass(2, 50.0),),
        supports=(Support(1, ("x", "y")), Support(2, ("y",))),
        directions=("x", "y"),
        damping=Damping(mass_factor=1e-3),
    ).with_effects(SlackCable(1, 100.0))
    released = simulate_release(structure, (PointLoad(2, "x", 400.0),), ReleaseConfig(0.04, 10_000.0, 2e-5, 0.0))
    rest = linearise(structure, rest_state(structure, 0.0))
    config = FreeConfig(0.04, 10_000.0, 2e-5)
    laws = force_laws(structure)
    free = simulate_free(rest, released.displacement[:1, 2:3], np.zeros((1, 1)), config, laws)
    amplitude = np.abs(free.displacement).max()
    x = released.displacement[:, 2]
    np.testing.assert_allclose(x, free.displacement[0, :, 2], atol=3e-3 * amplitude)  # strains of 7e-4, and the step
    assert x.min() < -1.5 * x[0]  # slack, it flies further than it was pulled


@pytest.mark.parametrize("name", [name for name in CHAIN_EFFECTS if name != "harmonic"])
def test_every_sort_of_number_gives_the_same_force(name: str) -> None:
    """Floats, arrays and tensors do; Exudyn's symbolic numbers are in every simulation here."""
    law = law_of(four_dof().with_effects(CHAIN_EFFECTS[name]))
    u, v = np.random.default_rng(5).standard_normal((2, 40))
    whole = np.asarray(law.force(u, v, 0.3))
    np.testing.assert_allclose([law.force(float(a), float(b), 0.3) for a, b in zip(u, v, strict=True)], whole)
    tensors = [torch.tensor(values, requires_grad=True) for values in (u, v)]
    force = law.force(tensors[0], tensors[1], torch.tensor(0.3))
    np.testing.assert_allclose(force.detach().numpy(), whole, rtol=1e-12)
    slopes = torch.autograd.grad(force.sum(), tensors, allow_unused=True)
    for values, by, slope in zip((u, v), np.eye(2) * 1e-6, slopes, strict=True):
        found = np.zeros_like(values) if slope is None else slope.numpy()
        difference = (np.asarray(law.force(u + by[0], v + by[1])) - law.force(u - by[0], v - by[1])) / 2e-6
        np.testing.assert_allclose(found, difference, atol=1e-6)  # central differences of smooth laws


@pytest.mark.parametrize("name", CHAIN_EFFECTS)
def test_forces_have_slopes_by_their_parameters(name: str) -> None:
    """A search may put tensors in the place of numbers: what it gets are the slopes that differences show."""
    law = law_of(four_dof().with_effects(CHAIN_EFFECTS[name]))
    springs = CubicSpring | QuadraticSpring | GapStop | SlackLaw
    assert isinstance(law, springs | QuadraticDamper | CoulombFriction | HarmonicForce)
    u, v = np.random.default_rng(6).standard_normal((2, 40))
    numbers = [item.name for item in fields(law) if isinstance(getattr(law, item.name), float)]
    assert numbers
    for parameter in numbers:
        value = getattr(law, parameter)
        tensor = torch.tensor(value, dtype=torch.float64, requires_grad=True)
        changed: dict[str, Any] = {parameter: tensor}
        total = replace(law, **changed).force(torch.tensor(u), torch.tensor(v), 0.4).sum()
        (slope,) = torch.autograd.grad(total, tensor)
        up, down = (np.sum(replace(law, **{parameter: value + step}).force(u, v, 0.4)) for step in (1e-6, -1e-6))
        assert slope.item() == pytest.approx(float(up - down) / 2e-6, rel=1e-6, abs=1e-7)


@pytest.mark.parametrize("name", CHAIN_EFFECTS)
def test_laws_are_silent_at_rest_and_bounded_by_their_slopes(name: str) -> None:
    law = law_of(four_dof().with_effects(CHAIN_EFFECTS[name]))
    if not law.timed:
        assert abs(law.force(0.0, 0.0)) < 1e-30  # rounding, squared
    grid = np.linspace(-2, 2, 4001)
    for slope, forces in zip(
        law.largest_slopes, (law.force(grid, 0.0 * grid), law.force(0.0 * grid, grid)), strict=True
    ):
        if slope:
            assert np.abs(np.diff(forces)).max() / 1e-3 == pytest.approx(slope, rel=1e-3)  # chords of 1e-3


def test_a_stop_sets_in_smoothly_and_is_exact_beyond() -> None:
    stop = GapStop((1,), "x", 0.5, 2.0, 1)
    u = np.linspace(0.49, 0.51, 200_001)
    force = np.asarray(stop.force(u, 0.0))
    assert np.abs(np.diff(force, 2)).max() < 2.01 * 2.0 * 1e-14 / (4 * 0.005)  # no jump of the slope
    assert abs(stop.force(0.4949, 0.0)) < 1e-30
    assert stop.force(0.5051, 0.0) == pytest.approx(2.0 * 0.0051, rel=1e-12)
    assert GapStop((1,), "x", 0.0, 2.0, -1).force(np.array([0.3, 0.0, -0.3]), 0.0).tolist() == [0.0, 0.0, -0.6]


@pytest.mark.parametrize(
    ("effect", "words"),
    [
        (CoulombFriction((1,), "x", 1.0), "at rest damps within 0.001 s"),
        (GapStop((1,), "x", 0.1, 1e6, 1), "too long for the highest mode"),
    ],
)
def test_refuses_steps_that_an_effect_does_not_stand(effect: Effect, words: str) -> None:
    with pytest.raises(InputError, match=words):
        simulate_free(four_dof().with_effects(effect), np.ones((1, 4)), np.zeros((1, 4)), FreeConfig(step=0.01))


def test_matrices_alone_take_no_effect_that_changes_a_structure() -> None:
    with pytest.raises(InputError, match="slack_cable changes a structure"):
        simulate_free(linearise(four_dof()), np.ones((1, 4)), np.zeros((1, 4)), effects=(SlackCable(1, 1.0),))


def test_a_law_may_end_at_a_support_but_not_sit_on_one() -> None:
    chain = Structure(
        "held end",
        ((0.0, 0.0), (1.0, 0.0)),
        (Spring((1, 2), "x", 100.0),),
        point_masses=(PointMass(2, 2.0),),
        supports=(Support(1, ("x",)),),
        directions=("x",),
    )
    x0 = np.ones((1, 1))
    for nodes in ((1, 2), (2, 1)):
        both = simulate_free(
            chain.with_effects(CubicSpring(nodes, "x", 50.0)), x0, 0 * x0, FreeConfig(1.0, 50.0, 0.005)
        )
        alone = simulate_free(
            chain.with_effects(CubicSpring((2,), "x", 50.0)), x0, 0 * x0, FreeConfig(1.0, 50.0, 0.005)
        )
        np.testing.assert_allclose(both.displacement, alone.displacement, atol=1e-14)  # u^3 is odd
    with pytest.raises(InputError, match="node 1 is held in x; join a node that moves"):
        simulate_free(chain.with_effects(CubicSpring((1,), "x", 1.0)), x0, x0)


def test_linearised_chain_does_not_feel_force_laws() -> None:
    """They come on top by their force; their slopes at rest, as of friction, would count twice."""
    with_laws = linearise(four_dof().with_effects(*CHAIN_EFFECTS.values()))
    for name in ("mass", "damping", "stiffness"):
        np.testing.assert_array_equal(
            getattr(with_laws, name).toarray(), getattr(linearise(four_dof()), name).toarray()
        )


def test_all_degrees_of_freedom_that_a_model_lacks_are_named() -> None:
    model, x0 = linearise(four_dof()), np.ones((1, 4))
    with pytest.raises(InputError) as caught:
        simulate_free(model, x0, x0, effects=(CubicSpring((8, 9), "x", 1.0), QuadraticDamper((7,), "x", 1.0)))
    assert caught.value.faults == (
        "cubic_spring: node 8 has no degree of freedom 'x'",
        "cubic_spring: node 9 has no degree of freedom 'x'",
        "quadratic_damper: node 7 has no degree of freedom 'x'",
    )
