"""The linear channels of a system under forces whose history is known."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import expm
from scipy.signal import lfilter

from fe_models.dofs import FloatArray
from hybrid.diagnosis.marching import march
from hybrid.diagnosis.system import ModalForm, System, modal_form

SOFT = 1e-8  # of the highest eigenvalue: springs that hold a body that moves freely


@dataclass(frozen=True)
class History:
    """What acts along a motion, at samples and half a step after each: ``now`` and ``between``, alike in shape."""

    now: FloatArray
    between: FloatArray


def motion_of(system: System, states: FloatArray, samples: int) -> History | None:
    """Return the states (time, recording, state) of the system's first variant from initial ones (recording, state).

    None where they grow beyond all bounds.
    """
    half = expm(system.A[0] * system.step / 2)
    if system.is_linear:
        seen = np.empty((samples, *states.shape))
        seen[0], whole = states, half @ half
        for k in range(samples - 1):
            seen[k + 1] = seen[k] @ whole.T
    else:
        marched = march(system, states[None], samples)
        if marched is None:
            return None
        seen = marched[0][:, 0]
    return History(seen, seen @ half.T)


def forces_along(system: System, motion: History) -> tuple[History, ...]:
    """Return the pull (time, recording) of each of the system's force laws along a motion."""
    laws = len(system.forces)

    def pull(states: FloatArray, law: int) -> FloatArray:
        u, v = (states @ system.G[0, row] for row in (law, laws + law))
        return np.asarray(-system.forces[law](u[None], v[None])[0])

    return tuple(History(pull(motion.now, law), pull(motion.between, law)) for law in range(laws))


def free_form(system: System, n: int) -> ModalForm:
    """Return the modal form of a system of ``n`` coordinates without its force laws; a body that moves freely is held
    by soft springs, which part roots that fall together.
    """
    free = replace(system, forces=())
    form = modal_form(free)
    if form is None:
        A = system.A.copy()
        A[:, range(n, 2 * n), range(n)] -= SOFT * np.abs(np.linalg.eigvals(A)).max() ** 2
        form = modal_form(replace(free, A=A))
    assert form is not None  # nothing moves freely now
    return form


def driven(
    form: ModalForm, variant: int, feed: FloatArray, direct: FloatArray, force: History, step: float
) -> FloatArray:
    """Return the channels (recording, time, sensor) from rest under a ``force`` (time, recording).

    ``feed`` (state,): what a unit force adds to the rate of the state; ``direct`` (sensor,): what it shows at once.
    Simpson's rule over each step, in each mode.
    """
    moved = form.left[variant] @ feed  # (mode,)
    count, recordings = force.now.shape
    x = np.zeros((len(moved), count, recordings), dtype=complex)
    for mode, root in enumerate(form.roots[variant]):
        whole, half = np.exp(root * step), np.exp(root * step / 2)
        kick = whole * force.now[:-1] + 4 * half * force.between[:-1] + force.now[1:]
        x[mode, 1:] = lfilter([step / 6 * moved[mode]], [1.0, -whole], kick, axis=0)
    right, flat = form.right[variant], x.reshape(len(moved), -1)
    y = (np.hstack([right.real, -right.imag]) @ np.vstack([flat.real, flat.imag])).reshape(-1, count, recordings)
    return np.asarray(y.transpose(2, 1, 0) + direct * force.now.T[..., None])
