"""The state space with its residual coordinates as states, where force laws act."""

from dataclasses import replace

import numpy as np

from fe_models.dofs import FloatArray
from hybrid.diagnosis.response.system import System


def with_residual(system: System) -> System:
    """Return a system whose states end with its residual coordinates and their rates."""
    if system.residual is None or system.picked is None:
        return system
    residual, more = system.residual, len(system.residual.omega)
    states, laws = system.B.shape[1:]
    at, rates = range(states, states + more), range(states + more, states + 2 * more)
    A = np.pad(system.A, ((0, 0), (0, 2 * more), (0, 2 * more)))
    B = np.pad(system.B, ((0, 0), (0, 2 * more), (0, 0)))
    C, G = (np.pad(part, ((0, 0), (0, 0), (0, 2 * more))) for part in (system.C, system.G))
    spring, dashpot = residual.omega**2, 2 * residual.ratio * residual.omega
    A[:, at, rates], A[:, rates, at], A[:, rates, rates] = 1.0, -spring, -dashpot
    B[:, rates] = residual.pulled
    G[:, :laws, at] = G[:, laws:, rates] = residual.pulled.T
    displaced, moved, pushed = system.picked
    C[..., at], C[..., rates] = displaced - pushed * spring, moved - pushed * dashpot
    D = system.D + pushed @ residual.pulled
    return replace(system, A=A, B=B, C=C, D=D, G=G, residual=None, picked=None)


def held(system: System, start: FloatArray) -> FloatArray:
    """Return initial states (variant, recording, state) with those of residual coordinates behind them.

    They begin where the forces that act then would hold them.
    """
    residual, laws = system.residual, len(system.forces)
    if residual is None:
        return start
    felt = np.einsum("vls,vrs->lvr", system.G, start)
    with np.errstate(over="ignore", invalid="ignore"):  # of a search gone astray
        f = np.stack([force(felt[number], felt[laws + number]) for number, force in enumerate(system.forces)], axis=-1)
        bent = -(f @ residual.pulled.T) / residual.omega**2
    return np.concatenate([start, bent, np.zeros_like(bent)], axis=-1)
