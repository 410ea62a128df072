"""The state space of many parameter vectors at once: z' = A z + B f(u, v), y = C z + D f, with the sensors' faults."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import ceil, sqrt

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import expm

from fe_models.arrays import ComplexArray, FloatArray
from fe_models.lowpass import LowPass
from hybrid.diagnosis.nominal.loads import ForcePlace, Loads
from hybrid.diagnosis.response.config import EIGENMODES, STATE_SPACE
from hybrid.diagnosis.response.filtering import convolved
from hybrid.diagnosis.response.residual_modes import ResidualModes
from hybrid.observability import observability_by_doubling

Force = Callable[[FloatArray, FloatArray], FloatArray]
"""Restoring force (variant, recording) of elongation and rate, each (variant, recording)."""


@dataclass(frozen=True)
class LoadInput:
    """How forces whose course is given, as known loads, enter a system at ``places``.

    ``feed`` (variant, state, place): what a unit of each adds to the rate of the structure's own states, those of
    harmonic forces left out; ``direct`` (variant, sensor, place): what it shows at once. How modes that are not
    followed move under each order of its courses: ``bent`` (order, sensor, place), as sensors show it; ``stretch``
    (order, law, place), along the elongation of each force law. ``gain`` and ``delay`` (s), (variant, place): how what
    was recorded differs from what acts.
    """

    places: tuple[ForcePlace, ...]
    feed: FloatArray
    direct: FloatArray
    bent: FloatArray
    stretch: FloatArray
    gain: FloatArray
    delay: FloatArray

    @property
    def is_alike(self) -> bool:
        """Whether the same acts in all variants."""
        return bool((self.gain == self.gain[0]).all() and (self.delay == self.delay[0]).all())

    def acting(self, loads: Loads, variant: int) -> FloatArray:
        """Return the courses (order, recording, time, place) of what acts, of one variant."""
        return loads.acting(self.places, self.gain[variant], self.delay[variant])

    def only(self, variant: int) -> "LoadInput":
        """Return that of one variant."""
        one = slice(variant, variant + 1)
        own = {name: getattr(self, name)[one] for name in ("feed", "direct", "gain", "delay")}
        return replace(self, **own)

    def and_at(self, other: "LoadInput") -> "LoadInput":
        """Return how forces enter at these places and, behind them, at those of an ``other`` entry."""
        arrays = {
            name: np.concatenate([getattr(self, name), getattr(other, name)], axis=-1)
            for name in ("feed", "direct", "bent", "stretch", "gain", "delay")
        }
        return LoadInput((*self.places, *other.places), **arrays)


@dataclass(frozen=True)
class ResidualFlexibility:
    """``residual`` coordinates, and what sensors of displacement, velocity and acceleration show of them,
    ``sensor_shapes`` (3, sensor, coordinate).
    """

    residual: ResidualModes
    sensor_shapes: FloatArray


@dataclass(frozen=True)
class System:
    """``A`` (variant, state, state), ``C`` (variant, sensor, state); ``B`` (variant, state, law) and ``D`` (variant,
    sensor, law) of the ``forces``; ``G`` (variant, 2 law, state) gives elongations, then rates; ``gain``, ``delay`` (s)
    and ``slope`` (1/s): (variant, sensor); ``step`` (s) between samples. ``residual_flexibility``: what
    else gives way to the laws, None where nothing does. ``loads``: how known ones enter, None where there are none.
    ``lowpass``: what the sensors' signals have passed, None without.
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
    residual_flexibility: ResidualFlexibility | None = None
    loads: LoadInput | None = None
    lowpass: LowPass | None = None

    @property
    def is_linear(self) -> bool:
        """Whether no force law acts."""
        return not self.forces

    @property
    def unforced(self) -> "System":
        """The system without its force laws."""
        return replace(self, B=self.B[:, :, :0], D=self.D[:, :, :0], G=self.G[:, :0], forces=())

    def only(self, variant: int) -> "System":
        """Return one variant of a linear system."""
        one = slice(variant, variant + 1)
        parts = {name: getattr(self, name)[one] for name in ("A", "B", "C", "D", "G", "gain", "delay", "slope")}
        return replace(self, **parts, loads=self.loads and self.loads.only(variant))


