"""Problems for residuals at places that carry their exact solution: the chain from its M, C and K, and known laws.

The chain's springs and dashpots are known, so that its motion is the matrix exponential of the textbook's state matrix;
brute-force Jacobians are central differences of whole trajectories. Neither knows the product's recursions.
"""

from collections.abc import Callable

import numpy as np
import torch
from scipy.linalg import expm
from torch import Tensor

from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import ForceLaw
from fe_models.linear import ModalModel
from fe_models.recordings import Sensor
from hybrid.config import ModelConfig
from hybrid.neural_modal_ode.connectors import chain_connectors
from hybrid.neural_modal_ode.dynamics import ModalDynamics
from hybrid.neural_modal_ode.integrators import propagator_weights
from hybrid.neural_modal_ode.model import NeuralModalODE
from hybrid.neural_modal_ode.residuals.connector_residual import ConnectorResidual
from hybrid.neural_modal_ode.scaling import StateScale
from hybrid.neural_modal_ode.state_prior import StatePrior
from tests.hybrid_problems import MASS, MEASURED, SENSORS, STEP, STIFFNESS, chain_modes
from tests.test_places import DASHPOTS, SPRINGS

DAMPING = np.diag(DASHPOTS[:4])  # N s/m: `DASHPOTS` act between the masses and the ground only
SCALE = StateScale(np.array([1.7, 0.6, 0.4, 0.25]), np.array([0.5, 0.6, 0.7, 0.8]))  # uneven, and no circles
NET = 0.1  # of the nets' outputs: forces of the springs' size at states near one; damping of some 10 %
NOISE = np.array([0.05, 0.02, 0.03, 0.04])  # of the measured channels, each its own


def state_matrix() -> FloatArray:
    """A of [x, x']' = A [x, x'] in the masses' displacements, from M, C and K."""
    lower = -np.linalg.solve(MASS, np.hstack([STIFFNESS, DAMPING]))
    return np.vstack([np.hstack([np.zeros((4, 4)), np.eye(4)]), lower])


def sensor_matrix(sensors: tuple[Sensor, ...] = SENSORS) -> FloatArray:
    """What the sensors see of [x, x'], (sensor, 8)."""
    A = state_matrix()
    rows = {"displacement": np.eye(8)[:4], "velocity": np.eye(8)[4:], "acceleration": A[4:]}
    return np.array([rows[sensor.quantity][sensor.node - 1] for sensor in sensors])


def free_motions(realisations: int, samples: int, seed: int, step: float = STEP) -> FloatArray:
    """Exact channels (realisation, time, sensor) of the damped chain from random states, without noise."""
    rng = np.random.default_rng(seed)
    x, power = rng.standard_normal((realisations, 8)), expm(state_matrix() * step)
    seen = []
    for _ in range(samples):
        seen.append(x @ sensor_matrix().T)
        x = x @ power.T
    return np.stack(seen, axis=1)


def at_places(
    modal: ModalModel | None = None, net: float = NET, hidden: int = 3, scale: StateScale = SCALE, seed: int = 1
) -> ConnectorResidual:
    """The chain's springs and dashpots, and random nets at its places with outputs of size ``net``.

    Weights and outputs of a unit have one sign: forces rise with u and with v, so that rest is stable.
    """
    generator = torch.Generator().manual_seed(seed)
    connectors = chain_connectors(four_dof(), linearise(four_dof()), modal or chain_modes())
    residual = ConnectorResidual(connectors, scale, hidden)
    residual.set_coefficients(torch.tensor(SPRINGS), torch.tensor(DASHPOTS))
    with torch.no_grad():
        table = torch.randn(residual.table.shape, generator=generator)
        sign = table[:, -hidden:].sign()
        residual.table[:, 2 : 2 + 2 * hidden] = table[:, 2 : 2 + 2 * hidden].abs() * sign.repeat(1, 2)
        residual.table[:, -2 * hidden : -hidden] = table[:, -2 * hidden : -hidden]
        residual.table[:, -hidden:] = net * table[:, -hidden:]
    return residual


