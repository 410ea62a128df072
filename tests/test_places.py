"""The residual that is tied to places of a chain, and the initial states that are solved for through it."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from scipy.linalg import expm

from fe_models.assembly import linearise
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import CubicSpring
from fe_models.errors import InputError
from fe_models.linear import ModalModel
from fe_models.recordings import Dataset
from hybrid.config import places_preset
from hybrid.estimation.linear_calibration import Observer, fit_linear_rest
from hybrid.estimation.most_probable_state import estimate_state
from hybrid.estimation.trajectory_sensitivity import sensitivities, trajectory_jacobian
from hybrid.neural_modal_ode.connectors import chain_connectors
from hybrid.neural_modal_ode.dynamics import ModalDynamics
from hybrid.neural_modal_ode.integrators import propagate
from hybrid.neural_modal_ode.residuals.connector_residual import ConnectorResidual
from hybrid.neural_modal_ode.residuals.free_residual import FreeResidual
from hybrid.neural_modal_ode.scaling import StateScale
from hybrid.neural_modal_ode.state_prior import StatePrior
from hybrid.training.preparation import prepare
from hybrid.training.run import begin, resume
from hybrid.training.trainers import trainer_for
from tests.hybrid_problems import (
    MASS,
    MEASURED,
    SENSORS,
    STEP,
    STIFFNESS,
    chain_dataset,
    chain_modes,
    cubic_dataset,
    double_precision,
    learned,
    recorded,
    same,
    starting_model,
)

SPRINGS = np.array([1.0, 0, 0, 0, 2, 3, 4])  # N/m: nodes 1 to 4 to the ground, then 1-2, 2-3, 3-4
DASHPOTS = np.array([0.1, 0.1, 0.1, 0.1, 0, 0, 0])  # N s/m: not proportional to mass or stiffness
PLACES = replace(places_preset(), training=replace(places_preset().training, window=80, epochs=2, batch=9, threads=1))


@pytest.fixture(autouse=True)
def exact_numbers() -> Iterator[None]:
    with double_precision():
        yield


def crooked_modes() -> ModalModel:
    """A modal model that fits the mass matrix as badly as the paper's: shapes and frequencies with 3 % noise."""
    rng, nominal = np.random.default_rng(5), chain_modes()
    factors = 1 + 0.03 * rng.standard_normal((5, 4))
    return replace(nominal, shapes=nominal.shapes * factors[:4], omega=nominal.omega * factors[4])


def places(modal: ModalModel, scale: StateScale | None = None) -> ConnectorResidual:
    connectors = chain_connectors(four_dof(), linearise(four_dof()), modal)
    with torch.random.fork_rng():
        torch.manual_seed(0)  # of the nets' first weights
        return ConnectorResidual(connectors, scale or StateScale.unit(4), hidden=5)


def with_laws(residual: ConnectorResidual) -> ConnectorResidual:
    """Give the nets something to do."""
    with torch.no_grad():
        residual.table[:, -residual.hidden :].normal_(generator=torch.Generator().manual_seed(1))
    return residual


def test_in_a_mass_normalised_basis_a_force_feeds_the_modes_as_its_place_moves() -> None:
    """Phi^-1 M^-1 = Phi^T where Phi^T M Phi = I; 1e-12 is rounding."""
    connectors = chain_connectors(four_dof(), linearise(four_dof()), chain_modes())
    assert len(connectors.names) == 7
    np.testing.assert_allclose(connectors.feeds, connectors.shapes, atol=1e-12)


def test_springs_and_dashpots_give_the_chain_whatever_the_modal_model_says() -> None:
    """X'' = -M^-1 K x - M^-1 C x' in any basis of shapes, also one that is off; 1e-10 is rounding."""
    modal = crooked_modes()
    residual = places(modal)
    residual.set_coefficients(torch.tensor(SPRINGS), torch.tensor(DASHPOTS))
    A = ModalDynamics(modal, (), StateScale.unit(4), residual).linear_part().detach().numpy()
    to_nodes = np.kron(np.eye(2), modal.shapes)
    C = 0.1 * np.eye(4)
    exact = np.block([[np.zeros((4, 4)), np.eye(4)], [-np.linalg.solve(MASS, STIFFNESS), -np.linalg.solve(MASS, C)]])
    np.testing.assert_allclose(to_nodes @ A @ np.linalg.inv(to_nodes), exact, atol=1e-10)


