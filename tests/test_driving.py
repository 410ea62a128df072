"""Known forces in the modal ODE: exact for what they are between samples, against closed forms and scipy's DOP853."""

from collections.abc import Iterator
from math import factorial

import numpy as np
import pytest
import torch
from scipy.integrate import solve_ivp
from torch import Tensor

from fe_models.arrays import FloatArray
from fe_models.causes import CubicSpring
from fe_models.dof_map import DofMap
from fe_models.interpolant import courses_of, interpolant
from fe_models.linear import ModalModel
from hybrid.neural_modal_ode.driving import Driving
from hybrid.neural_modal_ode.dynamics import ModalDynamics
from hybrid.neural_modal_ode.integrators import integrate, propagate, pushes_of
from hybrid.neural_modal_ode.residuals.free_residual import NoResidual
from hybrid.neural_modal_ode.scaling import StateScale
from hybrid.neural_modal_ode.tanh_recursion import TanhRecursion
from tests.hybrid_problems import chain_modes, double_precision, dynamics_of, observed_order
from tests.places_problems import place_dynamics, plain_loop, random_states

SAMPLES = 40
STEPS = (0.04, 0.02, 0.01)  # s


@pytest.fixture(autouse=True)
def _double() -> Iterator[None]:
    with double_precision():
        yield


def driving_of(values: FloatArray, participation: FloatArray) -> Driving:
    """Forces with ``values`` (time, place) on one window, which no sensor shows."""
    courses = torch.tensor(courses_of(values[None], 1.0)).permute(1, 2, 0, 3)
    return Driving(courses, torch.tensor(participation), torch.zeros(1, len(values), 1))


def one_mass(omega: float, ratio: float) -> ModalDynamics:
    dofs = DofMap(np.array([1]), np.array(["x"]), np.array([True]))
    modal = ModalModel(np.array([omega]), np.array([ratio]), np.ones((1, 1)), dofs)
    return ModalDynamics(modal, (), StateScale(np.array([0.3]), np.array([2.0])), NoResidual(1))


def polynomial_response(omega: float, ratio: float, force: FloatArray, time: FloatArray) -> FloatArray:
    """Q and q' (time, 2) from rest of q'' + 2 xi w q' + w^2 q = sum of ``force``_p t^p, in closed form."""
    degree = len(force) - 1
    c = np.zeros(degree + 3)  # of the particular solution, from the highest power down
    for p in range(degree, -1, -1):
        c[p] = (force[p] - 2 * ratio * omega * (p + 1) * c[p + 1] - (p + 1) * (p + 2) * c[p + 2]) / omega**2
    powers = time[:, None] ** np.arange(degree + 1)
    rates = np.arange(degree + 1) * time[:, None] ** np.maximum(np.arange(degree + 1) - 1, 0)
    s, damped = ratio * omega, omega * np.sqrt(1 - ratio**2)
    decay, cos, sin = np.exp(-s * time), np.cos(damped * time), np.sin(damped * time)
    a, b = -c[0], (-c[1] - s * c[0]) / damped  # q(0) = q'(0) = 0
    q = decay * (a * cos + b * sin) + powers @ c[: degree + 1]
    rate = decay * ((b * damped - s * a) * cos - (a * damped + s * b) * sin) + rates @ c[: degree + 1]
    return np.column_stack([q, rate])


@pytest.mark.parametrize("substeps", [1, 3])
@pytest.mark.parametrize("step", [0.01, 0.3, 2.5])
def test_one_mass_under_a_polynomial_of_degree_seven_follows_the_closed_form(step: float, substeps: int) -> None:
    """A degree of seven is what a load is between samples; 2.5 s are five radians. 1e-9: seventh powers of 40 samples
    lose six digits of sixteen.
    """
    omega, ratio = 2.0, 0.05
    time: FloatArray = step * np.arange(SAMPLES, dtype=np.float64)
    sizes = [(-1) ** p * factorial(7) / factorial(p) / time[-1] ** p / 1e3 for p in range(8)]
    force: FloatArray = np.array(sizes, dtype=np.float64)
    dynamics = one_mass(omega, ratio)
    values = (time[:, None] ** np.arange(8)) @ force
    z = integrate(
        dynamics, torch.zeros(1, 2), SAMPLES, step, "propagator", substeps, driving_of(values[:, None], np.ones((1, 1)))
    )
    found = np.column_stack([part[0, :, 0] for part in dynamics.unscale(z)])
    exact = polynomial_response(omega, ratio, force, time)
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-9 * np.abs(exact).max())


def random_forces(step: float, duration: float = 8.0, knots: float = 0.4) -> FloatArray:
    """Two forces (time, place) at samples a ``step`` apart: one course, whatever the step."""
    rng = np.random.default_rng(5)
    nodes = np.arange(0.0, duration + 8 * knots, knots)
    course = interpolant(rng.standard_normal((len(nodes), 2)))
    return np.asarray(course((step * np.arange(round(duration / step) + 1) + 2 * knots) / knots))


