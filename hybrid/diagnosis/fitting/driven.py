"""The linear channels of a system under forces whose history is known."""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from fe_models.arrays import ComplexArray, FloatArray
from hybrid.compiled import compiled
from hybrid.diagnosis.fitting.config import FORECAST
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.nominal.loads import Loads
from hybrid.diagnosis.recorded.batches import Batch
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.response.loaded import loaded_states
from hybrid.diagnosis.response.marching import march
from hybrid.diagnosis.response.residual_states import with_residual
from hybrid.diagnosis.response.state_space import system_of
from hybrid.diagnosis.response.system import ModalForm, System, through_lowpass
from hybrid.observability import observability_by_doubling


@dataclass(frozen=True)
class History:
    """What acts along a motion, at samples and half a step after each: ``now`` and ``between``, alike in shape."""

    now: FloatArray
    between: FloatArray


def motion_of(system: System, states: FloatArray, samples: int, loads: Loads | None = None) -> History | None:
    """Return the states (time, recording, state) of the system's first variant from initial ones (recording, state)
    under known ``loads``, those of residual coordinates last; None where they grow beyond all bounds.
    """
    found = _at_samples(system, states, samples, loads)
    if found is None:
        return None
    now, forces = found
    half, push = _half_a_step(system if system.is_linear else with_residual(system))
    between = now @ half.T + forces @ push.T
    if loads is not None:  # these move the modes alone
        own = states.shape[-1]
        start, later = (loaded_states(system, loads, ahead) for ahead in (0.0, system.step / 2))
        between[..., :own] += later - start @ half[:own, :own].T
    return History(now, between)


def sampled_motion(system: System, states: FloatArray, samples: int, loads: Loads | None) -> FloatArray | None:
    """Return what `motion_of` does at the samples, (time, recording, state); None likewise."""
    found = _at_samples(system, states, samples, loads)
    return None if found is None else found[0]


def _at_samples(
    system: System, states: FloatArray, samples: int, loads: Loads | None
) -> tuple[FloatArray, FloatArray] | None:
    """Return the states (time, recording, state) at samples and the laws' pulls there (time, recording, law)."""
    if not system.is_linear:
        marched = march(system, states[None], samples, loads)
        return None if marched is None else (marched.watched[0].swapaxes(0, 1), marched.forces[0].swapaxes(0, 1))
    turn = expm(system.A[0] * system.step).T
    now = observability_by_doubling(states[None], turn[None], samples, np.concatenate)  # states A'^k, as C A^k
    return now if loads is None else now + loaded_states(system, loads), np.zeros((*now.shape[:2], 0))


def _half_a_step(system: System) -> tuple[FloatArray, FloatArray]:
    """Return what half a step makes of a state (state, state) and of forces that stay as they are (state, law)."""
    states, laws = system.B.shape[1:]
    both = np.zeros((states + laws, states + laws))
    both[:states] = np.concatenate([system.A[0], system.B[0]], axis=1)
    moved = expm(both * system.step / 2)
    return moved[:states, :states], moved[:states, states:]


def fitted_motion(system: System, states: FloatArray, batch: Batch) -> History:
    """Return the motion of a fit to a batch from its initial ``states`` (recording, state)."""
    motion = motion_of(system, states, batch.samples, batch.loads)
    assert motion is not None  # it was fitted
    return motion


def states_along(item: Fit, noise_model: NoiseModel) -> FloatArray:
    """Return states (n, state) of a fit that show how large its motion is, at `FORECAST.states_per_segment` places of a
    segment or more.
    """
    found = []
    system = system_of(item.hypothesis, item.theta[None], noise_model.outputs)
    for batch, states in zip(item.batches, item.states, strict=True):
        motion = fitted_motion(system, states, batch).now
        found.append(motion[:: max(batch.samples // FORECAST.states_per_segment, 1)].reshape(-1, motion.shape[-1]))
    return np.concatenate(found)


def forces_along(system: System, motion: History) -> tuple[History, ...]:
    """Return the pull (time, recording) of each of the system's force laws along a motion."""
    laws, system = len(system.forces), with_residual(system)

    def pull(states: FloatArray, law: int) -> FloatArray:
        u, v = (states @ system.G[0, row] for row in (law, laws + law))
        return np.asarray(-system.forces[law](u[None], v[None])[0])

    return tuple(History(pull(motion.now, law), pull(motion.between, law)) for law in range(laws))


def driven_channels(
    form: ModalForm, variant: int, feed: FloatArray, direct: FloatArray, force: History, system: System
) -> FloatArray:
    """Return the channels (recording, time, sensor) of a ``system`` from rest under a ``force`` (time, recording).

    ``form``: its `free_form`; ``feed`` (state,): what a unit force adds to the rate of the state; ``direct`` (sensor,):
    what it shows at once.
    Simpson's rule over each step, in each mode.
    """
    moved, step = form.left[variant] @ feed, system.step  # (mode,)
    roots, right = form.roots[variant], form.right[variant]
    x = np.empty((2, len(moved), *force.now.shape))  # real and imaginary parts of (mode, time, recording)
    whole, half = np.exp(roots * step), np.exp(roots * step / 2)
    _accumulate(whole, half, step / 6 * moved, force.now, force.between, x)
    y = (np.hstack([right.real, -right.imag]) @ x.reshape(2 * len(moved), -1)).reshape(-1, *force.now.shape)
    return through_lowpass(y.transpose(2, 1, 0) + direct * force.now.T[..., None], system)


@compiled
def _accumulate(
    whole: ComplexArray,
    half: ComplexArray,
    moved: ComplexArray,
    now: FloatArray,
    between: FloatArray,
    x: FloatArray,
) -> None:
    """Fill ``x`` (2, mode, time, recording), real and imaginary parts, with each mode from rest: in each step it turns
    by ``whole``, in half of one by ``half``, and gains ``moved`` (mode,) times Simpson's sum of the force (time,
    recording) ``now`` and ``between``.
    """
    modes, samples, recordings = x.shape[1:]
    for mode in range(modes):
        turn, mid, share = whole[mode], half[mode], moved[mode]
        re, im = x[0, mode], x[1, mode]
        for recording in range(recordings):
            re[0, recording] = im[0, recording] = 0.0
        for k in range(samples - 1):
            for recording in range(recordings):
                begun, ended = now[k, recording], now[k + 1, recording]
                kick = turn * begun + 4.0 * mid * between[k, recording] + ended
                state = turn * complex(re[k, recording], im[k, recording]) + share * kick
                re[k + 1, recording], im[k + 1, recording] = state.real, state.imag