def test_coefficients_come_back_in_their_units() -> None:
    residual = places(chain_modes(), StateScale(np.full(4, 0.3), np.full(4, 7.0)))
    residual.set_coefficients(torch.tensor(SPRINGS), torch.tensor(DASHPOTS))
    for found, given in zip(residual.coefficients(), (SPRINGS, DASHPOTS), strict=True):
        np.testing.assert_allclose(found.detach().numpy(), given, atol=1e-14)


@pytest.mark.parametrize("kind", ["places", "free"])
def test_slopes_are_those_of_the_force(kind: str) -> None:
    """Central differences of step 1e-6 are good to 1e-9."""
    scale = StateScale(np.array([0.5, 1, 2, 3]), np.array([1, 2, 3, 4.0]))
    residual = with_laws(places(chain_modes(), scale)) if kind == "places" else FreeResidual(4, 5, zero_at_rest=True)
    if isinstance(residual, FreeResidual):
        torch.nn.init.normal_(next(residual.net[-1].parameters()))
    dynamics = ModalDynamics(chain_modes(), (CubicSpring((1, 2), "x", 0.7),), scale, residual)
    z = torch.randn(3, 8, generator=torch.Generator().manual_seed(0))
    with torch.no_grad():
        found = dynamics.force_slopes(z)
        for j in range(8):
            step = 1e-6 * torch.eye(8)[j]
            differences = (dynamics.force(z + step) - dynamics.force(z - step)) / 2e-6
            torch.testing.assert_close(found[:, :, j], differences, rtol=0, atol=1e-8)


def test_a_structure_at_rest_stays_there() -> None:
    dynamics = ModalDynamics(chain_modes(), (), StateScale.unit(4), with_laws(places(chain_modes())))
    assert bool((dynamics.force(torch.zeros(2, 8)) == 0).all())


def test_sensitivities_are_the_derivative_of_the_trajectory() -> None:
    """Central differences of step 1e-6 through 40 steps are good to 3e-8."""
    dynamics = ModalDynamics(chain_modes(), (), StateScale.unit(4), with_laws(places(chain_modes())))
    z0 = torch.randn(2, 8, generator=torch.Generator().manual_seed(0))
    with torch.no_grad():
        z = propagate(dynamics, z0, 41, 0.1)
        S = sensitivities(trajectory_jacobian(dynamics, z.transpose(0, 1), 0.1)).transpose(0, 1)
        for j in range(8):
            step = 1e-6 * torch.eye(8)[j]
            differences = (propagate(dynamics, z0 + step, 41, 0.1) - propagate(dynamics, z0 - step, 41, 0.1)) / 2e-6
            torch.testing.assert_close(S[:, :, j], differences, rtol=0, atol=1e-7)


