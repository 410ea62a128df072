"""The forces that a linear model lacks, and its motion with them: a Kalman smoother with random forces everywhere.

State s = [x, v, f] in the coordinates of the nominal model, with M x'' + C x' + K x = f and f' white noise (an
augmented Kalman filter; E. Lourens et al., Mechanical Systems and Signal Processing 27, 2012). How fast the forces may
change is found by the likelihood.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import expm

from benchmarks.peers.certain import Certain
from fe_models.arrays import FloatArray

QUICKNESS = (1e-4, 1e-3, 1e-2, 1e-1, 1.0)  # of the elastic forces' mean square a second: the forces' random walk
LOOSE = 10.0  # standard deviation of the first state over the rms that the recordings suggest: it is hardly known


@dataclass(frozen=True)
class Process:
    """s[k + 1] = ``step`` s[k] + noise of covariance ``noise``; y = ``seen`` s + noise; ``start``: first covariance."""

    step: FloatArray
    noise: FloatArray
    seen: FloatArray
    start: FloatArray


@dataclass(frozen=True)
class LatentForces:
    """``displacement``, ``velocity`` and ``force`` (recording, time, coordinate), and what they were found by."""

    displacement: FloatArray
    velocity: FloatArray
    force: FloatArray
    process: Process
    sigma: FloatArray

    def seen(self, force: FloatArray) -> FloatArray:
        """Return what the same sensors and smoother would have made of other forces (recording, time, coordinate).

        Few sensors do not determine well where a force acts; what they blur they blur for all forces alike.
        """
        A, rest = self.process.step, 2 * force.shape[2]
        s = np.zeros((len(force), len(A)))
        channels = np.empty((*force.shape[:2], len(self.sigma)))
        for k in range(force.shape[1]):
            s[:, rest:] = force[:, k]
            channels[:, k] = s @ self.process.seen.T
            s[:, rest:] = (force[:, k] + force[:, min(k + 1, force.shape[1] - 1)]) / 2  # over the step
            s = s @ A.T
        return _smoothed(self.process, channels, self.sigma)[..., rest:]


def latent_forces(certain: Certain) -> LatentForces:
    """Return the forces that the nominal model lacks in the recordings; of several lengths, in those with most data."""
    noise_model = certain.noise_model
    batch = max(certain.lengths.whole, key=lambda item: item.data.size)
    n = certain.hypothesis.size
    size = float(np.sqrt(np.mean(np.concatenate(certain.short.states)[:, :n] ** 2)))  # rms
    trials = [_process(certain, size, share) for share in QUICKNESS]
    best = max(trials, key=lambda process: _filtered(process, batch.data, noise_model.sigma)[0])
    states = _smoothed(best, batch.data, noise_model.sigma)
    return LatentForces(states[..., :n], states[..., n : 2 * n], states[..., 2 * n :], best, noise_model.sigma)


def _process(certain: Certain, size: float, share: float) -> Process:
    n, dt, sensors = certain.hypothesis.size, 1 / certain.noise_model.rate, certain.noise_model.sensors
    M, C, K, shapes = certain.matrices
    accelerations = np.linalg.inv(M) @ np.hstack([-K, -C, np.eye(n)])  # (coordinate, state)
    A = np.zeros((3 * n, 3 * n))
    A[:n, n : 2 * n], A[n : 2 * n] = np.eye(n), accelerations
    elastic = float(np.diag(K).mean()) * size
    Q = np.diag(np.repeat([0.0, share * elastic**2], [2 * n, n]))  # each second
    block = expm(np.block([[-A, Q], [np.zeros_like(A), A.T]]) * dt)  # Van Loan
    step = block[3 * n :, 3 * n :].T
    rate = float(np.sqrt(np.diag(K).mean() / np.diag(M).mean()))  # rad/s
    spread = np.repeat([size, size * rate, np.sqrt(share) * elastic], n)
    rows = {"displacement": np.eye(3 * n)[:n], "velocity": np.eye(3 * n)[n : 2 * n], "acceleration": accelerations}
    picked = certain.hypothesis.nominal.rows(sensors) @ shapes  # (sensor, coordinate)
    seen = np.array([row @ rows[sensor.quantity] for row, sensor in zip(picked, sensors, strict=True)])
    return Process(step, step @ block[: 3 * n, 3 * n :], seen, np.diag((LOOSE * spread) ** 2))


def _filtered(process: Process, data: FloatArray, sigma: FloatArray) -> tuple[float, list[FloatArray], FloatArray]:
    """Return the log likelihood, the covariances after each sample, and the states (time, recording, state)."""
    P, s = process.start, np.zeros((len(data), len(process.step)))
    likelihood, covariances, states = 0.0, [], np.empty((data.shape[1], *s.shape))
    C = process.seen
    for k in range(data.shape[1]):
        if k:
            s, P = s @ process.step.T, process.step @ P @ process.step.T + process.noise
        S = C @ P @ C.T + np.diag(sigma**2)
        off = data[:, k] - s @ C.T  # (recording, sensor)
        weighed = np.linalg.solve(S, off.T).T
        likelihood -= 0.5 * (float(np.sum(off * weighed)) + len(data) * float(np.linalg.slogdet(S)[1]))
        s = s + weighed @ (C @ P)
        P = P - P @ C.T @ np.linalg.solve(S, C @ P)
        P = (P + P.T) / 2
        covariances.append(P)
        states[k] = s
    return likelihood, covariances, states


def _smoothed(process: Process, data: FloatArray, sigma: FloatArray) -> FloatArray:
    """Return the states (recording, time, state) given all data (Rauch, Tung and Striebel)."""
    _, covariances, states = _filtered(process, data, sigma)
    A = process.step
    for k in range(len(states) - 2, -1, -1):
        ahead = A @ covariances[k] @ A.T + process.noise
        G = np.linalg.solve(ahead, A @ covariances[k]).T
        states[k] += (states[k + 1] - states[k] @ A.T) @ G.T
    return states.transpose(1, 0, 2)
