"""Channels of a hypothesis near one theta, to first order, less what initial states can do.

Where the channels are linear in the initial states z0 they are solved for at each theta (variable projection); where
force laws act, z0 and theta move together, z0 eliminated by a QR factorisation of its part of the Jacobian.
"""

from dataclasses import dataclass, replace

import numpy as np

from fe_models.arrays import FloatArray
from hybrid.diagnosis.fitting.condensed import Condensed, condense
from hybrid.diagnosis.fitting.config import LINEARISATION
from hybrid.diagnosis.fitting.sampled import Sampled
from hybrid.diagnosis.recorded.batches import Batch
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.loaded import loaded_size
from hybrid.diagnosis.response.marching import respond
from hybrid.diagnosis.response.state_space import system_of
from hybrid.diagnosis.response.system import System, drifted, observability


@dataclass(frozen=True)
class Linearisation:
    """One batch at one theta, in units of sigma and projected orthogonally to what initial states can do.

    ``residual`` (recording, value), ``slopes`` (parameter, recording, value); ``states`` z0 (recording, state) and how
    they move with theta, ``state_slopes`` (parameter, recording, state); ``state_step`` (recording, state) the move
    that the residual asks for; ``raw`` (recording, time, sensor) the residual itself; ``basis`` what was split off;
    ``state_errors`` (recording, state) standard deviations of z0 at this theta. A value is a sensor's at a sample or,
    where ``frame`` (time, coordinate) is given, its part along one of these orthonormal functions of time, which tell
    all but ``raw`` as well (see `condensed`).
    """

    residual: FloatArray
    slopes: FloatArray
    states: FloatArray
    state_slopes: FloatArray
    state_step: FloatArray
    raw: FloatArray
    basis: FloatArray
    state_errors: FloatArray
    frame: FloatArray | None = None


def linearise_batch(
    hypothesis: Hypothesis,
    theta: FloatArray,
    batch: Batch,
    noise_model: NoiseModel,
    states: FloatArray | None,
    slopes: bool = True,
    brief: bool = False,
) -> Linearisation | None:
    """Return the linearisation of one batch, None where the motion grows beyond all bounds.

    ``states`` (recording, state) is needed where force laws act; elsewhere it is solved for. ``brief``: values may
    be parts along a ``frame``, which are far fewer.
    """
    hypothesis, kept = hypothesis.less(batch.off), hypothesis.parameters_of(batch.off)
    if hypothesis.is_linear:
        part = _linear(hypothesis, theta[kept], batch, noise_model, slopes, brief)
    else:
        assert states is not None
        part = _forced(hypothesis, theta[kept], batch, noise_model, states, slopes)
    return None if part is None else _spread(part, kept, len(theta))


def _linear(
    hypothesis: Hypothesis, theta: FloatArray, batch: Batch, noise_model: NoiseModel, slopes: bool, brief: bool
) -> Linearisation | None:
    """Return the linearisation with the best initial states at ``theta``."""
    moved = LINEARISATION.difference_step * hypothesis.width
    thetas = np.vstack([theta, theta + np.diag(moved)]) if slopes else theta[None]
    system = system_of(hypothesis, thetas, noise_model.outputs, first_order=True)
    shorter = condense(system, batch, noise_model, moved) if brief else None
    channels: Condensed | Sampled = shorter or Sampled(system, batch, noise_model, moved)
    if not np.abs(channels.by_state).max() < LINEARISATION.max_channel_sigma:
        return None
    basis, upper = orthonormal(channels.by_state)  # one serves all recordings whose noise is alike
    residual, along_states = split_off(channels.data, basis)
    z = _in_states(upper, along_states)  # (recording, state)
    rest, taken = split_off(channels.changes(z), basis)
    still, errors, left = np.zeros_like(z), _errors(upper, z), channels.left(z)
    return Linearisation(residual, rest, z, -_in_states(upper, taken), still, left, basis, errors, channels.frame)


def _forced(
    hypothesis: Hypothesis, theta: FloatArray, batch: Batch, noise_model: NoiseModel, states: FloatArray, slopes: bool
) -> Linearisation | None:
    """Return the linearisation from ``states`` under force laws; without ``slopes`` only what is left."""
    weight = batch.weights(noise_model)  # (recording or one row, value)
    data = batch.data.reshape(len(states), -1) * weight
    system = system_of(hypothesis, theta[None], noise_model.outputs)
    y = respond(system, states[None], batch.samples, batch.loads) + drifted(system, batch.begins)
    residual = data - y.reshape(data.shape) * weight
    if (
        not np.isfinite(residual).all()
        or np.abs(residual).max() > LINEARISATION.max_residual_ratio * np.abs(data).max()
    ):
        return None
    if not slopes:
        return _left_over(residual, batch, states)
    changes = _changes(hypothesis, system, theta, batch, noise_model, states)
    if changes is None:
        return None
    change, by_state = changes
    basis, upper = orthonormal(by_state)
    left, along = split_off(residual, basis)
    rest, taken = split_off(change, basis)
    return Linearisation(
        left,
        rest,
        states,
        -_in_states(upper, taken),
        _in_states(upper, along),
        residual.reshape(batch.data.shape),
        basis,
        _errors(upper, states),
    )