@dataclass(frozen=True)
class ModalForm:
    """Linear channels as a sum of decaying oscillations: y = Re sum over m of c_m exp(root_m t) (left_m z0).

    ``roots`` (variant, m), 1/s, one of each conjugate pair; ``right`` (variant, sensor, m), with gain, delay and the
    factor 2 of a pair; ``left`` (variant, m, state).
    """

    roots: ComplexArray
    right: ComplexArray
    left: ComplexArray

    def oscillations(self, samples: int, step: float) -> FloatArray:
        """Return exp(root t) side by side as real and negative imaginary part, (variant, time, 2 m)."""
        roots = np.minimum(self.roots.real, STATE_SPACE.max_growth_nepers / (step * samples)) + 1j * self.roots.imag
        block = ceil(sqrt(samples))  # exp of each block's beginning times exp within it: two short tables
        begin, within = (
            np.exp(roots[:, None] * (step * times)[:, None])
            for times in (block * np.arange(ceil(samples / block)), np.arange(block))
        )
        both = (begin[:, :, None] * within[:, None]).reshape(len(roots), -1, roots.shape[1])[:, :samples]
        return np.concatenate([both.real, -both.imag], axis=2)


def is_defective(vectors: ComplexArray) -> bool:
    """Return whether eigenvectors (..., state, mode) nearly fall together, so that no sum of exponentials serves."""
    if not np.isfinite(vectors).all():
        return True
    at_most = np.linalg.cond(vectors, "fro").max()  # sooner told than the condition number itself
    return bool(at_most > STATE_SPACE.max_condition and np.linalg.cond(vectors).max() > STATE_SPACE.max_condition)


def modal_form(system: System, first_order: bool = False) -> ModalForm | None:
    """Return the modal form, None where eigenvectors fall together (a body that moves freely, a resonance).

    ``first_order``: variants are a Jacobian's; their eigenvectors follow from the first where these hardly mix.
    """
    eigen = _near_the_first(system.A) if first_order and len(system.A) > 1 else None
    roots, vectors, inverse = eigen or _each(system.A)
    if inverse is None:
        return None
    weight = np.where(roots.imag > 0, 2.0, np.where(roots.imag < 0, 0.0, 1.0))
    order = np.argsort(-weight, axis=1)[:, : int((weight > 0).sum(axis=1).max())]
    roots = np.take_along_axis(roots, order, axis=1)
    right = system.C @ np.take_along_axis(vectors, order[:, None], axis=2)
    right = right * (system.gain[..., None] * np.take_along_axis(weight, order, axis=1)[:, None])
    if system.delay.any():
        right = right * np.exp(-roots[:, None] * system.delay[..., None])
    if system.lowpass is not None:
        right = right * system.lowpass.gain(roots)[:, None]
    return ModalForm(roots, right, np.take_along_axis(inverse, order[..., None], axis=1))


Eigen = tuple[ComplexArray, ComplexArray, ComplexArray | None]
"""Roots (variant, mode), eigenvectors (variant, state, mode) and their inverse; None where these fall together."""


def _each(A: FloatArray) -> Eigen:
    roots, vectors = np.linalg.eig(A)
    return roots, vectors, None if is_defective(vectors) else np.linalg.inv(vectors)


def _near_the_first(A: FloatArray) -> Eigen | None:
    """Return the eigenvectors of variants that hardly differ, to first order; None where they do.

    Of A + dA, with A = V diag(r) W: dr_j = E_jj and dV = V D, where E = W dA V and D_ij = E_ij / (r_j - r_i).
    """
    first, vectors, inverse = (None if part is None else part[0] for part in _each(A[:1]))
    if first is None or vectors is None or inverse is None:
        return None
    E = inverse @ (A - A[0]) @ vectors
    every = np.arange(len(first))
    apart = first - first[:, None]
    apart[every, every] = 1.0
    with np.errstate(divide="ignore", invalid="ignore"):  # of roots that are equal
        D = E / apart
    D[:, every, every] = 0.0
    if not np.abs(D).max() < EIGENMODES.max_mixing:
        return None
    moved = E[:, every, every]
    moved = np.where(first.imag == 0, moved.real, moved)  # a root that is real stays so
    return first + moved, vectors + vectors @ D, inverse - D @ inverse


def free_form(system: System, n: int) -> ModalForm:
    """Return the modal form of a system of ``n`` coordinates without its force laws and low-pass, for motions that are
    driven; a body that moves freely is held by soft springs, which part roots that fall together.
    """
    free = replace(system, forces=(), lowpass=None)
    form = modal_form(free)
    if form is None:
        A = system.A.copy()
        largest = max(float(np.abs(np.linalg.eigvals(A)).max()), STATE_SPACE.min_turn_per_sample / system.step)
        A[:, range(n, 2 * n), range(n)] -= STATE_SPACE.soft_spring_share * largest**2
        form = modal_form(replace(free, A=A))
    assert form is not None  # nothing moves freely now
    return form


