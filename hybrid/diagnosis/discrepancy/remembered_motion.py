"""How modes move on under a spring with a memory: exact for modes, the force linear in time in parts of a step."""

import numpy as np
from scipy.linalg import expm

from fe_models.arrays import FloatArray
from hybrid.compiled import compiled
from hybrid.diagnosis.discrepancy.config import DISCREPANCY
from hybrid.diagnosis.discrepancy.hysteresis import step_of
from hybrid.diagnosis.discrepancy.law_forces import RememberedForce
from hybrid.diagnosis.discrepancy.modal_space import ModalSpace


def moved_on(
    law: RememberedForce, space: ModalSpace, states: FloatArray, samples: int
) -> tuple[FloatArray, FloatArray]:
    """Return the ``states`` (time, 2 mode) of a motion's beginning with those that follow, (sample, 2 mode), and the
    force (sample,) along the law's pull, as a low-pass leaves it.
    """
    spring, along, n = law.hysteresis.spring, law.pull @ space.shapes, space.count
    u = space.fine_motion(states).q @ along
    z = law.hysteresis.along(u).z
    old, new = _kicks(space)
    later = _march(
        space.propagators[0, 1],
        along * old,
        along * new,
        along,
        states[-1].reshape(2, n),
        float(z[-1]) / spring.reach,
        (samples - len(states)) * DISCREPANCY.parts,
        spring.stiffness,
        spring.reach,
        *law.hysteresis.curve,
        spring.sharpness,
    )
    force = -spring.stiffness * np.concatenate([z, later])
    added = space.pushed(force, law.pull).states
    added[: len(states) - 1] = 0.0
    found = space.motion(added)
    found[: len(states)] = states
    free = states[-1]
    for time in range(len(states), samples):
        free = space.whole_transition @ free
        found[time] += free
    return found, space.passed(force)[:: DISCREPANCY.parts]


def _kicks(space: ModalSpace) -> tuple[FloatArray, FloatArray]:
    """Return what a modal force of one adds to q and q' in a part of a step, (2, mode), that goes to nothing there, and
    that comes from nothing.
    """
    interval, found = space.step / DISCREPANCY.parts, np.zeros((2, 2, space.count))
    for mode, (omega, ratio) in enumerate(zip(space.omega, space.ratio, strict=True)):
        system = np.zeros((4, 4))  # of q, q', the force and its growth
        system[0, 1], system[1, :3], system[2, 3] = 1.0, (-(omega**2), -2 * ratio * omega, 1.0), 1 / interval
        moved = expm(interval * system)
        found[:, :, mode] = moved[:2, 2] - moved[:2, 3], moved[:2, 3]
    return found[0], found[1]


@compiled
def _march(
    propagator: FloatArray,
    old: FloatArray,
    new: FloatArray,
    along: FloatArray,
    begun: FloatArray,
    first: float,
    parts: int,
    stiffness: float,
    reach: float,
    elongation: FloatArray,
    share: FloatArray,
    slope: FloatArray,
    sharpness: float,
) -> FloatArray:
    """Return z (part,), m, after each part: the force at its end is found by two steps of iteration."""
    modes = len(along)
    state, free, found = begun.copy(), np.zeros((2, modes)), np.zeros(parts)
    y, u = first, 0.0
    for mode in range(modes):
        u += along[mode] * state[0, mode]
    for part in range(parts):
        force, ahead, there, later = -stiffness * reach * y, -stiffness * reach * y, y, u
        for i in range(2):
            for mode in range(modes):
                free[i, mode] = propagator[mode, i, 0] * state[0, mode] + propagator[mode, i, 1] * state[1, mode]
        for _ in range(3):
            later = 0.0
            for mode in range(modes):
                later += along[mode] * (free[0, mode] + old[0, mode] * force + new[0, mode] * ahead)
            there = step_of(y, (later - u) / reach, elongation, share, slope, sharpness)[0]
            ahead = -stiffness * reach * there
        for i in range(2):
            for mode in range(modes):
                state[i, mode] = free[i, mode] + old[i, mode] * force + new[i, mode] * ahead
        y, u = there, later
        found[part] = reach * y
    return found
