"""Slopes of forces and trajectories by states and by parameters, against central differences and the exponential."""

from collections.abc import Iterator

import numpy as np
import pytest
import torch
from scipy.linalg import expm
from torch import Tensor

from fe_models.causes import CubicSpring, ForceLaw
from hybrid.estimation.most_probable_state import channel_slopes, misfits, observation, trajectory
from hybrid.estimation.trajectory_sensitivity import sensitivities, trajectory_jacobian
from hybrid.neural_modal_ode.integrators import propagate, propagator_weights
from tests.hybrid_problems import MEASURED, STEP, chain_modes, double_precision, dynamics_of
from tests.places_problems import (
    NOISE,
    crooked_precision,
    differences,
    measured_channels,
    place_dynamics,
    place_model,
    plain_loop,
    prior_of,
    random_states,
    residual_modes_of,
)
from tests.test_places import crooked_modes

SPRING: tuple[ForceLaw, ...] = (CubicSpring((1, 2), "x", 0.7),)


@pytest.fixture(autouse=True)
def _double() -> Iterator[None]:
    with double_precision():
        yield


def close(found: Tensor, expected: Tensor, share: float = 1e-7) -> None:
    """Equal to a ``share`` of the largest: central differences of step 1e-5 are good to 1e-9 of third derivatives."""
    torch.testing.assert_close(found, expected, rtol=0, atol=share * float(expected.abs().max()))


@pytest.mark.parametrize("effects", [(), SPRING])
def test_a_transition_is_the_derivative_of_one_step(effects: tuple[ForceLaw, ...]) -> None:
    """Of [z, f_before] to [z+, f], as rows."""
    dynamics = place_dynamics(effects=effects)
    weights = propagator_weights(dynamics, 0.25).detach()
    z, before = random_states(2), 0.1 * random_states(2, seed=3)[:, :4]

    def one_step(y: Tensor) -> Tensor:
        force = dynamics.force(y[:, :8])
        return torch.cat([torch.cat([y[:, :8], force, y[:, 8:]], dim=1) @ weights, force], dim=1)

    with torch.no_grad():
        found = trajectory_jacobian(dynamics, z[None], 0.25).transitions[0]  # (batch, 12, 12)
    slopes = differences(one_step, torch.cat([z, before], dim=1))  # (batch, 12, batch, 12)
    close(found, torch.stack([slopes[i, :, i] for i in range(2)]))


@pytest.mark.parametrize("substeps", [1, 2, 3])
@pytest.mark.parametrize("effects", [(), SPRING])
def test_sensitivities_are_the_derivative_of_the_whole_trajectory(substeps: int, effects: tuple[ForceLaw, ...]) -> None:
    """At every substep of 20 samples, with an effect of the structure's own too."""
    model = place_model(crooked_modes(), substeps=substeps, effects=effects)
    assert model.substeps == substeps
    z0 = random_states(1)
    with torch.no_grad():
        states = trajectory(model, z0, 20)
        assert len(states) == 19 * substeps + 1
        found = sensitivities(trajectory_jacobian(model.dynamics, states, STEP / substeps))[:, 0]  # (substep, 8, 8)
    close(found, differences(lambda z: trajectory(model, z, 20)[:, 0], z0)[0].transpose(0, 1))


def test_where_nothing_is_nonlinear_sensitivities_are_the_matrix_exponential() -> None:
    """1e-12 is the rounding of 30 products."""
    dynamics = place_dynamics(net=0.0)
    A = dynamics.linear_part().detach().numpy()
    with torch.no_grad():
        found = sensitivities(
            trajectory_jacobian(dynamics, propagate(dynamics, random_states(1), 31, 0.5).transpose(0, 1), 0.5)
        )
    exact = [expm(A * 0.5 * k).T for k in range(31)]
    np.testing.assert_allclose(found[:, 0].numpy(), exact, rtol=0, atol=1e-12 * np.abs(exact).max())


