"""Motion under force laws, to first order about a motion that is nearly right.

    x' = A x + k(x) in each step,   y = C x + direct f(x),   x = x0 + d:
    d' = (A + dk/dx) d + (A x0 + k(x0) - x0'),   y - C x0 - direct f(x0) = (C + direct df/dx) d

so that a filter that knows the slopes of the forces finds motion and forces together, as Newton's method would.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from fe_models.arrays import TINY, FloatArray
from hybrid.diagnosis.discrepancy.modal_space import ModalSpace

SLOPE_STEP = 1e-5  # of the rms elongation, or rate

LawForce = tuple[FloatArray, Callable[[FloatArray, FloatArray], FloatArray]]
"""A pull (dof,), and the force by which elongation and rate (part,) are pulled back (part,)."""


@dataclass(frozen=True, eq=False)
class Linearisation:
    """The ``states`` (time, 2 mode) about which a motion is linear; the ``transition`` (time, 2 mode, 2 mode) of what
    is beside them, and the ``drift`` (time, 2 mode) that it has in each step; the ``output`` (time, sensor, 2 mode) and
    what the states have ``shown`` (time, sensor). One transition and output alone: the same at all times.
    """

    states: FloatArray
    transition: FloatArray
    drift: FloatArray
    output: FloatArray
    shown: FloatArray


def linear(space: ModalSpace, samples: int) -> Linearisation:
    """Return the motion of modes under no forces: linear about rest."""
    size, sensors = 2 * space.count, len(space.shown)
    rest = np.zeros((samples, size))
    return Linearisation(rest, space.whole_transition[None], rest, space.output[None], np.zeros((samples, sensors)))


def pushed_by(
    law: LawForce, space: ModalSpace, between: tuple[FloatArray, FloatArray]
) -> tuple[FloatArray, FloatArray]:
    """Return what a law adds to the states in each step (time, 2 mode), and to the channels at once (time, sensor),
    along a motion whose states within the steps, q and q' (part, mode), are ``between``.
    """
    pull, force = law
    along = pull @ space.shapes
    u, v = (part @ along for part in between)
    return space.pushed(-force(u, v), pull)


def linearised(space: ModalSpace, states: FloatArray, laws: Sequence[LawForce]) -> Linearisation:
    """Return the motion under force ``laws`` about ``states`` (time, 2 mode)."""
    between = space.between(states)
    A, C = space.whole_transition, space.output
    transition, output = np.repeat(A[None], len(states), axis=0), np.repeat(C[None], len(states), axis=0)
    drift, shown = states @ A.T, states @ C.T
    for law in laws:
        pull, force = law
        added, direct = pushed_by(law, space, between)
        drift, shown = drift + added, shown + direct
        by_u, by_v = _slopes(force, *(part @ (pull @ space.shapes) for part in between))
        steps, felt = space.stiffened(-by_u, -by_v, pull)
        transition += steps
        output += felt
    drift[:-1] -= states[1:]
    drift[-1] = 0.0
    return Linearisation(states, transition, drift, output, shown)


def _slopes(
    force: Callable[[FloatArray, FloatArray], FloatArray], u: FloatArray, v: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the slopes (part,) of a force by elongation and rate."""
    steps = [SLOPE_STEP * max(float(np.std(part)), TINY) for part in (u, v)]
    by_u = (force(u + steps[0], v) - force(u - steps[0], v)) / (2 * steps[0])
    by_v = (force(u, v + steps[1]) - force(u, v - steps[1])) / (2 * steps[1])
    return by_u, by_v
