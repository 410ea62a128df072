"""The propagator's loop for nets of one layer, and its hand-written gradient.

Against the plain loop, torchdiffeq's eighth-order solver, the matrix exponential, autograd and finite differences.
"""

from collections.abc import Iterator

import numpy as np
import pytest
import torch
from scipy.linalg import expm
from torch import Tensor
from torchdiffeq import odeint

from hybrid.neural_modal_ode.dynamics import ModalDynamics
from hybrid.neural_modal_ode.integrators import propagate
from hybrid.neural_modal_ode.residuals.connector_residual import ConnectorResidual
from hybrid.neural_modal_ode.scaling import StateScale
from hybrid.neural_modal_ode.tanh_recursion import TanhRecursion
from tests.hybrid_problems import chain_modes, double_precision, observed_order
from tests.places_problems import SCALE, place_dynamics, plain_loop, random_states, state_matrix
from tests.test_places import crooked_modes

STEPS = (0.04, 0.02, 0.01, 0.005)  # s; the fastest mode turns 2 rad/s, the steepest net a few times faster
DURATION = 8.0  # s, a third of the slowest period and nearly three of the fastest


@pytest.fixture(autouse=True)
def _double() -> Iterator[None]:
    with double_precision():
        yield


def recursion(batch: int, state: int = 3, hidden: int = 2) -> list[Tensor]:
    """Random arguments of the recursion: z0, free, now, before, drift, into, bias."""
    generator = torch.Generator().manual_seed(7)
    shapes = [(batch, state), (state, state), (hidden, state), (hidden, state), (state,), (state, hidden), (hidden,)]
    return [(0.6 * torch.randn(shape, generator=generator)).requires_grad_() for shape in shapes]


def states_of(arguments: list[Tensor], samples: int) -> Tensor:
    states: Tensor = TanhRecursion.apply(*arguments, samples)  # type: ignore[no-untyped-call]
    return states


def loss_of(states: Tensor) -> Tensor:
    """A loss that weighs every number of every state differently."""
    weights = torch.linspace(0.2, 1.0, states.numel()).reshape(states.shape)
    return (weights * states.square() + weights.flip(0) * states).sum()


def gradients(dynamics: ModalDynamics, z0: Tensor, states: Tensor) -> list[Tensor]:
    return list(torch.autograd.grad(loss_of(states), [z0, *dynamics.parameters()]))


@pytest.mark.parametrize("samples", [1, 2, 3, 4, 30])
@pytest.mark.parametrize("batch", [1, 3])
def test_states_follow_the_recursion_as_it_is_written(samples: int, batch: int) -> None:
    """In NumPy, from the equation in the module's docstring; 1e-13: rounding of 30 products of matrices near one."""
    arguments = recursion(batch)
    z, free, now, before, drift, into, bias = (argument.detach().numpy() for argument in arguments)
    expected, h_before = [z], np.tanh(z @ into + bias)
    for _ in range(samples - 1):
        h = np.tanh(z @ into + bias)
        z, h_before = z @ free + h @ now + h_before @ before + drift, h
        expected.append(z)
    found = states_of(arguments, samples).detach().numpy()
    np.testing.assert_allclose(found, np.array(expected), rtol=0, atol=1e-13 * np.abs(expected).max())


@pytest.mark.parametrize("samples", [1, 2, 3, 6])
@pytest.mark.parametrize("batch", [1, 2])
def test_the_gradient_of_every_argument_is_that_of_finite_differences(samples: int, batch: int) -> None:
    """Entry by entry, of every state by every argument; central differences of step 1e-6 are good to 1e-8 here."""
    arguments = recursion(batch)
    assert torch.autograd.gradcheck(lambda *each: states_of(list(each), samples), arguments, atol=1e-7, rtol=1e-6)