def test_a_free_network_has_sensitivities_too() -> None:
    dynamics = dynamics_of(chain_modes(), net=0.3)
    z0 = random_states(1)
    with torch.no_grad():
        states = plain_loop(dynamics, z0, 12, 0.25).transpose(0, 1)
        found = sensitivities(trajectory_jacobian(dynamics, states, 0.25))[:, 0]
    close(found, differences(lambda z: plain_loop(dynamics, z, 12, 0.25)[0], z0)[0].transpose(0, 1))


def test_at_rest_every_slope_is_a_number() -> None:
    model = place_model()
    with torch.no_grad():
        states = trajectory(model, torch.zeros(2, 8), 10)
        assert bool(torch.isfinite(channel_slopes(model, prior_of(model), states)).all())
        assert bool(torch.isfinite(residual_modes_of(model).parameter_slopes(torch.zeros(2, 8))).all())


@pytest.mark.parametrize("substeps", [1, 2])
def test_channel_slopes_are_the_derivative_of_what_the_sensors_see(substeps: int) -> None:
    """Accelerations feel the force at once; each channel counts in its own noise."""
    model, z0 = place_model(crooked_modes(), substeps=substeps), random_states(2)
    with torch.no_grad():
        found = channel_slopes(model, prior_of(model), trajectory(model, z0, 15))  # (batch, 8, time * measured)
    slopes = differences(lambda z: measured_channels(model, z, 15), z0)
    close(found, torch.stack([slopes[i, :, i] for i in range(2)]))


def test_observation_gives_the_channels_of_states_and_forces() -> None:
    model, z, force = place_model(), random_states(3), random_states(3, seed=4)[:, :4]
    with torch.no_grad():
        by_state, by_force = observation(model, prior_of(model))
        expected = model.decode(z, force)[:, MEASURED] / torch.tensor(NOISE)
    close(z @ by_state + force @ by_force, expected, 1e-13)


def test_misfits_are_those_of_the_forecast_and_the_prior() -> None:
    """|x - x(z0)|^2 / 2 in noise deviations and z0^T P^-1 z0 / 2, at samples, not at substeps; 1e-12 is rounding."""
    model, z0 = place_model(substeps=2), random_states(2)
    seen = random_states(2 * 6 * 4, seed=5)[:, 0].reshape(6, 2, 4)  # (time, batch, measured)
    with torch.no_grad():
        misfit, residual = misfits(model, prior_of(model), trajectory(model, z0, 6), seen)
    expected = (seen / torch.tensor(NOISE)).transpose(0, 1).flatten(1) - measured_channels(model, z0, 6)
    close(residual, expected, 1e-12)
    of_prior = torch.stack([z @ crooked_precision() @ z for z in z0])
    close(misfit, 0.5 * (expected.square().sum(dim=1) + of_prior), 1e-12)


def test_parameter_slopes_are_those_of_the_force_at_each_place() -> None:
    """F = k u + c v + net(u, v) - net(0, 0) in N by every number of the table; a place's own numbers only."""
    model = place_model(crooked_modes())
    residual, z = residual_modes_of(model), random_states(3)
    u, v = residual.elongations @ z[:, :4].T, residual.rates @ z[:, 4:].T  # (place, n)
    table = residual.table.detach().clone()

    def forces(other: Tensor) -> Tensor:
        residual.table.copy_(other)
        k, c = residual.coefficients()
        found = residual.laws(u, v) + k[:, None] * u + c[:, None] * v
        residual.table.copy_(table)
        return found

    slopes = differences(forces, table)  # (place, number, place, n)
    with torch.no_grad():
        found = residual.parameter_slopes(z).permute(1, 2, 0)  # (place, number, n)
    close(found, torch.stack([slopes[i, :, i] for i in range(7)]))
    assert float(slopes[0, :, 1].abs().max()) == 0.0
