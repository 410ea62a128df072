"""The hysteretic spring against closed forms and an independent integrator."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import HystereticSpring
from fe_models.causes.laws import force_laws
from fe_models.damping import full_damping
from fe_models.errors import InputError
from fe_models.files.structure_file import load_structure, save_structure
from fe_models.modes import natural_modes
from fe_models.recordings import Dataset, Recording, Sensor
from fe_models.simulation import FreeConfig, ReleaseConfig, simulate_free, simulate_release
from fe_models.statics import PointLoad, rest_state
from fe_models.structure import Damping, Spring, Support
from hybrid.diagnosis.nominal.structure_model import nominal_model_of
from hybrid.neural_modal_ode.dynamics import ModalDynamics
from hybrid.neural_modal_ode.residuals.free_residual import NoResidual
from hybrid.neural_modal_ode.scaling import StateScale
from tests.problems import held_mass

STIFFNESS, MASS = 100.0, 2.0  # of `held_mass`


def swing(spring: HystereticSpring, duration: float, config: FreeConfig, start: float = 1.0) -> FloatArray:
    """Displacement (time,) of the held mass, without damping, let go at ``start``."""
    structure = held_mass(STIFFNESS).with_effects(spring)
    config = replace(config, duration=duration)
    return simulate_free(structure, np.array([[start]]), np.zeros((1, 1)), config, progress=False).displacement[0, :, 0]


@pytest.mark.parametrize(("nodes", "pull"), [((2,), (0, 1, 0, 0)), ((1, 3), (-1, 0, 1, 0))])
def test_chain_follows_an_independent_integrator(nodes: tuple[int] | tuple[int, int], pull: tuple[float, ...]) -> None:
    structure = four_dof().with_effects(HystereticSpring(nodes, "x", 2.0, 0.6, 3.0))
    model, along = linearise(structure), np.array(pull, dtype=float)
    M, C, K = model.mass.toarray(), full_damping(model), model.stiffness.toarray()
    x0, v0 = np.array([1.0, -0.6, 0.8, 0.5]), np.array([0.2, 0.4, -0.5, 0.1])
    found = simulate_free(structure, x0[None], v0[None], FreeConfig(4.0, 20.0, 0.01), progress=False)

    def rates(_: float, y: FloatArray) -> FloatArray:  # the law as Wen writes it
        x, v, z = y[:4], y[4:8], y[8]
        u, reach = along @ v, 0.3
        bent = 0.5 * abs(u) * abs(z) ** 2 * z / reach**3 + 0.5 * u * abs(z) ** 3 / reach**3
        return np.concatenate([v, -np.linalg.solve(M, C @ v + K @ x + 2.0 * z * along), [u - bent]])

    begun = solve_ivp(lambda _, z: 1 - (z / 0.3) ** 3, (0.0, abs(along @ x0)), [0.0], rtol=1e-11, atol=1e-13).y[0, -1]
    start = np.concatenate([x0, v0, [np.sign(along @ x0) * begun]])
    y = solve_ivp(rates, (0.0, 4.0), start, t_eval=found.time, rtol=1e-10, atol=1e-12, max_step=1e-2).y.T
    # Where motion turns z' has a jump of its slope: order 2 there, though the integrator has 6.
    np.testing.assert_allclose(found.displacement[0], y[:, :4], atol=5e-6)
    np.testing.assert_allclose(found.velocity[0], y[:, 4:8], atol=2e-5)
    accelerations = np.array([rates(0.0, state)[4:8] for state in y])
    np.testing.assert_allclose(found.acceleration[0], accelerations, atol=2e-5)


def test_small_motion_feels_a_spring() -> None:
    """A thousandth of the force that slides bends it, sharp as it is, by 1e-3^8: the frequency is that of k + 100."""
    x = swing(HystereticSpring((1,), "x", 44.0, 44.0, 8.0), 1.0, FreeConfig(1.0, 100.0, 0.005), start=1e-3)
    exact = 1e-3 * np.cos(np.sqrt(144.0 / MASS) * np.linspace(0.0, 1.0, 101))
    np.testing.assert_allclose(x, exact, atol=1e-9)


def test_a_slider_takes_what_the_closed_form_says() -> None:
    """From a to -b: K (a^2 - b^2) / 2 = F (a + b - 2 F / k), as it slides but for 2 F / k of the way."""
    slides, reach = 6.0, 0.1
    x = swing(HystereticSpring((1,), "x", slides / reach, slides, 100.0), 1.3, FreeConfig(1.3, 1000.0, 1e-3))
    turns = [abs(own) for own in x[1:-1][(np.diff(x)[1:] * np.diff(x)[:-1]) <= 0]]
    a = 1.0
    for turn in turns[:3]:
        b = brentq(lambda b, a=a: STIFFNESS * (a**2 - b**2) / 2 - slides * (a + b - 2 * reach), 0.0, a)
        # Steps may lead 2 % beyond what slides: 2 F / K = 0.12 m a swing, of which that is 2.4e-3 m.
        assert turn == pytest.approx(b, abs=2.4e-3)
        a = b
    assert a < 0.8  # it slid in both swings


def test_work_of_a_cycle_is_that_of_jenkins_element() -> None:
    """4 F (A - F / k), by Wen's equation alone, along a steady cycle."""
    spring, amplitude = HystereticSpring((1,), "x", 50.0, 5.0, 200.0), 0.4
    time = np.linspace(0.0, 4 * np.pi, 4_001)
    z = [0.0]
    for v in amplitude * np.cos(0.5 * (time[1:] + time[:-1])):
        step = time[1] * v
        z.append(float(np.clip(z[-1] + step * spring.rate(1.0, z[-1] * np.sign(step)), -0.1, 0.1)))
    last = slice(2_000, None)
    work = np.trapezoid(spring.force_of(np.array(z)[last]), amplitude * np.sin(time[last]))
    assert work == pytest.approx(4 * 5.0 * (amplitude - 0.1), rel=4e-3)  # a corner that is rounded over reach / 200


