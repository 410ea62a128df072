"""A Kalman filter for modes whose motion is driven by a little white force, with all that needs a loop over samples.

What the filter did not expect, each sample's in units of its own uncertainty, is white where the discrepancy is as
large as was taken: phase drift, which such a force brings about, does not count anew at each sample.
"""

from dataclasses import dataclass

import numpy as np

from fe_models.arrays import FloatArray
from hybrid.compiled import compiled, put_matrix, put_vector
from hybrid.diagnosis.discrepancy.linearisation import LinearisedMotion


@dataclass(frozen=True, eq=False)
class FilteredMotion:
    """What the filter makes of a motion that is linear as ``linearisation`` says: ``white`` (time, sensor), what it did
    not expect; its ``gains`` (time, state, sensor); ``scales`` (time, sensor, sensor) that whiten; ``states`` (time,
    state), smoothed; ``log_scale``: of all scales, what a log density has of them.
    """

    linearisation: LinearisedMotion
    white: FloatArray
    gains: FloatArray
    scales: FloatArray
    states: FloatArray
    log_scale: float

    @property
    def log_density(self) -> float:
        """The log density of the data, but for what is the same of all."""
        return self.log_scale - 0.5 * float(np.sum(self.white**2))


def filtered(
    about: LinearisedMotion, data: FloatArray, noise: FloatArray, pushes: FloatArray, begin: FloatArray, step: float
) -> FilteredMotion:
    """Return what a filter makes of ``data`` (time, sensor) with a variance of ``noise`` (time, sensor), or (sensor,),
    linear ``about`` some motion.

    ``pushes`` (time, mode): the variance of each mode's rate by the force of a ``step`` (s); ``begin`` (2 mode,): that
    of the initial state.
    """
    noise = np.array(np.broadcast_to(noise, data.shape), order="C")  # of another layout the filter is compiled anew
    T, C = about.transition, about.output
    drift, first = about.with_memories(about.drift), about.with_memories(-about.states[0])
    variances = np.append(begin, about.first**2)
    white, gains, scales, predicted, covariance, log_scale = _filter(
        T, C, drift, pushes, step, noise, data - about.shown, first, variances
    )
    states = about.states + _smooth(T, C, white, gains, scales, predicted, covariance)[:, : about.states.shape[1]]
    return FilteredMotion(about, white, gains, scales, states, -float(log_scale))


def unexpected(known: FilteredMotion, added: FloatArray, shown: FloatArray) -> FloatArray:
    """Return what the filter would not expect of motions that it does not know, white (variant, time, sensor): driven
    by what is ``added`` to states (variant, time, 2 mode), and ``shown`` (variant, time, sensor) at once.
    """
    about, added = known.linearisation, known.linearisation.with_memories(added)
    return np.asarray(_respond(about.transition, about.output, known.gains, known.scales, added, shown))


@compiled
def _filter(
    T: FloatArray,
    C: FloatArray,
    drift: FloatArray,
    pushes: FloatArray,
    step: float,
    noise: FloatArray,
    data: FloatArray,
    first: FloatArray,
    begin: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray, float]:
    """Return what was not expected, gains, scales, states and covariances as they were predicted, and the log scale."""
    samples, sensors = data.shape
    size, modes, varying = len(first), pushes.shape[1], len(T) > 1
    white, gains = np.zeros((samples, sensors)), np.zeros((samples, size, sensors))
    scales, predicted = np.zeros((samples, sensors, sensors)), np.zeros((samples, size))
    covariance = np.zeros((samples, size, size))
    x, P, log_scale = first.copy(), np.zeros((size, size)), 0.0
    for i in range(size):
        P[i, i] = begin[i]
    for time in range(samples):
        A, seen = T[time if varying else 0], C[time if varying else 0]
        put_vector(x, predicted[time])
        put_matrix(P, covariance[time])
        PC = P @ seen.T
        S = seen @ PC
        for i in range(sensors):
            S[i, i] += noise[time, i]
        lower = np.linalg.cholesky(S)
        scale = _inverse(lower)
        for i in range(sensors):
            log_scale += np.log(lower[i, i])
        new = data[time] - seen @ x
        gain = PC @ (scale.T @ scale)
        put_vector(scale @ new, white[time])
        put_matrix(scale, scales[time])
        put_matrix(gain, gains[time])
        x = A @ (x + gain @ new) + drift[time]
        P = A @ (P - gain @ PC.T) @ A.T
        P = 0.5 * (P + P.T)
        for k in range(modes):
            push = pushes[time, k]
            P[k, k] += push * step**2 / 3
            P[k, modes + k] += push * step / 2
            P[modes + k, k] += push * step / 2
            P[modes + k, modes + k] += push
    return white, gains, scales, predicted, covariance, log_scale


@compiled
def _inverse(lower: FloatArray) -> FloatArray:
    """Return the inverse of a ``lower`` triangle (row, column)."""
    size = len(lower)
    found = np.zeros((size, size))
    for j in range(size):
        found[j, j] = 1 / lower[j, j]
        for i in range(j + 1, size):
            value = 0.0
            for k in range(j, i):
                value -= lower[i, k] * found[k, j]
            found[i, j] = value / lower[i, i]
    return found


@compiled
def _smooth(
    T: FloatArray,
    C: FloatArray,
    white: FloatArray,
    gains: FloatArray,
    scales: FloatArray,
    predicted: FloatArray,
    covariance: FloatArray,
) -> FloatArray:
    """Return the states (time, state) given all samples: Bryson and Frazier's recursion."""
    samples, size = predicted.shape
    states, r, varying = np.zeros((samples, size)), np.zeros(size), len(T) > 1
    for time in range(samples - 1, -1, -1):
        A, seen = T[time if varying else 0], C[time if varying else 0]
        back = A.T @ r
        r = back + seen.T @ (scales[time].T @ white[time] - gains[time].T @ back)
        put_vector(predicted[time] + covariance[time] @ r, states[time])
    return states


@compiled
def _respond(
    T: FloatArray, C: FloatArray, gains: FloatArray, scales: FloatArray, added: FloatArray, shown: FloatArray
) -> FloatArray:
    """Return `unexpected`: state and channels run beside the filter, which knows of neither."""
    variants, samples, sensors = shown.shape
    size, varying = C.shape[2], len(T) > 1
    found = np.zeros((variants, samples, sensors))
    ahead, new, x = np.zeros(size), np.zeros(sensors), np.zeros(size)
    for variant in range(variants):
        ahead[:] = 0.0
        for time in range(samples):
            A, seen = T[time if varying else 0], C[time if varying else 0]
            for i in range(sensors):
                value = shown[variant, time, i]
                for j in range(size):
                    value += seen[i, j] * ahead[j]
                new[i] = value
            for i in range(sensors):
                value = 0.0
                for j in range(i + 1):
                    value += scales[time, i, j] * new[j]
                found[variant, time, i] = value
            for i in range(size):
                value = ahead[i]
                for j in range(sensors):
                    value -= gains[time, i, j] * new[j]
                x[i] = value
            for i in range(size):
                value = added[variant, time, i]
                for j in range(size):
                    value += A[i, j] * x[j]
                ahead[i] = value
    return found
