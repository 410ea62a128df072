"""The latent ODE: its fixed physics against matrices and DOP853, its scales, and what it gives at rest."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
import torch
from scipy.integrate import solve_ivp

from fe_models.arrays import FloatArray
from fe_models.causes import CubicSpring
from hybrid.neural_modal_ode.dynamics import ModalDynamics, effect_shape
from hybrid.neural_modal_ode.integrators import propagate
from hybrid.neural_modal_ode.residuals.free_residual import FreeResidual
from hybrid.neural_modal_ode.scaling import StateScale
from tests.hybrid_problems import MASS, STIFFNESS, chain_modes, double_precision, dynamics_of, last_layer

RATIO = 0.04
BETWEEN = CubicSpring((2, 4), "x", 0.7)
TO_GROUND = CubicSpring((1,), "x", 0.5)


@pytest.fixture(autouse=True)
def _double() -> Iterator[None]:
    with double_precision():
        yield


def chain_damping() -> FloatArray:
    """C = M Phi diag(2 xi w) Phi^T M, which gives all modes the same damping ratio."""
    modal = chain_modes(RATIO)
    weighted = MASS @ modal.shapes
    return np.asarray(weighted * (2 * RATIO * modal.omega) @ weighted.T)


def chain_rate(x: FloatArray, v: FloatArray) -> FloatArray:
    """Acceleration of the chain with both cubic springs, from M, C and K, shape (dof,)."""
    pulled = np.zeros(4)
    pulled[0] = 0.5 * x[0] ** 3
    stretch = x[3] - x[1]
    pulled[3] += 0.7 * stretch**3
    pulled[1] -= 0.7 * stretch**3
    return np.asarray(np.linalg.solve(MASS, -chain_damping() @ v - STIFFNESS @ x - pulled))


def test_linear_part_is_the_state_matrix() -> None:
    modal = chain_modes(RATIO)
    A = dynamics_of(modal).linear_part().detach().numpy()
    expected = np.block([[np.zeros((4, 4)), np.eye(4)], [-np.diag(modal.omega**2), -np.diag(2 * RATIO * modal.omega)]])
    np.testing.assert_allclose(A, expected, rtol=1e-15)


def test_force_of_cubic_springs_is_phi_b_k_elongation_cubed() -> None:
    """Phi^T b k (b^T Phi q)^3 with b = (0, -1, 0, 1) between two nodes and (1, 0, 0, 0) to the ground."""
    modal = chain_modes()
    q = np.random.default_rng(0).standard_normal((5, 4))
    found = dynamics_of(modal, (BETWEEN, TO_GROUND)).force(torch.tensor(np.hstack([q, q]))).detach().numpy()
    expected = np.zeros((5, 4))
    for b, k in ((np.array([0, -1.0, 0, 1.0]), 0.7), (np.array([1.0, 0, 0, 0]), 0.5)):
        shape = b @ modal.shapes
        expected -= k * (q @ shape)[:, None] ** 3 * shape
    np.testing.assert_allclose(found, expected, rtol=1e-12)  # rounding
    np.testing.assert_allclose(effect_shape(modal, BETWEEN), modal.shapes[3] - modal.shapes[1])


def test_four_modes_with_cubic_springs_move_as_the_whole_chain() -> None:
    """All modes are kept, so that only the step's error is left: 2e-5 at 0.005 s, four times that at 0.01 s."""
    modal = chain_modes(RATIO)
    x0, v0 = np.array([1.0, -0.6, 0.8, 0.5]), np.array([0.2, 0.4, -0.5, 0.1])
    step, samples = 0.005, 2001

    def rates(_: float, state: FloatArray) -> FloatArray:
        return np.concatenate([state[4:], chain_rate(state[:4], state[4:])])

    times = step * np.arange(samples)
    start = np.concatenate([x0, v0])
    truth = solve_ivp(rates, (0, times[-1]), start, "DOP853", times, rtol=1e-11, atol=1e-12).y.T
    z0 = np.concatenate([modal.shapes.T @ MASS @ x0, modal.shapes.T @ MASS @ v0])
    dynamics = dynamics_of(modal, (BETWEEN, TO_GROUND))
    with torch.no_grad():
        z = propagate(dynamics, torch.tensor(z0)[None], samples, step)
        q, q_dot = (part[0].numpy() for part in dynamics.unscale(z))
        q_ddot = dynamics.acceleration(z, dynamics.force(z))[0].numpy()
    np.testing.assert_allclose(q @ modal.shapes.T, truth[:, :4], rtol=0, atol=5e-5)
    np.testing.assert_allclose(q_dot @ modal.shapes.T, truth[:, 4:], rtol=0, atol=5e-5)
    accelerations = np.array([chain_rate(state[:4], state[4:]) for state in truth])
    np.testing.assert_allclose(q_ddot @ modal.shapes.T, accelerations, rtol=0, atol=2e-4)  # K / M is up to 5