def test_slow_pull_goes_along_the_closed_forms() -> None:
    u = np.linspace(-3.0, 3.0, 61)
    smooth, usual = (HystereticSpring((1,), "x", 2.0, 1.0, n) for n in (1.0, 2.0))
    np.testing.assert_allclose(smooth.pulled_to(u), 0.5 * np.sign(u) * (1 - np.exp(-np.abs(u) / 0.5)), atol=1e-9)
    np.testing.assert_allclose(usual.pulled_to(u), 0.5 * np.tanh(u / 0.5), atol=1e-9)
    assert float(smooth.pulled_to(1e6)) == pytest.approx(0.5)
    assert float(usual.pulled_to(0.0)) == 0.0


def test_trapezoidal_rule_has_order_two() -> None:
    spring = HystereticSpring((1,), "x", 40.0, 10.0, 2.0)
    exact = swing(spring, 0.5, FreeConfig(0.5, 50.0, 1e-3))
    errors = [np.abs(swing(spring, 0.5, FreeConfig(0.5, 50.0, step, "newmark")) - exact).max() for step in (1e-2, 5e-3)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)


def test_a_release_under_gravity_starts_where_the_pull_led() -> None:
    """At rest it is silent; pulled, it carries what a slow pull leaves it; let go, it moves as about rest."""
    spring = HystereticSpring((1,), "y", 60.0, 3.0, 2.0)
    structure = replace(
        held_mass(), elements=(Spring((1,), "y", 100.0),), supports=(Support(1, ("x",)),), directions=("x", "y")
    )
    structure = replace(structure, damping=Damping(stiffness_factor=2e-3)).with_effects(spring)
    np.testing.assert_allclose(rest_state(structure), [0.0, -MASS * 9.81 / 100.0], rtol=1e-9)
    released = simulate_release(structure, (PointLoad(1, "y", 12.0),), ReleaseConfig(0.8, 200.0, 2e-3), progress=False)
    start = released.displacement[0, 1]
    assert 100.0 * start + 3.0 * np.tanh(start / 0.05) == pytest.approx(12.0, abs=1e-6)  # Newton's tolerance
    config = FreeConfig(0.8, 200.0, 1e-3)
    free = simulate_free(structure, np.array([[start]]), np.zeros((1, 1)), config, progress=False)
    # The trapezoidal rule: (omega h)^2 / 12 in the period, 4e-5 times 7 rad.
    np.testing.assert_allclose(released.displacement[:, 1], free.displacement[0, :, 1], atol=5e-4 * start)


def test_it_goes_to_a_file_and_back(tmp_path: Path) -> None:
    structure = four_dof().with_effects(HystereticSpring((1, 2), "x", 2.0, 0.6, 3.0))
    save_structure(structure, tmp_path / "chain.toml")
    assert load_structure(tmp_path / "chain.toml") == structure


def test_faults_of_all_parameters_are_told_at_once() -> None:
    assert len(HystereticSpring((9,), "x", -2.0, 0.0, 0.0).faults(four_dof())) == 4


def test_steps_that_are_too_long_are_refused() -> None:
    with pytest.raises(InputError, match="too long for the hysteretic_spring"):
        swing(HystereticSpring((1,), "x", 100.0, 0.1, 100.0), 0.5, FreeConfig(0.5, 50.0, 0.02))


def test_what_cannot_take_a_memory_along_says_so() -> None:
    structure = four_dof().with_effects(HystereticSpring((1,), "x", 2.0, 0.6, 3.0))
    sensor = Sensor("x4", 4, "x", "displacement", "m")
    dataset = Dataset(structure, 10.0, (sensor,), (Recording("r", np.zeros((1, 50, 1)), "train"),))
    with pytest.raises(InputError, match="its own hysteretic_spring has a memory"):
        nominal_model_of(dataset)
    modal = natural_modes(linearise(structure), 4)
    scale = StateScale(np.ones(4), np.ones(4))
    with pytest.raises(InputError, match="no force with a memory, and the structure has hysteretic_spring"):
        ModalDynamics(modal, force_laws(structure), scale, NoResidual(4))