def _changes(
    hypothesis: Hypothesis, system: System, theta: FloatArray, batch: Batch, noise_model: NoiseModel, states: FloatArray
) -> tuple[FloatArray, FloatArray] | None:
    """Return what parameters change, (parameter, recording, value), and entries of a state, (recording, value, state);
    ``system``: that of ``theta``.

    Of motions computed as if nothing folded (`respond`), which changes what is left of recordings, but hardly the
    direction of a step. Each difference is between two motions that are computed alike, lest it see that.
    """
    moved, size, sigma = (
        LINEARISATION.difference_step * hypothesis.width,
        LINEARISATION.difference_step * _size(system, batch, states),
        batch.sigma(noise_model),
    )
    thetas = np.vstack([theta, theta + np.diag(moved)])
    varied = system_of(hypothesis, thetas, noise_model.outputs, first_order=True)
    y = respond(varied, np.repeat(states[None], len(thetas), axis=0), batch.samples, batch.loads, oversampling=1)
    y += drifted(varied, batch.begins)
    change = y[1:] - y[0]
    change /= sigma * moved[:, None, None, None]
    starts = np.repeat(states[None], 1 + len(size), axis=0)  # of one system, to which they are further recordings
    starts[1:] += np.diag(size)[:, None]
    begun = respond(system, starts.reshape(1, -1, len(size)), batch.samples, batch.loads, oversampling=1)
    begun = begun.reshape(len(starts), *y.shape[1:])  # all drift alike
    by_state = begun[1:] - begun[0]
    by_state /= sigma * size[:, None, None, None]
    if not (np.isfinite(change).all() and np.isfinite(by_state).all()):
        return None
    by_state = by_state.reshape(len(size), len(states), -1).transpose(1, 2, 0)
    shown = np.linalg.norm(observability(system, batch.samples).reshape(-1, hypothesis.states), axis=0)
    by_state[..., shown < LINEARISATION.unobserved_share * shown.max()] = (
        0.0  # differences of these would be rounding alone
    )
    return change.reshape(len(moved), len(states), -1), by_state


def _size(system: System, batch: Batch, states: FloatArray) -> FloatArray:
    """Return how large each entry of a state is (state,): the initial ones', and what loads make of them."""
    square = np.mean(states**2, axis=0)
    if batch.loads is not None:
        square = square + loaded_size(system, batch.loads)
    return np.maximum(np.sqrt(square), LINEARISATION.least_state)


def _left_over(residual: FloatArray, batch: Batch, states: FloatArray) -> Linearisation:
    """Return a linearisation that gives what is left, and no slopes."""
    nothing, still = np.zeros((0, len(residual), 0)), np.zeros_like(states)
    raw = residual.reshape(batch.data.shape)
    return Linearisation(residual, nothing, states, nothing, still, raw, np.zeros((0, 0)), still)


def split_off(columns: FloatArray, basis: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return what a ``basis`` leaves of columns (..., recording, value), and what it takes: see `projections`."""
    taken = projections(columns, basis)
    if basis.ndim == 2:
        return np.asarray(columns - taken @ basis.T), taken
    return columns - _by_recording(taken, basis.swapaxes(1, 2)), taken


def projections(columns: FloatArray, basis: FloatArray) -> FloatArray:
    """Return how much of columns (..., recording, value) each vector of a ``basis`` (value, vector) or (recording,
    value, vector) takes, (..., recording, vector).
    """
    return np.asarray(columns @ basis if basis.ndim == 2 else _by_recording(columns, basis))


def _by_recording(rows: FloatArray, matrices: FloatArray) -> FloatArray:
    """Return products of rows (..., recording, entry) with a matrix of each recording, (recording, entry, to)."""
    many = rows.reshape(-1, *rows.shape[-2:]).swapaxes(0, 1)  # all of a recording at once
    return np.asarray((many @ matrices).swapaxes(0, 1).reshape(*rows.shape[:-1], matrices.shape[-1]))


def _in_states(upper: FloatArray, taken: FloatArray) -> FloatArray:
    """Return the initial states (..., recording, state) that show what is ``taken`` (..., recording, vector) by the
    basis of the triangle ``upper`` (vector, state) or (recording, vector, state).
    """
    # a triangle is taken apart once for all of a recording
    many = taken.reshape(-1, *taken.shape[-2:]).transpose(1, 2, 0)
    return np.asarray(np.linalg.solve(upper, many).transpose(2, 0, 1).reshape(taken.shape), dtype=np.float64)


def _errors(upper: FloatArray, states: FloatArray) -> FloatArray:
    """Return the standard deviations of ``states`` from the triangle of their Jacobian's QR factorisation."""
    return np.broadcast_to(np.linalg.norm(np.linalg.inv(upper), axis=-1), states.shape)


def _spread(part: Linearisation, kept: list[int], parameters: int) -> Linearisation:
    """Return a linearisation by all ``parameters`` from that by the ``kept`` ones."""
    if len(part.slopes) in (parameters, 0):
        return part

    def full(slopes: FloatArray) -> FloatArray:
        every = np.zeros((parameters, *slopes.shape[1:]))
        every[kept] = slopes
        return every

    return replace(part, slopes=full(part.slopes), state_slopes=full(part.state_slopes))


def orthonormal(columns: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return Q and R of columns (..., value, state), with a ridge below them that keeps R from being singular.

    In proportion to each: columns by displacements of high modes are millions of times those by a force. What no sensor
    feels, as the axial modes of a beam whose sensors look across, must not be scaled up from rounding to noise.
    """
    sizes = np.linalg.norm(columns, axis=-2)
    states, largest = columns.shape[-1], sizes.max(axis=-1, keepdims=True)
    ridge = np.where(sizes < LINEARISATION.unobserved_share * largest, largest, LINEARISATION.ridge * sizes)
    Q, R = np.linalg.qr(np.concatenate([columns, ridge[..., None] * np.eye(states)], axis=-2))
    return Q[..., :-states, :], R
