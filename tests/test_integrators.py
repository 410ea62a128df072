"""The propagator and torchdiffeq's solvers against the matrix exponential, closed forms and scipy's DOP853."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
import torch
from scipy.linalg import expm
from torch import Tensor

from fe_models.arrays import FloatArray
from fe_models.causes import CubicSpring
from hybrid.config import IntegratorKind
from hybrid.neural_modal_ode.dynamics import ModalDynamics
from hybrid.neural_modal_ode.integrators import integrate, propagate
from hybrid.neural_modal_ode.residuals.free_residual import FreeResidual, NoResidual
from hybrid.neural_modal_ode.scaling import StateScale
from tests.hybrid_problems import chain_modes, decay, double_precision, dynamics_of, last_layer, observed_order, solved

DURATION = 8.0  # s, a third of the slowest period and nearly three of the fastest
RK4_STEPS = (0.2, 0.1, 0.05, 0.025)  # s
PROPAGATOR_STEPS = (0.04, 0.02, 0.01, 0.005)  # s
START = np.array([0.8, -0.5, 0.3, 0.2, -0.1, 0.6, -0.4, 0.5])


@pytest.fixture(autouse=True)
def _double() -> Iterator[None]:
    with double_precision():
        yield


def start() -> Tensor:
    return torch.tensor(START)[None]


def nonlinear(kind: str) -> ModalDynamics:
    """The chain with a network, or with a cubic spring at mass 1."""
    if kind == "net":
        return dynamics_of(chain_modes(), net=0.3)
    return dynamics_of(chain_modes(), (CubicSpring((1,), "x", 1.0),))


def order_of(dynamics: ModalDynamics, method: IntegratorKind, steps: tuple[float, ...]) -> tuple[float, list[float]]:
    """The order that the largest error of the state at the end falls with, and these errors."""
    truth = solved(dynamics, START, np.array([0.0, DURATION]))[-1]
    with torch.no_grad():
        ends = [integrate(dynamics, start(), round(DURATION / h) + 1, h, method)[0, -1] for h in steps]
    errors = [float(np.abs(end.numpy() - truth).max()) for end in ends]
    return observed_order(steps, errors), errors


@pytest.mark.parametrize("step", [0.01, 0.5, 40.0])
def test_without_a_force_the_propagator_is_the_matrix_exponential(step: float) -> None:
    """Whatever the step, and with a coupled learned rest and scales; 1e-12 is the rounding of 25 products."""
    scale = StateScale(np.array([0.5, 1.0, 2.0, 3.0]), np.array([1.0, 0.3, 4.0, 0.7]))
    dynamics = dynamics_of(chain_modes(0.05), scale=scale)
    with torch.no_grad():
        assert isinstance(dynamics.residual, FreeResidual)
        dynamics.residual.rest.weight.copy_(0.01 * torch.randn(4, 8, generator=torch.Generator().manual_seed(0)))
        states = propagate(dynamics, start(), 26, step)[0].numpy()
    A = dynamics.linear_part().detach().numpy()
    exact = np.array([expm(A * step * k) @ START for k in range(26)])
    np.testing.assert_allclose(states, exact, rtol=0, atol=1e-12 * np.abs(exact).max())


@pytest.mark.parametrize("kind", ["net", "cubic spring"])
def test_the_propagator_is_of_second_order(kind: str) -> None:
    """0.1: the error's next term is a tenth of the leading one at the largest step."""
    order, errors = order_of(nonlinear(kind), "propagator", PROPAGATOR_STEPS)
    assert order == pytest.approx(2.0, abs=0.1), errors


@pytest.mark.parametrize("kind", ["net", "cubic spring"])
def test_rk4_is_of_fourth_order(kind: str) -> None:
    order, errors = order_of(nonlinear(kind), "rk4", RK4_STEPS)
    assert order == pytest.approx(4.0, abs=0.2), errors


def test_dopri5_keeps_its_tolerance() -> None:
    """1e-6 a step in the rms of eight states near one; some 40 steps, nearly all in one state, may add up to 1e-4."""
    for kind in ("net", "cubic spring"):
        dynamics = nonlinear(kind)
        times = np.linspace(0.0, 8.0, 17)
        states = integrate(dynamics, start(), 17, 0.5, "dopri5")[0].detach().numpy()
        np.testing.assert_allclose(states, solved(dynamics, START, times), rtol=0, atol=1e-4)


def test_all_windows_of_a_batch_move_independently() -> None:
    dynamics = nonlinear("net")
    both = torch.cat([start(), -0.3 * start()])
    with torch.no_grad():
        for method in ("propagator", "rk4"):
            together = integrate(dynamics, both, 9, 0.5, method)
            alone = torch.cat([integrate(dynamics, z[None], 9, 0.5, method) for z in both])
            assert together.shape == (2, 9, 8)
            assert torch.allclose(together, alone, rtol=0, atol=1e-14)  # one product of matrices or two


