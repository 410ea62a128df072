"""The state space with its residual coordinates as states, where force laws act."""

from dataclasses import replace

import numpy as np

from fe_models.arrays import FloatArray
from hybrid.diagnosis.response.config import RESIDUAL
from hybrid.diagnosis.response.system import System


def with_residual(system: System) -> System:
    """Return a system whose states end with its residual coordinates r (coordinate,) and their rates.

    r'' + 2 ratio omega r' + omega^2 r = -pulled f under forces f (law,), whose elongations are u + pulled^T r.
    """
    if system.residual_flexibility is None:
        return system
    residual = system.residual_flexibility.residual
    more = len(residual.omega)
    states, laws = system.B.shape[1:]
    at, rates = range(states, states + more), range(states + more, states + 2 * more)
    A = np.pad(system.A, ((0, 0), (0, 2 * more), (0, 2 * more)))
    B = np.pad(system.B, ((0, 0), (0, 2 * more), (0, 0)))
    C, G = (np.pad(part, ((0, 0), (0, 0), (0, 2 * more))) for part in (system.C, system.G))
    spring, dashpot = residual.omega**2, 2 * residual.ratio * residual.omega
    A[:, at, rates], A[:, rates, at], A[:, rates, rates] = 1.0, -spring, -dashpot
    B[:, rates] = residual.pulled
    G[:, :laws, at] = G[:, laws:, rates] = residual.pulled.T
    displaced, moved, pushed = system.residual_flexibility.sensor_shapes
    C[..., at], C[..., rates] = displaced - pushed * spring, moved - pushed * dashpot
    D = system.D + pushed @ residual.pulled
    return replace(system, A=A, B=B, C=C, D=D, G=G, residual_flexibility=None)


def with_residual_states(system: System, start: FloatArray) -> FloatArray:
    """Return initial states (variant, recording, state) with those of residual coordinates behind them.

    They begin where elongations alone would hold them: bent by each law's force f(u + r) with r = -flexibility f, of
    which one step of Aitken's is exact for a spring, and bounded for all.
    """
    if system.residual_flexibility is None:
        return start
    residual, laws = system.residual_flexibility.residual, len(system.forces)
    u = np.einsum("vls,vrs->lvr", system.G[:, :laws], start)
    flexibility = np.sum((residual.pulled / residual.omega[:, None]) ** 2, axis=0)  # (law,)
    felt, still = np.empty_like(u), np.zeros(u.shape[1:])
    with np.errstate(over="ignore", invalid="ignore"):  # of a search gone astray
        for law, force in enumerate(system.forces):
            stiff = force(u[law], still)
            fall = stiff - force(u[law] - flexibility[law] * stiff, still)
            share = np.divide(fall, stiff, out=np.zeros_like(fall), where=np.abs(stiff) > 0)
            felt[law] = stiff / (1 + np.maximum(share, -RESIDUAL.max_softening_share))
    bent = -np.einsum("lvr,cl->vrc", felt, residual.pulled) / residual.omega**2
    return np.concatenate([start, bent, np.zeros_like(bent)], axis=-1)