def test_scales_change_numbers_but_not_the_motion() -> None:
    """The state is [q / a, q' / b]: physics in any scale is the same, springs included; 1e-12 is rounding."""
    modal = chain_modes(RATIO)
    scale = StateScale(np.array([0.1, 2.0, 0.5, 7.0]), np.array([3.0, 0.2, 1.0, 0.6]))
    q, q_dot = torch.randn(2, 1, 4, generator=torch.Generator().manual_seed(0))
    motions = []
    for each in (StateScale.unit(4), scale):
        dynamics = dynamics_of(modal, (TO_GROUND,), scale=each)
        z0 = torch.cat([q / dynamics.a, q_dot / dynamics.b], dim=-1)
        with torch.no_grad():
            z = propagate(dynamics, z0, 40, 0.1)
            motions.append(torch.cat([*dynamics.unscale(z), dynamics.acceleration(z, dynamics.force(z))], -1).numpy())
    np.testing.assert_allclose(motions[1], motions[0], rtol=0, atol=1e-12)


def test_a_free_mode_moves_on_a_circle_under_the_calibrated_scale() -> None:
    """(q / a)^2 + (q' / b)^2 stays, mode by mode, where a = b / omega and nothing damps."""
    modal = chain_modes(0.0)
    dynamics = dynamics_of(modal, scale=StateScale.of_velocity(np.array([0.3, 2.0, 1.0, 5.0]), modal.omega))
    with torch.no_grad():
        z = propagate(dynamics, torch.randn(1, 8, generator=torch.Generator().manual_seed(0)), 60, 0.4)[0].numpy()
    radius = np.hypot(z[:, :4], z[:, 4:])
    np.testing.assert_allclose(radius, np.broadcast_to(radius[0], radius.shape), rtol=1e-12)


def test_rate_and_acceleration_agree() -> None:
    """The second half of dz/dt is q'' / b, the first q' / a."""
    dynamics = dynamics_of(chain_modes(), (TO_GROUND,), net=0.5, scale=StateScale(np.full(4, 2.0), np.full(4, 0.5)))
    z = torch.randn(3, 8, generator=torch.Generator().manual_seed(0))
    rate = dynamics(torch.zeros(()), z)
    _, q_dot = dynamics.unscale(z)
    assert torch.allclose(rate[:, :4] * 2.0, q_dot)
    assert torch.allclose(rate[:, 4:] * 0.5, dynamics.acceleration(z, dynamics.force(z)))


def test_a_structure_at_rest_stays_there_unless_the_net_is_free() -> None:
    modal, still = chain_modes(), torch.zeros(1, 8)
    for zero_at_rest in (True, False):
        dynamics = ModalDynamics(modal, (), StateScale.unit(4), FreeResidual(4, 6, zero_at_rest))
        with torch.no_grad():
            last_layer(dynamics).bias.fill_(0.3)
        assert bool((dynamics.force(still) == 0).all()) is zero_at_rest


def test_nothing_is_learned_at_the_start_and_physics_never() -> None:
    """Only the rest and the net have parameters; untrained, they exert no force."""
    residual = FreeResidual(4, 6, zero_at_rest=True)
    dynamics = ModalDynamics(chain_modes(), (), StateScale.unit(4), residual)
    assert {name.split(".")[0] for name, _ in dynamics.named_parameters()} == {"residual"}
    assert bool((dynamics.force(torch.randn(7, 8)) == 0).all())
    assert bool((residual.rest.weight == 0).all())


def test_effects_sit_where_the_model_has_degrees_of_freedom() -> None:
    with pytest.raises(KeyError, match="node 9 has no degree of freedom"):
        effect_shape(chain_modes(), replace(TO_GROUND, nodes=(9,)))