def observability(system: System, samples: int) -> FloatArray:
    """Return what the sensors show of each initial state without force laws, (variant, time, sensor, state)."""
    form = modal_form(system)
    if form is not None:
        rows = form.oscillations(samples, system.step) @ _shown_of_states(form)
        return rows.reshape(len(rows), samples, *system.C.shape[1:])
    C = system.C * system.gain[..., None]
    if system.delay.any():
        back = expm(-system.A[:, None] * system.delay[..., None, None])  # (variant, sensor, state, state)
        C = np.einsum("psn,psnm->psm", C, back)
    transition = expm(system.A * system.step)
    return observability_by_doubling(C[:, None], transition[:, None], samples, np.concatenate)


def framed_observability(system: System, samples: int) -> tuple[FloatArray, FloatArray]:
    """Return the `observability` as parts along an orthonormal frame of functions of time: (variant, time, coordinate),
    and (variant, coordinate, sensor, state). These are far fewer than samples, but where eigenvectors fall together.
    """
    form = modal_form(system)
    if form is None:
        frame = np.broadcast_to(np.eye(samples), (len(system.A), samples, samples))
        return frame, observability(system, samples)
    frame, inside = np.linalg.qr(form.oscillations(samples, system.step))
    rows = inside @ _shown_of_states(form)
    return frame, rows.reshape(*rows.shape[:2], *system.C.shape[1:])


def _shown_of_states(form: ModalForm) -> FloatArray:
    """Return how much of each of a form's `oscillations` sensors show of initial states (variant, 2 m, sensor x
    state).
    """
    c = form.right.transpose(0, 2, 1)[..., None] * form.left[:, :, None]  # (variant, m, sensor, state)
    c = c.reshape(*c.shape[:2], -1)
    return np.concatenate([c.real, c.imag], axis=1)


def drift(system: System, samples: int) -> FloatArray:
    """Return slope * t, (variant, time, sensor)."""
    return np.asarray(system.slope[:, None] * (system.step * np.arange(samples))[None, :, None])


def drifted(system: System, begins: FloatArray) -> FloatArray:
    """Return how far each channel has drifted when its segment ``begins`` (recording,), in samples.

    Shape (variant, recording, 1, sensor).
    """
    return np.asarray(system.slope[:, None, None] * (system.step * begins)[None, :, None, None])


def linear_channels(system: System, start: FloatArray, samples: int) -> FloatArray:
    """Return the channels (variant, recording, time, sensor) without force laws and drift, from initial states
    (variant, recording, state).
    """
    form = modal_form(system)
    if form is None:
        return np.asarray(np.einsum("ptsn,prn->prts", observability(system, samples), start, optimize=True))
    amplitudes = np.einsum("pmn,prn->pmr", form.left, start, optimize=True)
    c = (form.right.transpose(0, 2, 1)[:, :, None] * amplitudes[..., None]).reshape(*amplitudes.shape[:2], -1)
    y = form.oscillations(samples, system.step) @ np.concatenate([c.real, c.imag], axis=1)
    return y.reshape(len(y), samples, start.shape[1], -1).transpose(0, 2, 1, 3)


def through_lowpass(
    y: FloatArray, system: System, before: FloatArray | None = None, after: FloatArray | None = None
) -> FloatArray:
    """Return channels (..., time, sensor) through the system's low-pass, given what comes ``before`` and ``after``.

    As far as the filter reaches; without these the channels go on there as they begin and end.
    """
    if system.lowpass is None:
        return y
    kernel = system.lowpass.kernel(1 / system.step)
    half = len(kernel) // 2
    if before is None or after is None:
        before, after = np.repeat(y[..., :1, :], half, axis=-2), np.repeat(y[..., -1:, :], half, axis=-2)
    return convolved(np.concatenate([before, y, after], axis=-2), kernel)


def with_sensor_faults(system: System, y: FloatArray) -> FloatArray:
    """Return channels (variant, recording, time, sensor), changed in place, with the sensors' gain, delay and drift."""
    for variant, sensor in zip(*np.nonzero(system.delay), strict=True):
        if np.isfinite(y[variant, :, :, sensor]).all():
            samples = np.arange(y.shape[2], dtype=float)
            curve = CubicSpline(samples, y[variant, :, :, sensor], axis=-1)
            y[variant, :, :, sensor] = curve(samples - system.delay[variant, sensor] / system.step)
    y *= system.gain[:, None, None]
    if system.slope.any():
        y += drift(system, y.shape[2])[:, None]
    return y
