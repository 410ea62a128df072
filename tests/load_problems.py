"""Storeys under known loads that one instrument recorded with a fault, by another solver than the project's own."""

from itertools import pairwise
from typing import Literal

import numpy as np
from scipy.linalg import eigh, expm
from scipy.signal import butter, sosfiltfilt

from fe_models.arrays import FloatArray
from fe_models.recordings import Load, Recording, Sensor
from fe_models.structure import Damping, PointMass, Spring, Structure

RATE, FINE = 50.0, 20  # Hz; steps of the solver to a sample
MASS, STIFFNESS, RATIO = 25.0, 1e4, 0.02
LEVELS = 3
SENSORS = tuple(Sensor(f"a{node}", node, "x", "acceleration", "m/s^2") for node in range(1, LEVELS + 1))
STOREYS = Structure(
    name="storeys",
    nodes=tuple((0.0, float(level)) for level in range(1, LEVELS + 1)),
    directions=("x",),
    elements=(Spring((1,), "x", STIFFNESS), *(Spring((n, n + 1), "x", STIFFNESS) for n in range(1, LEVELS))),
    point_masses=tuple(PointMass(node, MASS) for node in range(1, LEVELS + 1)),
    damping=Damping(modal_ratios=(RATIO,)),
)


def force(seed: int, samples: int) -> FloatArray:
    """Return a random force (fine time,) between 0.3 and 8 Hz that comes and goes."""
    white = np.random.default_rng(seed).standard_normal((samples + 40) * FINE)
    passed = sosfiltfilt(butter(3, [0.3, 8.0], btype="band", fs=RATE * FINE, output="sos"), white)
    part = np.arange(passed.size) / passed.size
    return np.asarray(60 * passed / passed.std() * np.exp(-(((part - 0.4) / 0.25) ** 2)))


def accelerations(pull: FloatArray, course: FloatArray) -> FloatArray:
    """Return the accelerations (fine time, level) under a ``course`` along ``pull``, straight in each fine step."""
    K = np.diag([2.0] * (LEVELS - 1) + [1.0]) - np.eye(LEVELS, k=1) - np.eye(LEVELS, k=-1)
    K, M = STIFFNESS * K, MASS * np.eye(LEVELS)
    omega2, shapes = eigh(K, M)
    C = M @ shapes @ np.diag(2 * RATIO * np.sqrt(omega2)) @ shapes.T @ M
    states, h = 2 * LEVELS, 1 / RATE / FINE
    A = np.zeros((states + 2, states + 2))
    A[:LEVELS, LEVELS:states] = np.eye(LEVELS)
    A[LEVELS:states, :LEVELS], A[LEVELS:states, LEVELS:states] = -K / MASS, -C / MASS
    A[LEVELS:states, states], A[states, states + 1] = pull / MASS, 1 / h
    step = expm(A * h)
    z, found = np.zeros(states), np.empty((course.size - 1, LEVELS))
    for k, (now, then) in enumerate(pairwise(course)):
        found[k] = A[LEVELS:states, :states] @ z + pull / MASS * now
        z = step[:states, :states] @ z + step[:states, states] * now + step[:states, states + 1] * (then - now)
    return found


def recordings(pull: FloatArray, late: float = 0.0, gain: float = 1.0, samples: int = 900) -> tuple[Recording, ...]:
    """Return two recordings to train on and one to test with; loads are recorded ``late`` by so many samples."""
    found = []
    for seed, name in enumerate(("a", "b", "test")):
        course = force(seed, samples)
        at = (20 + np.arange(samples)) * FINE
        data = accelerations(pull, course)[at]
        noise = np.random.default_rng(seed + 100).standard_normal(data.shape)
        recorded = gain * course[at - round(late * FINE)]
        loads = tuple(Load(node, "x", part * recorded) for node, part in enumerate(pull, start=1) if part)
        role: Literal["train", "test"] = "test" if name == "test" else "train"
        found.append(Recording(name, (data + 0.02 * data.std() * noise)[None], role, loads))
    return tuple(found)