def test_a_gradient_of_one_state_only_is_right_too() -> None:
    """Of the first, the second and the last alone: what is not asked for adds nothing; 1e-12 is rounding."""
    for chosen in (0, 1, 5):
        arguments = recursion(2)
        found = torch.autograd.grad(states_of(arguments, 6)[chosen].sum(), arguments)
        z0, free, now, before, drift, into, bias = arguments
        z, h_before = z0, torch.tanh(z0 @ into + bias)
        for _ in range(chosen):
            h = torch.tanh(z @ into + bias)
            z, h_before = z @ free + h @ now + h_before @ before + drift, h
        expected = torch.autograd.grad(z.sum(), arguments, allow_unused=True)
        for one, other, argument in zip(found, expected, arguments, strict=True):
            reference = torch.zeros_like(argument) if other is None else other
            torch.testing.assert_close(one, reference, rtol=0, atol=1e-12)


@pytest.mark.parametrize("samples", [1, 2, 3, 60])
@pytest.mark.parametrize("batch", [1, 3])
def test_the_propagator_of_nets_is_the_plain_loop(samples: int, batch: int) -> None:
    """States and the gradient by z0 and by the whole table, with a modal model that is off; 1e-11 is rounding."""
    dynamics = place_dynamics(crooked_modes())
    z0 = random_states(batch).requires_grad_()
    fast, plain = propagate(dynamics, z0, samples, 0.25), plain_loop(dynamics, z0, samples, 0.25)
    assert fast.shape == (batch, samples, 8)
    torch.testing.assert_close(fast, plain, rtol=0, atol=1e-12 * float(plain.detach().abs().max()))
    if samples > 1:
        pairs = zip(gradients(dynamics, z0, fast), gradients(dynamics, z0, plain), strict=True)
        for one, other in pairs:
            torch.testing.assert_close(one, other, rtol=0, atol=1e-11 * float(other.abs().max()))


def test_the_propagator_of_nets_has_the_gradient_of_finite_differences() -> None:
    """By z0 and by every number of the table: springs and dashpots act through the matrix exponential.

    1e-7 of the largest: central differences of step 1e-5 leave 1e-10 times third derivatives of a few hundred.
    """
    dynamics = place_dynamics(hidden=2)
    residual = dynamics.residual
    assert isinstance(residual, ConnectorResidual)
    z0 = random_states(2).requires_grad_()
    found = gradients(dynamics, z0, propagate(dynamics, z0, 13, 0.25))
    for leaf, gradient in zip([z0, residual.table], found, strict=True):
        slopes = torch.zeros(leaf.numel())
        for i in range(leaf.numel()):
            values = []
            for size in (1e-5, -1e-5):
                with torch.no_grad():
                    leaf.view(-1)[i] += size
                    values.append(float(loss_of(propagate(dynamics, z0, 13, 0.25))))
                    leaf.view(-1)[i] -= size
            slopes[i] = (values[0] - values[1]) / 2e-5
        torch.testing.assert_close(gradient.flatten(), slopes, rtol=0, atol=1e-7 * float(slopes.abs().max()))


def test_it_is_of_second_order_against_torchdiffeq() -> None:
    """dopri8 at a tolerance of 1e-12; 0.1: the error's next term is a tenth of the leading one at the largest step."""
    dynamics, z0 = place_dynamics(), random_states(2)
    with torch.no_grad():
        times = torch.tensor([0.0, DURATION])
        exact = odeint(dynamics, z0, times, method="dopri8", rtol=1e-12, atol=1e-12)[-1]
        ends = [propagate(dynamics, z0, round(DURATION / h) + 1, h)[:, -1] for h in STEPS]
    errors = [float((end - exact).abs().max()) for end in ends]
    assert observed_order(STEPS, errors) == pytest.approx(2.0, abs=0.1), errors
    assert errors[-1] < 1e-3  # of states near one


