"""Channels of a linear system, and how they change with its matrices, as sums of exp(root t) and t exp(root t).

In modal coordinates, with A = V diag(root) V^-1 and E = V^-1 dA V, a change dA adds to exp(A t)

    V (E * phi(t)) V^-1,   phi_mn = (exp(root_m t) - exp(root_n t)) / (root_m - root_n),   phi_mm = t exp(root_m t)

entry by entry (Daleckii and Krein; Higham, Functions of Matrices, 2008, sec. 3.2).
"""

from dataclasses import dataclass

import numpy as np

from fe_models.arrays import ComplexArray, FloatArray
from hybrid.diagnosis.response.config import STATE_SPACE
from hybrid.diagnosis.response.system import ModalForm, System, is_defective


@dataclass(frozen=True)
class Exponentials:
    """The first variant of a ``system`` by its ``roots`` (m,), 1/s, all of them, ``vectors`` (state, m), their
    ``inverse`` (m, state), and what each sensor's delay and low-pass leave of exp(root t), ``passed`` (sensor, m).
    """

    system: System
    roots: ComplexArray
    vectors: ComplexArray
    inverse: ComplexArray
    passed: ComplexArray

    def table(self, samples: int) -> FloatArray:
        """Return the functions of time that all coefficients are of, (time, function): the exponentials' real and
        negative imaginary parts, the same times t, 1 and t.
        """
        time = self.system.step * np.arange(samples)[:, None]
        half = self.roots[self._half][None]
        oscillations = ModalForm(half, half[:, None], half[..., None]).oscillations(samples, self.system.step)[0]
        return np.hstack([oscillations, time * oscillations, np.ones_like(time), time])

    def of_states(self) -> FloatArray:
        """Return the coefficients (function, sensor, state) of what the sensors show of each initial state."""
        half = self._half
        once = (self._shown * self.passed)[:, half].T[..., None] * self.inverse[half, None]
        return self._real(once, np.zeros_like(once))

    def changes(self, states: FloatArray, moved: FloatArray) -> FloatArray:
        """Return the coefficients (function, parameter, recording, sensor) of how the channels change.

        From initial ``states`` (recording, state), with parameters of which the further variants have ``moved``
        (parameter,) one each. The drift is that within a segment.
        """
        system, roots, half = self.system, self.roots, self._half
        dA, dC, d_delay, d_slope = (
            (part[1:] - part[0]) / moved.reshape(-1, *[1] * (part.ndim - 1))
            for part in (system.A, self._gained, system.delay, system.slope)
        )
        apart = roots[:, None] - roots
        near = np.abs(apart) <= STATE_SPACE.min_root_distance * np.abs(roots).max()
        E = self.inverse @ dA @ self.vectors  # (parameter, m, m)
        D, S = np.where(near, 0.0, E / np.where(near, 1.0, apart)), np.where(near, E, 0.0)
        a = self.inverse @ states.T  # (m, recording)
        turned, timed = (D @ a)[:, half], (S @ a)[:, half]  # (parameter, m, recording)
        shown = self._shown
        more = dC @ self.vectors - shown @ D - shown * roots * d_delay[..., None]  # (parameter, sensor, m)
        direct, bent = shown * self.passed, shown * self._passed_slope
        once = _products(a[None, half], (more * self.passed)[..., half])
        once += _products(turned, direct[None, :, half]) + _products(timed, bent[None, :, half])
        found = self._real(once, _products(timed, direct[None, :, half]))
        found[-1] += d_slope[:, None]
        return found

    @property
    def _half(self) -> list[int]:
        """One root of each conjugate pair, and those that are real."""
        return np.flatnonzero(self.roots.imag >= 0).tolist()

    @property
    def _gained(self) -> FloatArray:
        """C with the sensors' gains, (variant, sensor, state)."""
        return self.system.C * self.system.gain[..., None]

    @property
    def _shown(self) -> ComplexArray:
        """What the sensors show of each exponential (sensor, m), before delay and low-pass."""
        return np.asarray(self._gained[0] @ self.vectors)

    @property
    def _passed_slope(self) -> ComplexArray:
        """How ``passed`` changes with the root, (sensor, m)."""
        late, lowpass = -self.system.delay[0][:, None], self.system.lowpass
        return np.asarray(self.passed * (late if lowpass is None else late + lowpass.log_slope(self.roots)))

    def _real(self, once: ComplexArray, timed: ComplexArray) -> FloatArray:
        """Return real coefficients (function, ...) of complex ones (half of m, ...): of exp(root t), t exp(root t)."""
        weight = np.where(self.roots[self._half].imag > 0, 2.0, 1.0).reshape(-1, *[1] * (once.ndim - 1))
        once, timed = weight * once, weight * timed
        return np.concatenate([once.real, once.imag, timed.real, timed.imag, np.zeros((2, *once.shape[1:]))])


def exponentials(system: System) -> Exponentials | None:
    """Return the exponentials of a system without loads and force laws; None where eigenvectors fall together."""
    roots, vectors = np.linalg.eig(system.A[0])
    if is_defective(vectors):
        return None
    passed = np.ones((len(system.delay[0]), len(roots)), dtype=complex)
    if system.delay.any():
        passed = passed * np.exp(-system.delay[0][:, None] * roots)
    if system.lowpass is not None:
        passed = passed * system.lowpass.gain(roots)
    return Exponentials(system, roots.astype(complex), vectors.astype(complex), np.linalg.inv(vectors), passed)


def _products(amplitudes: ComplexArray, shown: ComplexArray) -> ComplexArray:
    """Return the products (m, parameter, recording, sensor) of (parameter, m, recording) and (parameter, sensor, m)."""
    return np.asarray(amplitudes.swapaxes(0, 1)[..., None] * shown.transpose(2, 0, 1)[:, :, None])
