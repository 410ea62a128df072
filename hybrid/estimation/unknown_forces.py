"""States under unknown forces, by all samples of a recording: a Kalman filter, and Bryson and Frazier's smoother.

    x_k+1 = A_k x_k + B_k g_k + d_k,    y_k = C_k x_k + D g_k + c_k + v_k,    g_k ~ N(0, Q),  v_k ~ N(0, R)

with forces g that are constant over a step, which accelerometers feel at once; Q and R are diagonal. With e_k what the
filter did not expect, S_k its covariance, K_k the gain and L_k = [A_k, B_k] - K_k [C_k, D],

    r_k-1 = C' S^-1 e_k + L' r_k,    N_k-1 = C' S^-1 C + L' N_k L,    [x; g] given all = mean + P r,  P - P N P

where C = [C_k, D], P = diag(P_k, Q) (Durbin & Koopman, Time Series Analysis by State Space Methods, 2012, sec. 4.4).
"""

from dataclasses import dataclass

import numpy as np

from fe_models.arrays import FloatArray
from hybrid.compiled import compiled, put_matrix, put_vector


@dataclass(frozen=True, eq=False)
class StepModel:
    """The steps of a motion: ``transition`` A (step, state, state), ``feed`` B (step, state, force), ``drift`` d (step,
    state), and what the sensors show: ``output`` C (step, sensor, state), ``direct`` D (sensor, force), ``offset`` c
    (step, sensor). Where all steps are alike there is one.
    """

    transition: FloatArray
    feed: FloatArray
    drift: FloatArray
    output: FloatArray
    direct: FloatArray
    offset: FloatArray


@dataclass(frozen=True, eq=False)
class Smoothed:
    """Given all samples: ``states`` (time, state) and ``forces`` (time, force), their ``covariance`` (time, state +
    force, state + force), and the ``log_likelihood`` of the measured channels.

    ``force_power`` (force,) and ``noise_power`` (measured,): mean squares that are expected of the forces and of the
    sensors' noise, given all.
    """

    states: FloatArray
    forces: FloatArray
    covariance: FloatArray
    log_likelihood: float
    force_power: FloatArray
    noise_power: FloatArray


def smoothed(
    model: StepModel, data: FloatArray, force: FloatArray, noise: FloatArray, begin: tuple[FloatArray, FloatArray]
) -> Smoothed:
    """Return what ``data`` (time, measured) say of states and forces, for the channels of ``model``.

    ``force`` (force,) and ``noise`` (measured,): variances; ``begin``: mean (state,) and covariance (state, state) of
    the first state.
    """
    outward = model.transition, model.feed, model.drift, model.output, model.direct, model.offset
    parts = tuple(np.ascontiguousarray(part, dtype=float) for part in outward)
    ahead = _filter(*parts, np.ascontiguousarray(data), force, noise, *begin)
    states, forces, covariance, noise_power = _smooth(*parts[:2], parts[3], parts[4], force, noise, *ahead[:-1])
    spread = np.diagonal(covariance, axis1=1, axis2=2)[:, model.transition.shape[1] :]
    force_power = np.mean(forces**2 + spread, axis=0)
    return Smoothed(states, forces, covariance, float(ahead[-1]), force_power, noise_power)


@compiled
def _filter(
    A: FloatArray,
    B: FloatArray,
    d: FloatArray,
    C: FloatArray,
    D: FloatArray,
    c: FloatArray,
    data: FloatArray,
    force: FloatArray,
    noise: FloatArray,
    mean: FloatArray,
    covariance: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray, float]:
    """Return predicted means and covariances, what was not expected, S^-1 and the gains, and the log-likelihood."""
    samples, sensors = data.shape
    size, steps, shows = A.shape[1], len(A) > 1, len(C) > 1
    means, covariances = np.zeros((samples, size)), np.zeros((samples, size, size))
    errors, inverses = np.zeros((samples, sensors)), np.zeros((samples, sensors, sensors))
    gains = np.zeros((samples, size, sensors))
    x, P, total = mean.copy(), covariance.copy(), 0.0
    at_once = (D * force) @ D.T
    for i in range(sensors):
        at_once[i, i] += noise[i]
    for time in range(samples):
        step, show = time if steps else 0, time if shows else 0
        put_vector(x, means[time])
        put_matrix(P, covariances[time])
        PC = P @ C[show].T
        S = C[show] @ PC + at_once
        lower = np.linalg.cholesky(S)
        inverse = np.linalg.inv(S)
        error = data[time] - C[show] @ x - c[show]
        gain = (A[step] @ PC + (B[step] * force) @ D.T) @ inverse
        total -= 0.5 * error @ (inverse @ error) + 0.5 * sensors * np.log(2 * np.pi)
        for i in range(sensors):
            total -= np.log(lower[i, i])
        put_vector(error, errors[time])
        put_matrix(inverse, inverses[time])
        put_matrix(gain, gains[time])
        x = A[step] @ x + gain @ error + d[step]
        P = A[step] @ P @ A[step].T + (B[step] * force) @ B[step].T - gain @ S @ gain.T
        P = 0.5 * (P + P.T)
    return means, covariances, errors, inverses, gains, total


@compiled
def _smooth(
    A: FloatArray,
    B: FloatArray,
    C: FloatArray,
    D: FloatArray,
    force: FloatArray,
    noise: FloatArray,
    means: FloatArray,
    covariances: FloatArray,
    errors: FloatArray,
    inverses: FloatArray,
    gains: FloatArray,
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Return smoothed states, forces, their covariances, and the mean square of the sensors' noise."""
    samples, sensors = errors.shape
    size, forces, steps, shows = A.shape[1], B.shape[2], len(A) > 1, len(C) > 1
    both = size + forces
    states, pushed = np.zeros((samples, size)), np.zeros((samples, forces))
    spread, power = np.zeros((samples, both, both)), np.zeros(sensors)
    r, N = np.zeros(size), np.zeros((size, size))
    seen, ahead, P = np.zeros((sensors, both)), np.zeros((size, both)), np.zeros((both, both))
    put_matrix(D, seen[:, size:])
    for i in range(forces):
        P[size + i, size + i] = force[i]
    for time in range(samples - 1, -1, -1):
        step, show = time if steps else 0, time if shows else 0
        put_matrix(C[show], seen[:, :size])
        put_matrix(A[step], ahead[:, :size])
        put_matrix(B[step], ahead[:, size:])
        L = ahead - gains[time] @ seen
        weighed = inverses[time] @ seen
        whole_r = weighed.T @ errors[time] + L.T @ r
        whole_N = seen.T @ weighed + L.T @ (N @ L)
        # the noise given all: R (S^-1 e - K' r), and its covariance R - R (S^-1 + K' N K) R
        unlike = inverses[time] @ errors[time] - gains[time].T @ r
        certain = inverses[time] + gains[time].T @ (N @ gains[time])
        for i in range(sensors):
            power[i] += (noise[i] * unlike[i]) ** 2 + noise[i] - noise[i] ** 2 * certain[i, i]
        put_matrix(covariances[time], P[:size, :size])
        put_vector(means[time] + covariances[time] @ whole_r[:size], states[time])
        put_vector(force * whole_r[size:], pushed[time])
        put_matrix(P - P @ whole_N @ P, spread[time])
        r, N = whole_r[:size], whole_N[:size, :size]
        N = 0.5 * (N + N.T)
    return states, pushed, spread, power / samples
