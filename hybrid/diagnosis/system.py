"""The state space of many parameter vectors at once: z' = A z + B f(u, v), y = C z + D f, with the sensors' faults."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import expm

from fe_models.dofs import FloatArray

Force = Callable[[FloatArray, FloatArray], FloatArray]
"""Restoring force (variant, recording) of elongation and rate, each (variant, recording)."""

SUBSTEP = 1.0  # largest omega times substep where a force law acts: its pull on that mode is then off by 5e-4
MOST_SUBSTEPS = 40
MOST_GROWTH = 200.0  # in e-folds, of a motion without damping; more would overflow, and is as wrong
DEFECTIVE = 1e9  # condition number of eigenvectors, beyond which matrix exponentials serve better
CHECKED = 25  # samples between looks whether the motion still is finite
FEWEST_SUBSTEPS = 2  # contacts and friction set in between samples


@dataclass(frozen=True)
class System:
    """``A`` (variant, state, state), ``C`` (variant, sensor, state); ``B`` (variant, state, law) and ``D`` (variant,
    sensor, law) of the ``forces``; ``G`` (variant, 2 law, state) gives elongations, then rates; ``gain``, ``delay`` (s)
    and ``slope`` (1/s): (variant, sensor); ``step`` (s) between samples.
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

    def only(self, variant: int) -> "System":
        """Return one variant of a linear system."""
        one = slice(variant, variant + 1)
        parts = {name: getattr(self, name)[one] for name in ("A", "B", "C", "D", "G", "gain", "delay", "slope")}
        return replace(self, **parts)


@dataclass(frozen=True)
class ModalForm:
    """Linear channels as a sum of decaying oscillations: y = Re sum over m of c_m exp(root_m t) (left_m z0).

    ``roots`` (variant, m), 1/s, one of each conjugate pair; ``right`` (variant, sensor, m), with gain, delay and the
    factor 2 of a pair; ``left`` (variant, m, state).
    """

    roots: FloatArray
    right: FloatArray
    left: FloatArray

    def waves(self, samples: int, step: float) -> FloatArray:
        """Return exp(root t) side by side as real and negative imaginary part, (variant, time, 2 m)."""
        growth = self.roots[:, None] * (step * np.arange(samples))[None, :, None]
        waves = np.exp(np.minimum(growth.real, MOST_GROWTH) + 1j * growth.imag)
        return np.concatenate([waves.real, -waves.imag], axis=2)


def modal_form(system: System) -> ModalForm | None:
    """Return the modal form, None where eigenvectors fall together (a body that moves freely, a resonance)."""
    roots, vectors = np.linalg.eig(system.A)
    if not np.isfinite(vectors).all() or np.linalg.cond(vectors).max() > DEFECTIVE:
        return None
    weight = np.where(roots.imag > 0, 2.0, np.where(roots.imag < 0, 0.0, 1.0))
    order = np.argsort(-weight, axis=1)[:, : int((weight > 0).sum(axis=1).max())]
    inverse = np.linalg.inv(vectors)
    roots = np.take_along_axis(roots, order, axis=1)
    right = system.C @ np.take_along_axis(vectors, order[:, None], axis=2)
    right = right * (system.gain[..., None] * np.take_along_axis(weight, order, axis=1)[:, None])
    if system.delay.any():
        right = right * np.exp(-roots[:, None] * system.delay[..., None])
    return ModalForm(roots, right, np.take_along_axis(inverse, order[..., None], axis=1))


def observability(system: System, samples: int) -> FloatArray:
    """Return what the sensors show of each initial state without force laws, (variant, time, sensor, state)."""
    form = modal_form(system)
    if form is not None:
        c = form.right.transpose(0, 2, 1)[..., None] * form.left[:, :, None]  # (variant, m, sensor, state)
        c = c.reshape(*c.shape[:2], -1)
        rows = form.waves(samples, system.step) @ np.concatenate([c.real, c.imag], axis=1)
        return rows.reshape(len(rows), samples, *system.C.shape[1:])
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


def drifted(system: System, begins: FloatArray) -> FloatArray:
    """Return how far each channel has drifted when its segment ``begins`` (recording,), in samples.

    Shape (variant, recording, 1, sensor).
    """
    return np.asarray(system.slope[:, None, None] * (system.step * begins)[None, :, None, None])


def respond(system: System, start: FloatArray, samples: int) -> FloatArray:
    """Return the channels (variant, recording, time, sensor) from initial states (variant, recording, state).

    NaN where the motion grows beyond all bounds.
    """
    if system.is_linear:
        return _linear_channels(system, start, samples) + drift(system, samples)[:, None]
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


def _linear_channels(system: System, start: FloatArray, samples: int) -> FloatArray:
    form = modal_form(system)
    if form is None:
        return np.asarray(np.einsum("ptsn,prn->prts", observability(system, samples), start, optimize=True))
    amplitudes = np.einsum("pmn,prn->pmr", form.left, start, optimize=True)
    c = (form.right.transpose(0, 2, 1)[:, :, None] * amplitudes[..., None]).reshape(*amplitudes.shape[:2], -1)
    y = form.waves(samples, system.step) @ np.concatenate([c.real, c.imag], axis=1)
    return y.reshape(len(y), samples, start.shape[1], -1).transpose(0, 2, 1, 3)


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
    stack = np.concatenate([G, G @ half, G @ whole, whole], axis=1)
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