def test_the_state_of_a_linear_chain_is_the_gaussian_posterior() -> None:
    """Mean and covariance of z0 ~ N(0, P), x = O z0 + e in closed form, with O = E Phi-rows of expm(A k h)."""
    model = starting_model(chain_dataset(), PLACES)
    rng = np.random.default_rng(2)
    root = rng.standard_normal((8, 8))
    P, std = root @ root.T / 8 + 0.1 * np.eye(8), np.array([0.1, 0.2, 0.3, 0.4])
    prior = StatePrior(torch.tensor(np.linalg.inv(P)), torch.tensor(std))
    A = model.dynamics.linear_part().detach().numpy()
    every = torch.eye(8)
    with torch.no_grad():
        C = model.decode(every, torch.zeros(8, 4))[:, model.measured].numpy().T  # (measured, 8)
    seen = np.concatenate([C @ expm(A * STEP * k) for k in range(12)]) / np.tile(std, 12)[:, None]
    window = rng.standard_normal((1, 12, len(SENSORS)))
    x = (window[0][:, model.measured] / std).ravel()
    covariance = np.linalg.inv(seen.T @ seen + np.linalg.inv(P))
    found = estimate_state(model, prior, torch.tensor(window), iterations=30)  # far out, each step is cut to 2
    np.testing.assert_allclose(found.covariance[0].numpy(), covariance, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(found.mean[0].numpy(), covariance @ seen.T @ x, rtol=1e-6, atol=1e-8)


def test_springs_are_found_from_a_crooked_modal_model() -> None:
    """Noise-free: to 1e-4 of the stiffest, what L-BFGS leaves; the third node is measured, the second is not."""
    sensors = [SENSORS[i] for i in MEASURED]
    data = recorded(chain_modes(0.02), 30, 120, seed=0, sensors=tuple(sensors))
    modal = crooked_modes()
    connectors = chain_connectors(four_dof(), linearise(four_dof()), modal)
    fit = fit_linear_rest(Observer(modal, sensors, STEP, connectors), torch.tensor(data))
    np.testing.assert_allclose(fit.rest[0], SPRINGS, atol=4e-3)
    assert fit.unexplained < 1e-5


def cubic() -> Dataset:
    """Motions of the chain with a cubic spring at node 1 that its nominal model lacks."""
    return cubic_dataset()


@pytest.mark.slow
def test_the_missing_law_is_found_where_it_acts() -> None:
    """After a short training the law at node 1 bends like k u^3, and nothing of that size acts elsewhere."""
    config = replace(PLACES, training=replace(PLACES.training, epochs=30))
    prepared = prepare(cubic(), config)
    trainer = trainer_for(prepared.model, prepared.windows, config.training)
    results = list(trainer.epochs())
    residual = prepared.model.dynamics.residual
    assert isinstance(residual, ConnectorResidual)
    states = torch.as_tensor(residual.sizes[0]).detach()
    u = torch.stack([-states, states], dim=1)  # typical elongations, both signs
    with torch.no_grad():
        k, _ = residual.coefficients()
        force = residual.laws(u, torch.zeros_like(u)) + k[:, None] * u
    beyond = (force[:, 1] - force[:, 0]) / 2 - torch.tensor(SPRINGS) * states  # odd part beyond the nominal springs
    cubic_force = states[0] ** 3
    assert results[-1].loss / results[-1].horizon < 5  # half the square of noise in 4 channels would be 2
    assert float(beyond[0]) == pytest.approx(float(cubic_force), rel=0.35)


def test_frames_have_no_places_yet() -> None:
    few = replace(chain_dataset(), assumptions=replace(chain_dataset().assumptions, modes=2))
    with pytest.raises(InputError, match="as many modes as degrees of freedom"):
        prepare(few, PLACES)


def test_the_same_seed_gives_the_same_bits() -> None:
    trainers = []
    for _ in range(2):
        prepared = prepare(chain_dataset(), PLACES)
        trainers.append(trainer_for(prepared.model, prepared.windows, PLACES.training))
        list(trainers[-1].epochs())
    assert same(learned(trainers[0].model), learned(trainers[1].model))


def test_an_interrupted_training_goes_on_bit_for_bit(tmp_path: Path) -> None:
    """The state of each window, the noise and the prior are in the checkpoint, too."""
    dataset = chain_dataset()
    whole = begin(dataset, PLACES, tmp_path / "whole")
    list(whole.epochs())
    next(begin(dataset, PLACES, tmp_path / "cut").epochs())
    resumed = resume(dataset, PLACES, tmp_path / "cut")
    list(resumed.epochs())
    assert same(learned(resumed.trainer.model), learned(whole.trainer.model))
    buffers = zip(resumed.trainer.model.buffers(), whole.trainer.model.buffers(), strict=True)
    assert all(torch.equal(one, other) for one, other in buffers)
    assert resumed.history == whole.history