@pytest.mark.slow
def test_without_damping_the_energy_stays_for_1e5_steps() -> None:
    """E = (q'^2 + w^2 q^2) / 2 a mode. Each step rounds by 1e-16 and a bit, all to one side at worst: 1e-9."""
    modal = chain_modes(0.0)
    dynamics = dynamics_of(modal)
    dynamics.residual = NoResidual(4)  # or 1e5 evaluations of a net that gives zero
    with torch.no_grad():
        states = propagate(dynamics, start(), 100_001, 1.0)[0].numpy()
    q, q_dot = states[:, :4], states[:, 4:]
    energy = 0.5 * (q_dot**2 + (modal.omega * q) ** 2)  # (time, mode)
    np.testing.assert_allclose(energy, np.broadcast_to(energy[0], energy.shape), rtol=1e-9)


def test_damping_shrinks_the_amplitude_as_exp_minus_xi_omega_t() -> None:
    """The envelope sqrt(q^2 + ((q' + xi w q) / wd)^2) is free of the phase; 1e-12 is rounding."""
    xi, samples, step = 0.03, 200, 0.7
    modal = chain_modes(xi)
    with torch.no_grad():
        states = propagate(dynamics_of(modal), start(), samples, step)[0].numpy()
    q, q_dot = states[:, :4], states[:, 4:]
    envelope = np.hypot(q, (q_dot + xi * modal.omega * q) / (modal.omega * np.sqrt(1 - xi**2)))
    expected = envelope[0] * np.exp(-xi * modal.omega * step * np.arange(samples)[:, None])
    np.testing.assert_allclose(envelope, expected, rtol=1e-12)


def test_the_propagator_gives_modal_superposition() -> None:
    modal = replace(chain_modes(), damping_ratio=np.array([0.01, 0.02, 0.05, 0.2]))
    exact = decay(modal, START[None, :4], START[None, 4:], 0.5, 60)
    with torch.no_grad():
        states = propagate(dynamics_of(modal), start(), 60, 0.5)[0].numpy()
    np.testing.assert_allclose(states, np.concatenate([exact.q, exact.q_dot], -1)[0], rtol=0, atol=1e-12)


def loss_of(dynamics: ModalDynamics, z0: Tensor, method: IntegratorKind, step: float, duration: float = 3.0) -> Tensor:
    """A loss that weighs every state at every half second differently."""
    every = round(0.5 / step)
    states = integrate(dynamics, z0, round(duration / step) + 1, step, method)[:, ::every]
    weights = torch.linspace(0.2, 1.0, states.numel()).reshape(states.shape)
    return (weights * states**2).sum()


def gradient_of(dynamics: ModalDynamics, method: IntegratorKind, step: float) -> FloatArray:
    z0 = start().requires_grad_()
    dynamics.zero_grad()
    loss_of(dynamics, z0, method, step).backward()
    leaves = [z0, *dynamics.parameters()]
    return np.concatenate([leaf.grad.numpy().ravel() for leaf in leaves if leaf.grad is not None])


def test_gradients_of_the_propagator_are_those_of_finite_differences() -> None:
    """Central differences along random directions of z0 and of all weights; 1e-7: eps^(2/3), and some room."""
    dynamics, generator = nonlinear("net"), torch.Generator().manual_seed(1)
    z0 = start().requires_grad_()
    leaves: list[Tensor] = [z0, *dynamics.parameters()]
    gradients = torch.autograd.grad(loss_of(dynamics, z0, "propagator", 0.25), leaves)
    for leaf, gradient in zip(leaves, gradients, strict=True):
        direction = torch.randn(leaf.shape, generator=generator)

        def moved(size: float, leaf: Tensor = leaf, direction: Tensor = direction) -> float:
            with torch.no_grad():
                leaf += size * direction
                value = float(loss_of(dynamics, z0, "propagator", 0.25))
                leaf -= size * direction
            return value

        slope = (moved(1e-5) - moved(-1e-5)) / 2e-5
        assert float((gradient * direction).sum()) == pytest.approx(slope, rel=1e-7, abs=1e-8)


def test_gradients_converge_to_those_of_rk4_with_tiny_steps() -> None:
    """In the second order of the step, like the states."""
    dynamics, steps = nonlinear("net"), (0.1, 0.05, 0.025)
    exact = gradient_of(dynamics, "rk4", 0.01)
    errors = [float(np.abs(gradient_of(dynamics, "propagator", h) - exact).max()) for h in steps]
    assert observed_order(steps, errors) == pytest.approx(2.0, abs=0.2), errors


def test_the_adjoint_of_dopri5_gives_the_same_gradients() -> None:
    """1e-4: the adjoint integrates back with a tolerance of 1e-6 an interval, of gradients near ten."""
    dynamics = nonlinear("net")
    exact, adjoint = gradient_of(dynamics, "rk4", 0.01), gradient_of(dynamics, "dopri5", 0.5)
    np.testing.assert_allclose(adjoint, exact, rtol=0, atol=1e-4 * np.abs(exact).max())


def test_rest_is_kept_by_a_network_that_is_zero_at_rest() -> None:
    dynamics = nonlinear("net")
    with torch.no_grad():
        last_layer(dynamics).bias.fill_(2.0)
        assert float(propagate(dynamics, torch.zeros(1, 8), 50, 0.5).abs().max()) == 0.0
