"""The initial states of recordings of which a stretch is known, for a model that is: the most probable ones."""

import numpy as np

from fe_models.arrays import FloatArray
from hybrid.diagnosis.fitting.config import INITIAL_STATES
from hybrid.diagnosis.recorded.batches import Batch
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.response.hypothesis import Hypothesis
from hybrid.diagnosis.response.loaded import given
from hybrid.diagnosis.response.marching import respond
from hybrid.diagnosis.response.state_space import system_of
from hybrid.diagnosis.response.system import System, drift, drifted, observability


def initial_states(
    hypothesis: Hypothesis,
    theta: FloatArray,
    spread: FloatArray,
    batch: Batch,
    noise_model: NoiseModel,
    near: FloatArray | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Return the most probable states (recording, state) given the fitted channels of a ``batch``, and their costs.

    Prior: normal with covariance ``spread`` (state, state). ``near``: states that are nearly so, from where force
    laws begin at once over the whole stretch.
    """
    return states_of(system_of(hypothesis, theta[None], noise_model.outputs), spread, batch, noise_model, near)


def states_of(
    system: System, spread: FloatArray, batch: Batch, noise_model: NoiseModel, near: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """Return what `initial_states` does, of a ``system`` of one variant."""
    prior = precision_of(spread)
    if system.is_linear:
        return _linear_states(system, prior, batch, noise_model)
    moved = INITIAL_STATES.difference_step * np.sqrt(np.diag(spread))
    if near is not None:
        return _states_under_laws(system, prior, moved, batch, noise_model, near)
    stretches = [batch.first(_samples(share, batch)) for share in INITIAL_STATES.stretch_shares]
    states, cost = _linear_states(system.unforced, prior, stretches[0], noise_model)
    for stretch in stretches:
        states, cost = _states_under_laws(system, prior, moved, stretch, noise_model, states)
    return states, cost


def precision_of(spread: FloatArray) -> FloatArray:
    """Return the inverse of a covariance (state, state), whose entries are of several units."""
    size = np.sqrt(np.diag(spread))
    return np.asarray(np.linalg.inv(spread / np.outer(size, size)) / np.outer(size, size))


def _cost(states: FloatArray, prior: FloatArray) -> FloatArray:
    """Return the sums of squares (recording,) that states (recording, state) cost by the ``prior``'s precision."""
    return np.asarray(np.einsum("rs,st,rt->r", states, prior, states))


def _samples(share: float, batch: Batch) -> int:
    return max(round(share * batch.samples), 2)


def _linear_states(
    system: System, prior: FloatArray, batch: Batch, noise_model: NoiseModel
) -> tuple[FloatArray, FloatArray]:
    """Return what `initial_states` does, of a linear system: by least squares."""
    recordings, samples, _ = batch.data.shape
    weight = batch.weights(noise_model)  # (recording or one row, value)
    free = batch.data - given(system, batch)[0]
    shown = observability(system, samples)[0].reshape(-1, len(prior))
    wanted = (free.reshape(recordings, -1) - drift(system, samples)[0].ravel()) * weight
    precision = np.stack([(shown.T * square) @ shown for square in weight**2]) + prior
    states = np.linalg.solve(precision, ((wanted * weight) @ shown)[..., None])[..., 0]
    return states, np.sum((wanted - states @ shown.T * weight) ** 2, axis=1) + _cost(states, prior)


def _states_under_laws(
    system: System, prior: FloatArray, moved: FloatArray, batch: Batch, noise_model: NoiseModel, states: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return what `initial_states` does, of force laws, from ``states``: by Levenberg and Marquardt's steps.

    Finite differences move each entry of a state by ``moved`` (state,), in further recordings of one system.
    """
    recordings = len(states)
    weight = batch.weights(noise_model)  # (recording or one row, value)
    wanted = (batch.data - drifted(system, batch.begins)[0]).reshape(recordings, -1) * weight
    far = INITIAL_STATES.max_motion_ratio * float(np.abs(wanted).max())
    cost, damping = np.full(recordings, np.inf), np.full(recordings, INITIAL_STATES.damping.start)
    X, residual, trial = np.zeros((recordings, wanted.shape[1], len(moved))), wanted, states
    for _ in range(INITIAL_STATES.max_iterations):
        starts = np.repeat(trial[None], len(moved) + 1, axis=0)
        starts[1:] += np.diag(moved)[:, None]
        shown = respond(system, starts.reshape(1, -1, len(moved)), batch.samples, batch.loads)
        y = shown.reshape(len(starts), recordings, -1) * weight
        y = np.nan_to_num(y, nan=far, posinf=far, neginf=-far)
        left = wanted - y[0]
        new = np.sum(left**2, axis=1) + _cost(trial, prior)
        better = new < cost
        slopes = ((y[1:] - y[0]) / moved[:, None, None]).transpose(1, 2, 0)
        states, cost = np.where(better[:, None], trial, states), np.minimum(cost, new)
        X = np.where(better[:, None, None], slopes, X)
        residual = np.where(better[:, None], left, residual)
        damping = INITIAL_STATES.damping.after(damping, better)
        H = np.einsum("rvs,rvt->rst", X, X, optimize=True) + prior
        H = H + damping[:, None, None] * np.einsum("rss->rs", H)[:, :, None] * np.eye(len(moved))
        g = np.einsum("rvs,rv->rs", X, residual) - states @ prior
        step = np.linalg.solve(H, g[..., None])[..., 0]
        if np.all(np.sum(g * step, axis=1) < INITIAL_STATES.min_gain):
            break
        trial = states + step
    return states, cost