def test_its_gradient_is_of_second_order_against_torchdiffeq() -> None:
    """Autograd through rk4 with steps of 0.02 s is exact to 1e-6; 0.2 as gradients add up errors of all times."""
    dynamics, z0, steps = place_dynamics(), random_states(1).requires_grad_(), (0.1, 0.05, 0.025)

    def gradient(states: Tensor) -> Tensor:
        """By z0 and the table, of a loss of ``states`` (7, 1, 8) at every half second."""
        return torch.cat([part.flatten() for part in gradients(dynamics, z0, states)])

    exact = gradient(odeint(dynamics, z0, torch.linspace(0, 3, 151), method="rk4")[::25])
    errors = []
    for h in steps:
        states = propagate(dynamics, z0, round(3 / h) + 1, h).transpose(0, 1)[:: round(0.5 / h)]
        errors.append(float((gradient(states) - exact).abs().max()))
    assert observed_order(steps, errors) == pytest.approx(2.0, abs=0.2), errors


@pytest.mark.parametrize("step", [0.01, 0.5, 40.0])
@pytest.mark.parametrize("scale", [StateScale.unit(4), SCALE])
def test_without_nets_it_is_the_matrix_exponential_of_the_chain(step: float, scale: StateScale) -> None:
    """Of M, C and K in the masses' coordinates, for any step, from shapes that are off by 3 %.

    1e-9: `torch.matrix_exp` itself is good to 5e-12 where |A h| is near 0.03 (its polynomial of degree 8), to 1e-15
    elsewhere; 25 products add up.
    """
    modal = crooked_modes()
    dynamics = place_dynamics(modal, net=0.0, scale=scale)
    z0 = random_states(1)
    with torch.no_grad():
        q, q_dot = (part[0].numpy() for part in dynamics.unscale(propagate(dynamics, z0, 26, step)))
    found = np.hstack([q @ modal.shapes.T, q_dot @ modal.shapes.T])  # (time, 8)
    exact = np.array([expm(state_matrix() * step * k) @ found[0] for k in range(26)])
    np.testing.assert_allclose(found, exact, rtol=0, atol=1e-9 * np.abs(exact).max())


def test_at_rest_it_stays_and_so_does_its_gradient() -> None:
    """The nets' biases push, and what they push at rest is taken off again: to 1e-15 of their force, near one.

    The gradient by the table is that of a state at rest, which no parameter moves; and nothing is no number.
    """
    dynamics = place_dynamics()
    z0 = torch.zeros(2, 8, requires_grad=True)
    states = propagate(dynamics, z0, 200, 0.25)
    assert float(states.detach().abs().max()) < 1e-13
    by_state, by_table = torch.autograd.grad(states.sum(), [z0, *dynamics.parameters()])
    assert bool(torch.isfinite(by_state).all())
    assert float(by_state.abs().max()) > 1.0
    assert float(by_table.abs().max()) < 1e-10  # 200 samples of 16 states, adding up rounding


def test_windows_move_independently() -> None:
    dynamics, z0 = place_dynamics(), random_states(5)
    with torch.no_grad():
        together = propagate(dynamics, z0, 40, 0.25)
        alone = torch.cat([propagate(dynamics, z[None], 40, 0.25) for z in z0])
    torch.testing.assert_close(together, alone, rtol=0, atol=1e-13)  # one product of matrices, or several


def test_a_window_that_overflows_leaves_the_others_alone() -> None:
    """As a search meets them: one start far out of an unstable model, beside one at rest."""
    dynamics = place_dynamics(chain_modes(), net=0.0)
    assert isinstance(dynamics.residual, ConnectorResidual)
    dynamics.residual.set_coefficients(torch.full((7,), -1e4), torch.zeros(7))
    with torch.no_grad():
        states = propagate(dynamics, torch.cat([torch.zeros(1, 8), random_states(1)]), 60, 0.5)
    assert not bool(torch.isfinite(states[1]).all())
    assert bool((states[0] == 0).all())


def test_in_single_precision_it_is_the_same_motion() -> None:
    """1e-4: 24 bits are 6e-8, and 400 steps of a structure that hardly forgets add up to some hundred of them."""
    exact = propagate(place_dynamics(), random_states(2), 400, 0.25)
    found = propagate(place_dynamics().float(), random_states(2).float(), 400, 0.25)
    assert found.dtype == torch.float32
    torch.testing.assert_close(found.double(), exact, rtol=0, atol=1e-4)