def place_dynamics(
    modal: ModalModel | None = None,
    net: float = NET,
    hidden: int = 3,
    effects: tuple[ForceLaw, ...] = (),
    scale: StateScale = SCALE,
) -> ModalDynamics:
    """The latent ODE with such a residual."""
    modal = modal or chain_modes()
    return ModalDynamics(modal, effects, scale, at_places(modal, net, hidden, scale))


def place_model(
    modal: ModalModel | None = None,
    net: float = NET,
    hidden: int = 3,
    substeps: int = 1,
    effects: tuple[ForceLaw, ...] = (),
    samples: int = 10,
    step: float = STEP,
) -> NeuralModalODE:
    """The chain's model with such a residual, a crooked prior on states and a noise of each channel's own."""
    modal = modal or chain_modes()
    config = ModelConfig(
        encoder="map", residual="places", net_hidden=hidden, substeps=substeps, encoder_samples=samples
    )
    connectors = chain_connectors(four_dof(), linearise(four_dof()), modal)
    model = NeuralModalODE(config, modal, effects, SENSORS, torch.ones(len(SENSORS)), SCALE, step, connectors)
    model.dynamics.residual = at_places(modal, net, hidden)
    prior = prior_of(model)
    prior.precision.copy_(crooked_precision())
    prior.noise_std.copy_(torch.tensor(NOISE))
    return model


def crooked_precision() -> Tensor:
    """The inverse of a full covariance of the scaled state, between 0.1 and a few."""
    root = np.random.default_rng(2).standard_normal((8, 8))
    return torch.tensor(np.linalg.inv(root @ root.T / 8 + 0.1 * np.eye(8)))


def prior_of(model: NeuralModalODE) -> StatePrior:
    """The prior of a model that solves for its states."""
    assert isinstance(model.encoder, StatePrior)
    return model.encoder


def residual_modes_of(model: NeuralModalODE) -> ConnectorResidual:
    """The residual at places of a model."""
    assert isinstance(model.dynamics.residual, ConnectorResidual)
    return model.dynamics.residual


def random_states(count: int, seed: int = 0, size: float = 1.0) -> Tensor:
    """Scaled states (count, 8)."""
    return size * torch.randn(count, 8, generator=torch.Generator().manual_seed(seed))


def plain_loop(dynamics: ModalDynamics, z0: Tensor, samples: int, step: float, pushes: Tensor | float = 0.0) -> Tensor:
    """The propagator step by step, (batch, time, 2 mode), the force as the residual itself gives it.

    ``pushes`` (batch, step, 2 mode): what known forces add.
    """
    weights = propagator_weights(dynamics, step)
    states, before = [z0], dynamics.force(z0)
    for k in range(samples - 1):
        force = dynamics.force(states[-1])
        push = pushes[:, k] if isinstance(pushes, Tensor) else pushes
        states.append(torch.cat([states[-1], force, before], dim=1) @ weights + push)
        before = force
    return torch.stack(states, dim=1)


def differences(function: Callable[[Tensor], Tensor], x: Tensor, step: float = 1e-5) -> Tensor:
    """D function / dx by central differences, the shape of x and then that of the function's value."""
    columns = []
    with torch.no_grad():
        for unit in torch.eye(x.numel()).reshape(-1, *x.shape):
            columns.append((function(x + step * unit) - function(x - step * unit)) / (2 * step))
    return torch.stack(columns).unflatten(0, x.shape)


@torch.no_grad()
def measured_channels(model: NeuralModalODE, z0: Tensor, samples: int, table: Tensor | None = None) -> Tensor:
    """What the measured sensors see, in noise deviations (batch, time * measured), with another ``table`` if given."""
    own = residual_modes_of(model).table
    kept = own.detach().clone()
    if table is not None:
        own.copy_(table)
    seen = model.forecast(z0, samples).channels[:, :, MEASURED] / torch.tensor(NOISE)
    own.copy_(kept)
    return seen.flatten(1)