def solved(dynamics: ModalDynamics, values: FloatArray, participation: FloatArray, step: float) -> FloatArray:
    """The state at the last sample by DOP853, to about 1e-10, the forces as their splines."""
    course = interpolant(values)

    @torch.no_grad()
    def rate(time: float, z: FloatArray) -> FloatArray:
        known = course(time / step) @ participation / dynamics.b.numpy()
        return np.asarray(dynamics(torch.zeros(()), torch.tensor(z)[None])[0]) + np.concatenate([0 * known, known])

    start = np.linspace(-0.5, 0.5, 2 * dynamics.modes)
    return np.asarray(
        solve_ivp(rate, (0.0, step * (len(values) - 1)), start, "DOP853", rtol=1e-10, atol=1e-11).y[:, -1]
    )


PARTICIPATION = np.random.default_rng(2).standard_normal((2, 4))


def last_state(dynamics: ModalDynamics, values: FloatArray, step: float, method: str, substeps: int = 1) -> FloatArray:
    start = torch.linspace(-0.5, 0.5, 2 * dynamics.modes)[None]
    driving = driving_of(values, PARTICIPATION)
    with torch.no_grad():
        z = integrate(dynamics, start, len(values), step, method, substeps, driving)  # type: ignore[arg-type]
    return np.asarray(z[0, -1].numpy())


@pytest.mark.parametrize("step", [0.1, 0.4])
def test_a_linear_chain_under_two_forces_is_exact_at_any_step(step: float) -> None:
    """1e-9: what DOP853 leaves over twenty to eighty steps."""
    dynamics = dynamics_of(chain_modes(0.02), scale=StateScale(np.full(4, 0.5), np.full(4, 2.0)))
    values = random_forces(step)
    found = last_state(dynamics, values, step, "propagator", 2)
    np.testing.assert_allclose(found, solved(dynamics, values, PARTICIPATION, step), rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("method", "order", "slack"), [("propagator", 2.0, 0.15), pytest.param("rk4", 4.0, 0.3, marks=pytest.mark.slow)]
)
def test_with_a_cubic_spring_the_orders_are_those_of_free_motion(method: str, order: float, slack: float) -> None:
    """The slack: the error's next term at the largest step, where forces move within a step."""
    dynamics = dynamics_of(chain_modes(), (CubicSpring((1,), "x", 1.0),))
    steps = [step * (2.5 if method == "rk4" else 1) for step in STEPS]
    errors = []
    for step in steps:
        values = random_forces(step)
        truth = solved(dynamics, values, PARTICIPATION, step)
        errors.append(float(np.abs(last_state(dynamics, values, step, method) - truth).max()))
    assert observed_order(steps, errors) == pytest.approx(order, abs=slack), errors


def test_dopri5_keeps_its_tolerance_under_forces() -> None:
    """1e-4: a hundred times its own for a motion of eight seconds."""
    dynamics = dynamics_of(chain_modes(), (CubicSpring((1,), "x", 1.0),))
    values = random_forces(0.1)
    found = last_state(dynamics, values, 0.1, "dopri5")
    np.testing.assert_allclose(found, solved(dynamics, values, PARTICIPATION, 0.1), rtol=0, atol=1e-4)


def test_responses_to_two_forces_add_up_and_one_window_does_not_touch_another() -> None:
    dynamics, step = dynamics_of(chain_modes()), 0.1
    values = random_forces(step)
    alone = [values * mask for mask in ([1.0, 0.0], [0.0, 1.0])]
    three = [driving_of(part, PARTICIPATION) for part in (*alone, values)]
    together = Driving(torch.cat([each.courses for each in three]), three[0].participation, torch.zeros(3, 1, 1))
    with torch.no_grad():
        first, second, both = integrate(
            dynamics, torch.zeros(3, 8), len(values), step, "propagator", driving=together
        ).numpy()
    np.testing.assert_allclose(first + second, both, rtol=0, atol=1e-13 * np.abs(both).max())
    assert np.abs(first - both).max() > 0.1 * np.abs(both).max()


def test_nets_at_places_feel_the_forces_as_the_plain_loop_does() -> None:
    """1e-12: rounding of 60 steps of sums in another order."""
    dynamics, step, substeps = place_dynamics(), 0.1, 2
    states = random_states(1)
    values = random_forces(step, 3.0)
    pushes = pushes_of(dynamics, driving_of(values, PARTICIPATION), step, substeps)
    with torch.no_grad():
        found = propagate(dynamics, states, pushes.shape[1] + 1, step / substeps, pushes)
        expected = plain_loop(dynamics, states, pushes.shape[1] + 1, step / substeps, pushes)
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12 * float(expected.abs().max()))


def test_the_gradient_of_the_pushes_is_that_of_finite_differences() -> None:
    generator = torch.Generator().manual_seed(7)
    shapes = [(2, 3), (3, 3), (2, 3), (2, 3), (3,), (3, 2), (2,)]
    arguments = [0.6 * torch.randn(shape, generator=generator) for shape in shapes]
    pushes = torch.randn(4, 2, 3, generator=generator).requires_grad_()

    def states(pushed: Tensor) -> Tensor:
        found: Tensor = TanhRecursion.apply(*arguments, 5, pushed)  # type: ignore[no-untyped-call]
        return found

    assert torch.autograd.gradcheck(states, (pushes,), atol=1e-7, rtol=1e-6)
