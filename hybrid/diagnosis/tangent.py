"""Channels near a known motion under force laws, to first order: single steps from all its samples at once.

A motion z_k and what a step does to it, z_k+1 = g(z_k, theta), give the slopes of all that follows by the chain rule,

    dz_k+1 = g_z dz_k + g_theta dtheta,

so that only this recursion runs along time; g_z and g_theta are finite differences of steps that do not wait for one
another.
"""

import numpy as np

from fe_models.dofs import FloatArray
from hybrid.diagnosis.system import System, as_shown, march

AT_ONCE = 64  # samples whose steps are taken together: as many as stay in a processor's cache


def channels_near(system: System, path: FloatArray, size: FloatArray) -> FloatArray | None:
    """Return channels (variant, recording, time, sensor) of variants near the motion of the first, None if they fail.

    ``path`` (time, recording, state): the motion. The last variants, one for each state, are equal to the first and
    start with one state larger by ``size`` (state,); those between begin where the first does.
    """
    samples, recordings, states = path.shape
    variants = len(system.A)
    own = variants - states  # the first and those that differ from it in a parameter
    moved = np.zeros((recordings, variants - 1, states))
    moved[:, own - 1 :] = np.diag(size)
    y = np.empty((samples, variants, recordings, system.C.shape[1]))
    for first in range(0, samples, AT_ONCE):
        part = path[first : first + AT_ONCE]
        count = len(part)
        start = np.repeat(part.reshape(1, -1, states), variants, axis=0)
        start[own:] += np.diag(size)[:, None]
        stepped = march(system, start, 2)
        if stepped is None:
            return None
        shown = start @ system.C.transpose(0, 2, 1) + stepped[1][0] @ system.D.transpose(0, 2, 1)
        g, h = (
            values.reshape(variants, count, recordings, -1).transpose(1, 2, 0, 3) for values in (stepped[0][1], shown)
        )  # (time, recording, variant, state) and (..., sensor)
        g_state, h_state = ((values[:, :, own:] - values[:, :, :1]) / size[:, None] for values in (g, h))
        g_own, h_own = (values[:, :, 1:own] - values[:, :, :1] for values in (g, h))
        motions = np.empty((count, recordings, variants - 1, states))
        for k in range(count):
            motions[k] = moved
            moved = moved @ g_state[k]
            moved[:, : own - 1] += g_own[k]
        change = motions @ h_state
        change[:, :, : own - 1] += h_own
        y[first : first + count, 0] = h[:, :, 0]
        y[first : first + count, 1:] = (h[:, :, :1] + change).transpose(0, 2, 1, 3)
    if not np.isfinite(y).all():
        return None
    return as_shown(system, np.ascontiguousarray(y.transpose(1, 2, 0, 3)))
