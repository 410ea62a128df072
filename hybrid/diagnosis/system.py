"""The state space of many parameter vectors at once: z' = A z + B f(u, v), y = C z + D f, with the sensors' faults."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import expm

from fe_models.dofs import FloatArray

Force = Callable[[FloatArray, FloatArray], FloatArray]
"""Restoring force (variant, recording) of elongation and rate, each (variant, recording)."""

SUBSTEP = 0.25  # largest omega times substep where a force law acts: the scheme of order 4 is then off by 1e-4
MOST_SUBSTEPS = 40
CHECKED = 25  # samples between looks whether the motion still is finite
FEWEST_SUBSTEPS = 2  # contacts and friction set in between samples


@dataclass(frozen=True)
class System:
    """``A`` (variant, state, state), ``C`` (variant, sensor, state); ``B`` (variant, state, law) and ``D`` (variant,
    sensor, law) of the ``forces``; ``G`` (2 law, state) gives elongations, then rates; ``gain``, ``delay`` (s) and
    ``slope`` (1/s): (variant, sensor); ``step`` (s) between samples.
    """

    A: FloatArray
    B: FloatArray
    C: FloatArray
    D: FloatArray
    G: FloatArray
    forces: tuple[Force, ...]
    gain: FloatArray
    delay: FloatArray
    slope: FloatArray
    step: float

    @property
    def is_linear(self) -> bool:
        """Whether no force law acts."""
        return not self.forces


def observability(system: System, samples: int) -> FloatArray:
    """Return what the sensors show of each initial state without force laws, (variant, time, sensor, state)."""
    C = system.C * system.gain[..., None]
    if system.delay.any():
        back = expm(-system.A[:, None] * system.delay[..., None, None])  # (variant, sensor, state, state)
        C = np.einsum("psn,psnm->psm", C, back)
    power = expm(system.A * system.step)
    rows = C[:, None]
    while rows.shape[1] < samples:  # doubling: log2(samples) products instead of samples
        rows = np.concatenate([rows, np.einsum("ptsn,pnm->ptsm", rows, power, optimize=True)], axis=1)
        power = power @ power
    return rows[:, :samples]


def drift(system: System, samples: int) -> FloatArray:
    """Return slope * t, (variant, time, sensor)."""
    return np.asarray(system.slope[:, None] * (system.step * np.arange(samples))[None, :, None])


def respond(system: System, start: FloatArray, samples: int) -> FloatArray:
    """Return the channels (variant, recording, time, sensor) from initial states (variant, recording, state).

    NaN where the motion grows beyond all bounds.
    """
    if system.is_linear:
        y = np.einsum("ptsn,prn->prts", observability(system, samples), start, optimize=True)
        return np.asarray(y + drift(system, samples)[:, None])
    marched = march(system, start, samples)
    if marched is None:
        return np.full((*start.shape[:2], samples, system.C.shape[1]), np.nan)
    return channels(system, marched)


def channels(system: System, marched: tuple[FloatArray, FloatArray]) -> FloatArray:
    """Return the channels (variant, recording, time, sensor) of what `march` returns."""
    with np.errstate(over="ignore", invalid="ignore"):
        y = np.einsum("tprn,psn->prts", marched[0], system.C, optimize=True)
        y += np.einsum("tprm,psm->prts", marched[1], system.D, optimize=True)
    return as_shown(system, y)


def march(system: System, start: FloatArray, samples: int) -> tuple[FloatArray, FloatArray] | None:
    """Return states (time, variant, recording, state) and -f (time, variant, recording, law), None where they explode.

    Lawson's Runge-Kutta scheme of order 4: the linear part by matrix exponentials, the forces in substeps. Only the
    elongations are needed within a substep, so that each costs one product with the state.
    """
    variants, recordings, states = start.shape
    laws = len(system.forces)
    fastest = float(np.abs(np.linalg.eigvals(system.A[0])).max())
    substeps = max(FEWEST_SUBSTEPS, int(np.ceil(fastest * system.step / SUBSTEP)))
    if substeps > MOST_SUBSTEPS:  # no structure, but a search gone astray
        return None
    h = system.step / substeps
    half = expm(system.A * (h / 2))
    whole = half @ half
    G, B = system.G, system.B
    half_B = half @ B
    stack = np.concatenate([np.broadcast_to(G, (variants, *G.shape)), G @ half, G @ whole, whole], axis=1)
    stack = np.ascontiguousarray(stack.transpose(0, 2, 1))  # (variant, state, 6 law + state)
    direct, delayed = h * (G @ B), h * (G @ half_B)  # (variant, 2 law, law)
    first, middle, last = (h * part.transpose(0, 2, 1) for part in (whole @ B / 6, half_B / 3, B / 6))
    direct, delayed = direct.transpose(0, 2, 1), delayed.transpose(0, 2, 1)

    def forces(motion: FloatArray) -> FloatArray:
        """Return -f (variant, recording, law) of elongations and rates (variant, recording, 2 law)."""
        if laws == 1:
            return np.asarray(-system.forces[0](motion[..., 0], motion[..., 1])[..., None])
        return -np.stack([f(motion[..., i], motion[..., laws + i]) for i, f in enumerate(system.forces)], axis=-1)

    z = start
    history = np.empty((samples, variants, recordings, states))
    applied = np.empty((samples, variants, recordings, laws))
    with np.errstate(over="ignore", invalid="ignore"):
        for k in range(samples):
            if k % CHECKED == 0 and not np.isfinite(z).all():
                return None
            for part in range(substeps):
                moved = z @ stack
                f1 = forces(moved[..., : 2 * laws])
                if part == 0:
                    history[k], applied[k] = z, f1
                    if k == samples - 1:
                        break
                in_half = moved[..., 2 * laws : 4 * laws]
                f2 = forces(in_half + 0.5 * (f1 @ delayed))
                f3 = forces(in_half + 0.5 * (f2 @ direct))
                f4 = forces(moved[..., 4 * laws : 6 * laws] + f3 @ delayed)
                z = moved[..., 6 * laws :] + f1 @ first + (f2 + f3) @ middle + f4 @ last
    return history, applied


def as_shown(system: System, y: FloatArray) -> FloatArray:
    """Return channels (variant, recording, time, sensor) with gain, delay and drift of the sensors."""
    for variant, sensor in zip(*np.nonzero(system.delay), strict=True):
        if np.isfinite(y[variant, :, :, sensor]).all():
            samples = np.arange(y.shape[2], dtype=float)
            curve = CubicSpline(samples, y[variant, :, :, sensor], axis=-1)
            y[variant, :, :, sensor] = curve(samples - system.delay[variant, sensor] / system.step)
    return np.asarray(y * system.gain[:, None, None] + drift(system, y.shape[2])[:, None])
