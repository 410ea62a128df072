"""Natural modes as a state space at the samples of a recording: how they move under forces, and what sensors show.

    q'' + 2 xi w q' + w^2 q = Phi^T p f(t),        y = Re(V Z e^(s t)) + direct f(t)

Each mode's free motion q = Re(Z e^(s t)) shows at the sensors by a complex shape V, so that measured shapes serve as
well as computed ones; Z e^(s t) = (q' - conj(s) q) / (i Im s).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import expm

from fe_models.arrays import BoolArray, ComplexArray, FloatArray
from fe_models.lowpass import LowPass
from hybrid.diagnosis.discrepancy.config import DISCREPANCY
from hybrid.diagnosis.response.filtering import convolved


@dataclass(frozen=True, eq=False)
class FineMotion:
    """The motion of modes in all parts of all time steps: ``q`` and its ``rate`` q' (part, mode)."""

    q: FloatArray
    rate: FloatArray


@dataclass(frozen=True, eq=False)
class Push:
    """What a force adds: to the ``states`` in each step (time, 2 mode), to the ``channels`` at once (time, sensor)."""

    states: FloatArray
    channels: FloatArray


@dataclass(frozen=True, eq=False)
class ModalSpace:
    """Modes (mode,) with their ``omega`` (rad/s) and damping ``ratio``; mass-normalised ``shapes`` (dof, mode); complex
    ``shown`` (sensor, mode), what the sensors show of Z; ``rows`` (sensor, dof) and which sensors feel a force at once,
    as accelerometers do, ``feels`` (sensor,); ``step`` (s) between samples; the ``lowpass`` that recordings passed.
    """

    omega: FloatArray
    ratio: FloatArray
    shapes: FloatArray
    shown: ComplexArray
    rows: FloatArray
    feels: BoolArray
    step: float
    lowpass: LowPass | None = None

    @property
    def count(self) -> int:
        """Number of modes."""
        return len(self.omega)

    @cached_property
    def roots(self) -> ComplexArray:
        """The eigenvalues s (mode,), rad/s."""
        return roots_of(self.omega, self.ratio)

    @cached_property
    def output(self) -> FloatArray:
        """What the sensors show of q and q', (sensor, 2 mode)."""
        of_q, of_rate = amplitude_of(self.roots)
        return np.ascontiguousarray(np.concatenate([np.real(self.shown * of_q), np.real(self.shown * of_rate)], axis=1))

    @cached_property
    def propagators(self) -> FloatArray:
        """The transition of q and q' over each number of parts of a step, forwards and then backwards.

        (2, part + 1, mode, 2, 2)
        """
        A = np.zeros((self.count, 2, 2))
        A[:, 0, 1], A[:, 1, 0], A[:, 1, 1] = 1.0, -(self.omega**2), -2 * self.ratio * self.omega
        times = self.step * np.arange(DISCREPANCY.parts + 1) / DISCREPANCY.parts
        return np.array([[expm(sign * A * time) for time in times] for sign in (1, -1)])

    @cached_property
    def whole_transition(self) -> FloatArray:
        """The transition of q and q' from sample to sample, (2 mode, 2 mode)."""
        n, every = self.count, np.arange(self.count)
        whole = np.zeros((2, n, 2, n))
        whole[:, every, :, every] = self.propagators[0, -1]
        return np.ascontiguousarray(whole.reshape(2 * n, 2 * n))

    def fine_motion(self, states: FloatArray) -> FineMotion:
        """Return the motion in the ``parts`` of each step, of ``states`` (time, 2 mode) at samples.

        Within a step the states before and after it, each carried on as if no force acted, are weighed by nearness.
        """
        n, parts = self.count, DISCREPANCY.parts
        both = states.reshape(len(states), 2, n)
        forwards, backwards = self.propagators
        found = np.zeros((2, len(states) - 1, parts, n))
        for part in range(parts):
            near = part / parts
            ahead, back = (1 - near) * forwards[part], near * backwards[parts - part]
            for i in (0, 1):
                found[i, :, part] = sum(ahead[:, i, j] * both[:-1, j] + back[:, i, j] * both[1:, j] for j in (0, 1))
        q, rate = (
            np.concatenate([part.reshape(-1, n), last[None]]) for part, last in zip(found, both[-1], strict=True)
        )
        return FineMotion(q, rate)

    def pushed(self, force: FloatArray, pull: FloatArray) -> Push:
        """Return what a ``force`` (part,) along ``pull`` (dof,) adds."""
        participation, passed = pull @ self.shapes, self.passed(force)
        direct = (self.rows @ self.shapes) @ participation * self.feels
        states = self._within_steps(passed) @ self._integrals * np.tile(participation, 2)
        return Push(states, np.outer(passed[:: DISCREPANCY.parts], direct))

    def _within_steps(self, force: FloatArray) -> FloatArray:
        """Return a force (part,) in the parts of each step (time, part + 1); none acts after the last sample."""
        parts = DISCREPANCY.parts
        found = np.zeros(((len(force) - 1) // parts + 1, parts + 1))
        found[:-1, :parts] = force[:-1].reshape(-1, parts)
        found[:-1, parts] = force[parts::parts]
        return found

    @cached_property
    def _integrals(self) -> FloatArray:
        """What a unit force in each part of a step adds to the states at its end, by Simpson's rule (part + 1, 2 mode).

        The integral of the transition times the force.
        """
        parts = DISCREPANCY.parts
        weights = np.array([1.0, *[4.0, 2.0] * (parts // 2)])[: parts + 1] * self.step / parts / 3
        weights[-1] = self.step / parts / 3
        kicks = self.propagators[0, ::-1, :, :, 1].transpose(0, 2, 1).reshape(parts + 1, -1)
        return weights[:, None] * kicks

    def driven(self, force: FloatArray, mode: int) -> FloatArray:
        """Return what a modal ``force`` (part,) on one mode adds to its states in each step (time, 2)."""
        own = [mode, self.count + mode]
        return self._within_steps(force) @ self._integrals[:, own]

    def motion(self, added: FloatArray) -> FloatArray:
        """Return the states (time, 2 mode) from rest that what is ``added`` in each step brings about."""
        states, A = np.zeros_like(added), self.whole_transition
        for time in range(len(added) - 1):
            states[time + 1] = A @ states[time] + added[time]
        return states

    def stiffened(self, by_u: FloatArray, by_v: FloatArray, pull: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return how a force along ``pull`` (dof,) that changes with elongation and rate, by so much (part,), changes
        the transition of each step (time, 2 mode, 2 mode), and the output (time, sensor, 2 mode).
        """
        n, along = self.count, pull @ self.shapes
        kicks = self._integrals * np.tile(along, 2)
        within_u, within_v = self._within_steps(by_u), self._within_steps(by_v)
        steps = np.zeros((len(within_u), 2 * n, 2 * n))
        for part in range(DISCREPANCY.parts + 1):
            forwards = self.propagators[0, part]  # (mode, 2, 2)
            of_q = along[:, None] * forwards[:, 0]
            of_rate = along[:, None] * forwards[:, 1]
            rows = within_u[:, part, None, None] * of_q + within_v[:, part, None, None] * of_rate  # (time, mode, 2)
            row = rows.transpose(0, 2, 1).reshape(len(rows), 2 * n)
            steps += kicks[part][None, :, None] * row[:, None]
        direct = (self.rows @ self.shapes) @ along * self.feels
        # (time, 2 mode)
        at = np.concatenate([part[:: DISCREPANCY.parts, None] * along for part in (by_u, by_v)], axis=1)
        return steps, direct[None, :, None] * at[:, None]

    def remembered(
        self, kept: FloatArray, follows: FloatArray, stiffness: float, pull: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return how a force ``stiffness`` z along ``pull`` (dof,) changes the transition of each step of q, q' and z,
        (time, 2 mode, 2 mode + 1), that of z itself (time, 2 mode + 1), and what sensors show of z (sensor,).

        In each part of a step z grows with itself and with the elongation's step, ``kept`` and ``follows`` (part - 1,).
        """
        n, along, parts = self.count, pull @ self.shapes, DISCREPANCY.parts
        kicks = self._integrals * np.tile(along, 2)
        steps, within = len(kept) // parts + 1, np.zeros((2, len(kept) // parts + 1, parts))
        within[0] = 1.0
        within[:, :-1] = kept.reshape(-1, parts), follows.reshape(-1, parts)
        elongation = (along[:, None] * self.propagators[0, :, :, 0]).transpose(0, 2, 1).reshape(parts + 1, 2 * n)
        z, whole = np.zeros((steps, 2 * n + 1)), np.zeros((steps, 2 * n, 2 * n + 1))
        z[:, -1] = 1.0
        for part in range(parts + 1):
            whole += stiffness * kicks[part][None, :, None] * z[:, None]
            if part < parts:
                z = within[0, :, part, None] * z
                z[:, :-1] += within[1, :, part, None] * (elongation[part + 1] - elongation[part])
        whole[-1], z[-1] = 0.0, 0.0  # after the last sample nothing is asked
        return whole, z, (self.rows @ self.shapes) @ along * self.feels * stiffness

    def passed(self, force: FloatArray) -> FloatArray:
        """Return what a low-pass leaves of a force (part,): the channels that it drives have passed it."""
        if self.lowpass is None:
            return force
        kernel = self.lowpass.kernel(DISCREPANCY.parts / self.step)
        half = len(kernel) // 2
        longer = np.pad(force, half, mode="edge")
        return convolved(longer[:, None], kernel)[:, 0]


def roots_of(omega: FloatArray, ratio: FloatArray) -> ComplexArray:
    """Return the eigenvalues s = -xi w + i w sqrt(1 - xi^2), rad/s."""
    return np.asarray(omega * (-ratio + 1j * np.sqrt(1 - ratio**2)))


def amplitude_of(roots: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Return how q and q' make Z e^(s t), of each mode (mode,)."""
    return np.asarray(-np.conj(roots) / (1j * roots.imag)), np.asarray(1 / (1j * roots.imag))
