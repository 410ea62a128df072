"""Simulated motion against an independent integrator, the linear solution, closed forms and its own convergence."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.built_in.bridge import bridge
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import ConnectorEffect, CoulombFriction, CubicSpring
from fe_models.damping import full_damping, rayleigh_damping
from fe_models.drive import drive_of
from fe_models.errors import InputError
from fe_models.exudyn.solve import Steps, _calmed_by
from fe_models.linear import LinearModel
from fe_models.modes import natural_modes
from fe_models.recordings import Load
from fe_models.response import Response
from fe_models.simulation import FreeConfig, ReleaseConfig, simulate_driven, simulate_free, simulate_release
from fe_models.statics import PointLoad, load_vector, rest_state
from fe_models.structure import Cable, Damping, PointMass, Structure, Support
from tests.problems import TIMBER, WIRE, cantilever, chain_motion, held_mass, newmark

SHORT = FreeConfig(duration=10.0, sampling_rate=10.0, step=0.05)


def dense(model: LinearModel) -> tuple[FloatArray, FloatArray, FloatArray]:
    return model.mass.toarray(), full_damping(model), model.stiffness.toarray()


def states(response: Response) -> FloatArray:
    """Return displacement and velocity side by side, (realisation, time, 2 dof)."""
    return np.concatenate([response.displacement, response.velocity], axis=-1)


def start(count: int, size: int) -> FloatArray:
    return np.random.default_rng(4).standard_normal((2, count, size))


@pytest.mark.slow
@pytest.mark.parametrize("cubic", [0.0, 0.5, 1.0])
def test_chain_follows_an_independent_integrator(cubic: float) -> None:
    structure, (x0, v0) = four_dof(cubic), start(3, 4)
    response = simulate_free(structure, x0, v0, FreeConfig(duration=50.0))

    def force(u: FloatArray, v: FloatArray, t: float = 0.0) -> FloatArray:
        return np.array([cubic * u[0] ** 3, 0, 0, 0])

    matrices = dense(linearise(replace(structure, effects=())))
    for run, (x, v) in enumerate(zip(x0, v0, strict=True)):
        expected = chain_motion(matrices, force, np.concatenate([x, v]), response.time)
        # Order 6 at a step of 0.05 s: 2e-7 after 50 s where the cubic spring doubles the highest frequency.
        np.testing.assert_allclose(states(response)[run], expected, atol=1e-6)
        u, rate = np.split(expected, 2, axis=1)
        forces = (
            rate @ matrices[1].T + u @ matrices[2].T + np.array([force(*pair) for pair in zip(u, rate, strict=True)])
        )
        np.testing.assert_allclose(response.acceleration[run], -forces / [1, 2, 3, 4], atol=1e-5)


def test_effect_between_two_nodes_pulls_both() -> None:
    effect, (x0, v0) = CubicSpring((2, 4), "x", 0.7), start(1, 4)
    response = simulate_free(four_dof(), x0, v0, SHORT, (effect,))

    def force(u: FloatArray, v: FloatArray, t: float = 0.0) -> FloatArray:
        return 0.7 * (u[3] - u[1]) ** 3 * np.array([0, -1, 0, 1])

    expected = chain_motion(dense(linearise(four_dof())), force, np.concatenate([x0[0], v0[0]]), response.time)
    np.testing.assert_allclose(states(response)[0], expected, atol=1e-6)  # order 6, as above
    np.testing.assert_allclose(
        np.gradient(response.velocity[0], 0.1, axis=0)[5:-5], response.acceleration[0, 5:-5], atol=0.1
    )


@pytest.mark.parametrize(("integrator", "order"), [("rk67", 6), ("newmark", 2)])
def test_integrators_have_their_order(integrator: str, order: int) -> None:
    x0, v0 = start(1, 4)
    configs = [FreeConfig(8.0, 2.0, step, integrator) for step in (0.25, 0.125, 0.0625)]  # type: ignore[arg-type]  # a parameter
    exact = simulate_free(four_dof(1.0), x0, v0, FreeConfig(8.0, 2.0, 0.005)).displacement
    errors = [np.abs(simulate_free(four_dof(1.0), x0, v0, config).displacement - exact).max() for config in configs]
    observed = np.log2(np.array(errors[:-1]) / errors[1:])
    assert observed[-1] > order - 0.3, f"observed orders {observed}"  # RK67 may show its order 7


def test_implicit_rule_takes_no_energy() -> None:
    oscillator = held_mass(100.0)
    period = 2 * np.pi / np.sqrt(50.0)
    config = FreeConfig(100 * period, 20 / period, period / 20, "newmark")
    response = simulate_free(oscillator, np.array([[1.0]]), np.array([[0.0]]), config)
    energy = 50 * response.displacement**2 + response.velocity**2
    np.testing.assert_allclose(energy, 50.0, rtol=1e-6)  # the trapezoidal rule keeps it but for Newton's tolerance


def test_realisations_do_not_touch_each_other() -> None:
    x0, v0 = start(3, 4)
    together = simulate_free(four_dof(1.0), x0, v0, SHORT)
    alone = simulate_free(four_dof(1.0), x0[1:2], v0[1:2], SHORT)
    np.testing.assert_array_equal(together.displacement[1], alone.displacement[0])


def test_matrices_alone_move_like_their_structure() -> None:
    x0, v0 = start(1, 4)
    by_structure = simulate_free(four_dof(0.5), x0, v0, SHORT)
    by_matrices = simulate_free(linearise(four_dof()), x0, v0, SHORT, (CubicSpring((1,), "x", 0.5),))
    np.testing.assert_array_equal(by_matrices.displacement, by_structure.displacement)


@pytest.mark.parametrize("damping", [Damping(), Damping(modal_ratios=(0.05,)), Damping(mass_factor=0.2)])
def test_oscillator_decays_as_its_damping_ratio_says(damping: Damping) -> None:
    structure = replace(held_mass(100.0), damping=damping)
    omega = np.sqrt(100.0 / 2.0)
    ratio = natural_modes(linearise(structure), 1).damping_ratio[0]
    response = simulate_free(structure, np.array([[1.0]]), np.array([[0.0]]), FreeConfig(5.0, 50.0, 0.005))
    t, damped = response.time, omega * np.sqrt(1 - ratio**2)
    exact = np.exp(-ratio * omega * t) * (np.cos(damped * t) + ratio * omega / damped * np.sin(damped * t))
    np.testing.assert_allclose(response.channel(1, "x", "displacement")[0], exact, atol=1e-8)  # (0.035)^6 a period


@pytest.mark.parametrize("modal", [False, True])
def test_small_release_of_the_bridge_is_the_linear_one_about_its_rest(modal: bool) -> None:
    structure = replace(bridge(), damping=Damping(modal_ratios=(0.01,))) if modal else bridge()
    config = ReleaseConfig(duration=0.5, sampling_rate=500.0, step=1e-3)
    response = simulate_release(structure, (PointLoad(19, "y", -1e-3),), config)
    tangent = linearise(structure, rest_state(structure))
    free = tangent.dofs.free
    expected = newmark(dense(tangent), response.displacement[0, free], 1e-3, 500)[::2]
    # The same rule on the same grid: what is left is the square of the pull, 1e-3 N against 10 N of weight, and Newton.
    largest = np.abs(expected).max()
    np.testing.assert_allclose(response.displacement[:, free], expected, atol=2e-3 * largest)
    assert not response.displacement[:, ~free].any()


def test_release_starts_from_the_pulled_shape_without_velocity() -> None:
    structure, pull = bridge(), (PointLoad(19, "y", -9.81),)
    response = simulate_release(structure, pull, ReleaseConfig(duration=0.02, step=2e-4, sampling_rate=5000.0))
    expected = rest_state(structure, loads=pull) - rest_state(structure)
    np.testing.assert_allclose(response.displacement[0], expected, atol=1e-15)
    assert not response.velocity[0].any()
    # Before the release all forces balance; without the pull, M a = -pull. Exudyn solves that to 1e-6 of the largest.
    model = linearise(structure)
    free_pull = np.where((model.dofs.node == 19) & (model.dofs.direction == "y"), -9.81, 0.0)[model.dofs.free]
    expected = -np.linalg.solve(model.mass.toarray(), free_pull)
    found = response.acceleration[0, model.dofs.free]
    np.testing.assert_allclose(found, expected, atol=1e-5 * np.abs(expected).max())


def test_release_converges_with_the_step() -> None:
    structure = replace(cantilever(divisions=4), damping=rayleigh_damping(0.02, 4.0, 25.0))
    configs = [ReleaseConfig(1.0, 100.0, step) for step in (2e-3, 1e-3, 5e-4, 2.5e-4)]
    pull = (PointLoad(2, "y", 40.0),)  # bends it by a third of its length
    runs = [simulate_release(structure, pull, config).displacement for config in configs]
    steps = np.array([np.abs(b - a).max() for a, b in pairwise(runs)])
    order = np.log2(steps[:-1] / steps[1:])
    assert order[-1] > 1.7, f"observed orders {order}"  # second order once the modes that move are resolved
    assert np.abs(runs[-1][0]).max() > 0.3


def test_highest_modes_leave_no_accelerations_that_alternate_with_the_steps() -> None:
    """The trapezoidal rule hardly damps what is stiff and strongly damped; a release begins with much of it."""
    structure = replace(cantilever(divisions=16), damping=Damping(mass_factor=0.3, stiffness_factor=1e-4))
    pull = (PointLoad(2, "y", -1.0),)
    model = linearise(structure)
    M, C, K = dense(model)
    n, tip = len(M), model.dofs.row(2, "y")
    x0 = np.linalg.solve(K, load_vector(structure, pull)[model.dofs.free])
    roots, vectors = np.linalg.eig(np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, np.hstack([K, C]))]]))
    amplitudes = np.linalg.solve(vectors, np.concatenate([x0, np.zeros(n)]))
    shown = roots * vectors[n + model.dofs.free_rows.tolist().index(tip)] * amplitudes
    errors = []
    for step in (5e-4, 2.5e-4):
        response = simulate_release(structure, pull, ReleaseConfig(0.5, 1000.0, step, gravity=0.0))
        later = response.time > 0.1
        exact = np.real(np.exp(np.outer(response.time[later], roots)) @ shown)
        errors.append(np.abs(response.acceleration[later, tip] - exact).max() / np.abs(exact).max())
    assert errors[1] < 0.02
    assert 3.5 < errors[0] / errors[1] < 4.5  # of order 2; what alternates would fall with no power of the step


@pytest.mark.parametrize(("per_output", "outputs"), [(1, 9), (2, 3), (3, 2)])
def test_calmed_accelerations_keep_what_is_smooth(per_output: int, outputs: int) -> None:
    """What alternates with the steps goes, but at the start, which no step has touched; parabolas stay, to the ends."""
    steps = Steps(0.1, outputs, per_output)
    time = np.arange(steps.outputs * per_output + 1)
    for shown, left in ((1.0 + 2.0 * time - 0.3 * time**2, 1.0), ((-1.0) ** time, 0.0)):
        found = np.zeros(outputs + 1)
        for step, value in enumerate(shown):
            for output, weight in _calmed_by(step, steps):
                found[output] += weight * value
        assert found[0] == shown[0]
        np.testing.assert_allclose(found[1:], left * shown[per_output::per_output], atol=1e-13)


def test_large_displacement_keeps_the_length_of_the_beam() -> None:
    structure = replace(cantilever(divisions=8), damping=rayleigh_damping(0.02, 4.0, 25.0))
    response = simulate_release(structure, (PointLoad(2, "y", 60.0),), ReleaseConfig(0.1, 100.0, gravity=0.0))
    shortening = response.channel(2, "x", "displacement")[0]
    assert shortening < -0.05  # a linear beam's tip would move across only
    inner = [1, *range(3, 10), 2]
    x, y = ([response.channel(node, axis, "displacement")[0] for node in inner] for axis in "xy")
    chords = np.hypot(np.diff(x) + 2.0 / 8, np.diff(y))
    assert chords.sum() == pytest.approx(2.0, rel=1e-4)  # stretched by N / (E A) = 1e-5


def test_cable_pulls_and_never_pushes() -> None:
    """A mass between a spring of steel and a slack cable bounces: half a period of each stiffness in turn."""
    structure = Structure(
        "bouncer",
        ((0.0, 0.0), (1.0, 0.0)),
        (Cable((1, 2), WIRE),),
        point_masses=(PointMass(2, 50.0),),
        supports=(Support(1, ("x", "y")), Support(2, ("y",))),
        directions=("x", "y"),
        damping=Damping(mass_factor=1e-3),
    )
    omega = np.sqrt(WIRE.axial_stiffness / (50.0 + WIRE.mass_per_length / 3))
    pull = 300.0
    response = simulate_release(structure, (PointLoad(2, "x", pull),), ReleaseConfig(0.04, 10_000.0, 2e-5))
    amplitude = pull / WIRE.axial_stiffness
    t, x = response.time, response.channel(2, "x", "displacement")
    quarter = np.pi / 2 / omega
    # Taut: a cosine; slack from the first zero on: straight on at the speed it has then.
    exact = np.where(t < quarter, amplitude * np.cos(omega * t), -amplitude * omega * (t - quarter))
    np.testing.assert_allclose(x, exact, atol=0.01 * amplitude)  # strain 5e-4; the step of 2e-5 s at the kink
    assert x.min() < -2 * amplitude


def test_damping_of_a_release_follows_the_ratio() -> None:
    structure = replace(cantilever(divisions=2), damping=Damping(modal_ratios=(0.02,)))
    response = simulate_release(structure, (PointLoad(2, "y", 0.01),), ReleaseConfig(3.0, 200.0, 1e-3, gravity=0.0))
    omega = natural_modes(linearise(structure), 1).omega[0]
    tip = response.channel(2, "y", "displacement")
    peaks = tip[1:-1][(tip[1:-1] > tip[:-2]) & (tip[1:-1] > tip[2:]) & (tip[1:-1] > 0)]
    decrement = np.log(peaks[1] / peaks[-1]) / (len(peaks) - 2)
    assert decrement == pytest.approx(2 * np.pi * 0.02, rel=0.05)  # the higher modes ride on the first peaks
    assert len(peaks) == pytest.approx(3.0 * omega / (2 * np.pi), abs=2)


def test_refuses_initial_states_that_do_not_fit() -> None:
    with pytest.raises(InputError) as caught:
        simulate_free(four_dof(), np.zeros(4), np.full((2, 4), np.nan))
    assert [fault.split(" has ")[0] for fault in caught.value.faults] == [
        "initial displacement",
        "initial velocity is not finite",
    ]
    with pytest.raises(InputError, match="2 initial displacements but 1"):
        simulate_free(four_dof(), np.zeros((2, 4)), np.zeros((1, 4)))


@pytest.mark.parametrize(
    ("effect", "words"),
    [(CubicSpring((9,), "x", 1.0), "node 9 has no degree"), (CubicSpring((1,), "y", 1.0), "no degree of freedom 'y'")],
)
def test_refuses_effects_that_do_not_fit(effect: ConnectorEffect, words: str) -> None:
    with pytest.raises(InputError, match=words):
        simulate_free(linearise(four_dof()), np.zeros((1, 4)), np.zeros((1, 4)), SHORT, (effect,))


def test_refuses_steps_that_the_highest_mode_does_not_stand() -> None:
    size = linearise(bridge()).mass.shape[0]
    with pytest.raises(InputError, match="too long for the highest mode"):
        simulate_free(bridge(), np.zeros((1, size)), np.zeros((1, size)), FreeConfig(step=0.05))
    with pytest.raises(InputError, match="simulate a shorter time; or give a step"):
        simulate_free(bridge(), np.zeros((1, size)), np.zeros((1, size)))
    massless = replace(cantilever(section=replace(TIMBER, density=0.0)), point_masses=(PointMass(2, 1.0),))
    for integrator in ("rk67", "newmark"):
        config = FreeConfig(step=1e-3, integrator=integrator)
        with pytest.raises(InputError, match=r"1 of 3 free degrees of freedom have no mass \(node 2 in rz\)"):
            simulate_free(massless, np.zeros((1, 3)), np.zeros((1, 3)), config)


def test_without_a_step_free_motion_takes_one_that_a_stiff_effect_stands() -> None:
    """Friction damps the oscillator of 2 kg at rest within 2 kg * 1e-5 m/s / 2 N = 1e-5 s."""
    sliding = held_mass(100.0).with_effects(CoulombFriction((1,), "x", 2.0, 1e-5))
    config = FreeConfig(0.05, 100.0)
    found = simulate_free(sliding, np.array([[1.0]]), np.array([[0.0]]), config)
    finer = simulate_free(sliding, np.array([[1.0]]), np.array([[0.0]]), replace(config, step=2e-6))
    # One step of 5e-6 s in which it comes to slide, at 1 m/s^2 more or less, followed for 0.05 s.
    np.testing.assert_allclose(found.displacement, finer.displacement, atol=2.5e-7)
    with pytest.raises(InputError, match="an effect that at rest damps within 1e-05 s: choose at most 1e-05 s"):
        simulate_free(sliding, np.array([[1.0]]), np.array([[0.0]]), replace(config, step=1e-3))


def test_a_driven_chain_needs_no_step_of_newmarks_either() -> None:
    load = Load(1, "x", np.sin(np.arange(50.0) / 5))
    drive = drive_of(held_mass(100.0), (load,), 50.0)
    implicit = simulate_driven(held_mass(100.0), drive, FreeConfig(sampling_rate=50.0, integrator="newmark"))
    explicit = simulate_driven(held_mass(100.0), drive, FreeConfig(sampling_rate=50.0))
    largest = np.abs(explicit.displacement).max()
    # Frequencies 1e-4 too low: a phase of 1e-4 * 7.1 rad/s * 1 s; twice that where load and decay interfere.
    np.testing.assert_allclose(implicit.displacement, explicit.displacement, atol=2e-3 * largest)


def test_refuses_configurations_without_sense() -> None:
    with pytest.raises(InputError) as caught:
        simulate_free(four_dof(), np.zeros((1, 4)), np.zeros((1, 4)), FreeConfig(duration=-1.0, step=0.0))
    assert [fault.split(";")[0] for fault in caught.value.faults] == ["duration = -1.0", "step = 0.0"]
    with pytest.raises(InputError, match="nothing pulls"):
        simulate_release(bridge(), ())


def test_growth_without_bounds_is_an_error() -> None:
    runaway = CubicSpring((1,), "x", -50.0)
    with pytest.raises(InputError, match=r"grew beyond all bounds|no solution in one of its time steps"):
        simulate_free(four_dof(), np.full((1, 4), 3.0), np.zeros((1, 4)), SHORT, (runaway,))
