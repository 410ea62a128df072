"""Motion under force laws, to first order about a motion that is nearly right.

    x' = A x + k(x) in each step,   y = C x + direct f(x),   x = x0 + d:
    d' = (A + dk/dx) d + (A x0 + k(x0) - x0'),   y - C x0 - direct f(x0) = (C + direct df/dx) d

so that a filter that knows the slopes of the forces finds motion and forces together, as Newton's method would. What a
law remembers is a state beside q and q', d = (q, q', z).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from fe_models.arrays import FloatArray
from hybrid.diagnosis.discrepancy.law_forces import DirectForce, LawForce, RememberedForce
from hybrid.diagnosis.discrepancy.modal_space import FineMotion, ModalSpace, Push

FIRST_SHARE = 0.3  # of its reach: how far what a spring remembers at first may be from that of a slow pull


@dataclass(frozen=True, eq=False)
class LinearisedMotion:
    """The ``states`` (time, 2 mode) about which a motion is linear; the ``transition`` (time, state, state) of what is
    beside them, and the ``drift`` (time, 2 mode) that it has in each step; the ``output`` (time, sensor, state) and
    what the states have ``shown`` (time, sensor). One transition and output alone: the same at all times. States beyond
    q and q' are what laws remember, of which ``first`` (law,) is the standard deviation at first, m.
    """

    states: FloatArray
    transition: FloatArray
    drift: FloatArray
    output: FloatArray
    shown: FloatArray
    first: FloatArray = field(default_factory=lambda: np.zeros(0))

    def with_memories(self, values: FloatArray) -> FloatArray:
        """Return ``values`` (..., 2 mode) with zeros for what laws remember, (..., state)."""
        return np.concatenate([values, np.zeros((*values.shape[:-1], len(self.first)))], axis=-1)


def unforced(space: ModalSpace, samples: int) -> LinearisedMotion:
    """Return the motion of modes under no forces: linear about rest."""
    size, sensors = 2 * space.count, len(space.shown)
    rest = np.zeros((samples, size))
    return LinearisedMotion(rest, space.whole_transition[None], rest, space.output[None], np.zeros((samples, sensors)))


def pushed_by(law: LawForce, space: ModalSpace, motion: FineMotion) -> Push:
    """Return what a law adds along a ``motion``."""
    return space.pushed(-law.along(*elongation_of(law, space, motion)), law.pull)


def elongation_of(law: LawForce, space: ModalSpace, motion: FineMotion) -> tuple[FloatArray, FloatArray]:
    """Return elongation and rate (part,) of a law along a ``motion``."""
    along = law.pull @ space.shapes
    return motion.q @ along, motion.rate @ along


def linearised(space: ModalSpace, states: FloatArray, laws: Sequence[LawForce]) -> LinearisedMotion:
    """Return the motion under force ``laws`` about ``states`` (time, 2 mode)."""
    motion, size = space.fine_motion(states), states.shape[1]
    remembering = [law for law in laws if isinstance(law, RememberedForce)]
    whole, A, C = size + len(remembering), space.whole_transition, space.output
    transition, output = np.zeros((len(states), whole, whole)), np.zeros((len(states), len(C), whole))
    transition[:, :size, :size], output[:, :, :size] = A, C
    drift, shown = states @ A.T, states @ C.T
    for law in laws:
        push = pushed_by(law, space, motion)
        drift, shown = drift + push.states, shown + push.channels
        u, v = elongation_of(law, space, motion)
        if isinstance(law, DirectForce):
            by_u, by_v = law.slopes(u, v)
            steps, felt = space.stiffened(-by_u, -by_v, law.pull)
            transition[:, :size, :size] += steps
            output[:, :, :size] += felt
    for number, law in enumerate(remembering, start=size):
        course = law.hysteresis.along(elongation_of(law, space, motion)[0])
        stiffness = law.hysteresis.spring.stiffness
        own = [*range(size), number]
        steps, memory, felt = space.remembered(course.kept, course.follows, -stiffness, law.pull)
        transition[:, :size, own] += steps
        transition[:, number, own] = memory
        output[:, :, number] += felt
    drift[:-1] -= states[1:]
    drift[-1] = 0.0
    first = np.array([FIRST_SHARE * law.hysteresis.spring.reach for law in remembering])
    return LinearisedMotion(states, transition, drift, output, shown, first)
