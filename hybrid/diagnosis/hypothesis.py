"""A hypothesis: the plant, its uncertain factors and a few candidates; what system each parameter vector gives."""

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from fe_models.dofs import FloatArray
from fe_models.effects import SlackCable
from fe_models.recordings import Sensor
from fe_models.time_integration import TimeIntegration
from hybrid.diagnosis.candidates import Candidate
from hybrid.diagnosis.plant import Plant
from hybrid.diagnosis.system import Force, System


@dataclass(frozen=True)
class Hypothesis:
    """Parameter vectors theta (..., parameter): log factors of springs, masses, damping; then the candidates'."""

    plant: Plant
    candidates: tuple[Candidate, ...] = ()

    def adding(self, candidate: Candidate) -> "Hypothesis":
        """Return the hypothesis with one more candidate."""
        return replace(self, candidates=(*self.candidates, candidate))

    @property
    def nuisances(self) -> int:
        """Number of uncertain factors, the first entries of theta."""
        return len(self.plant.spread)

    @cached_property
    def slices(self) -> tuple[slice, ...]:
        """Where each candidate's parameters stand in theta."""
        ends = np.cumsum([self.nuisances, *(len(c.names) for c in self.candidates)])
        return tuple(slice(int(a), int(b)) for a, b in pairwise(ends))

    @property
    def centre(self) -> FloatArray:
        """The prior mean (parameter,)."""
        own = [value for c in self.candidates for value in c.neutral]
        return np.array([0.0] * self.nuisances + own)

    @property
    def width(self) -> FloatArray:
        """The prior standard deviation (parameter,)."""
        return np.array([*self.plant.spread, *(value for c in self.candidates for value in c.width)])

    @property
    def lower(self) -> FloatArray:
        """The least values (parameter,)."""
        return np.array([-np.inf] * self.nuisances + [value for c in self.candidates for value in c.lower])

    @property
    def is_linear(self) -> bool:
        """Whether the channels are linear in the initial state."""
        return not self.plant.laws and not any(c.is_law for c in self.candidates)

    @property
    def states(self) -> int:
        """Number of entries of an initial state: displacements, velocities, two for each harmonic force."""
        return 2 * self.plant.size + 2 * sum(c.oscillator for c in self.candidates)

    def system(self, theta: FloatArray, sensors: tuple[Sensor, ...], rate: float, faulty: tuple[int, ...]) -> System:
        """Return the systems of ``theta`` (variant, parameter).

        ``faulty``: for each of the ``sensors`` its position among the measured ones, -1 where it is none of them.
        """
        plant, n, variants = self.plant, self.plant.size, len(theta)
        factor = np.exp(theta[:, : self.nuisances])
        springs = factor[:, : len(plant.springs)]
        masses = factor[:, len(plant.springs) : len(plant.springs) + n]
        ratio_factor = factor[:, len(plant.springs) + n :]
        root = np.sqrt(masses)
        M = root[:, :, None] * plant.mass * root[:, None, :]
        K = plant.stiffness + np.einsum("pe,eij->pij", springs - 1, plant.springs)
        C_extra = np.zeros_like(M)
        gain, delay, slope = np.ones((variants, len(sensors))), *np.zeros((2, variants, len(sensors)))
        replaced: list[tuple[int, FloatArray]] = []
        laws: list[tuple[FloatArray, Force]] = [(plant.pull(law), _motion_only(law)) for law in plant.laws]
        oscillators: list[tuple[FloatArray, FloatArray]] = []
        integration = plant.integration
        for candidate, part in zip(self.candidates, self.slices, strict=True):
            values = theta[:, part]
            if candidate.changes is not None:
                dM, dC, dK = (values[:, 0, None, None] - candidate.neutral[0]) * candidate.changes[:, None]
                M, C_extra, K = M + dM, C_extra + dC, K + dK
            elif candidate.mode is not None:
                replaced.append((candidate.mode, values[:, 0]))
            elif candidate.oscillator and candidate.pull is not None:
                oscillators.append((candidate.pull, values[:, 0]))
            elif candidate.pull is not None:
                laws.append((candidate.pull, force_of(candidate, plant, values, springs)))
            elif candidate.sensor is not None:
                target = {"sensor_gain": gain, "sensor_delay": delay, "sensor_drift": slope}[candidate.kind]
                target[:, [i for i, s in enumerate(faulty) if s == candidate.sensor]] = values
            else:
                integration = None
        C = self._damping(M, K, ratio_factor, replaced) + C_extra
        inverse = np.linalg.inv(M)
        lower = -inverse @ np.concatenate([K, C], axis=2)  # (variant, dof, state)
        A = np.zeros((variants, self.states, self.states))
        A[:, :n, n : 2 * n] = np.eye(n)
        A[:, n : 2 * n, : 2 * n] = lower
        rows = np.zeros((variants, n, self.states))  # of the accelerations
        rows[:, :, : 2 * n] = lower
        for number, (pull, frequency) in enumerate(oscillators):
            first = 2 * n + 2 * number
            omega = 2 * np.pi * frequency
            A[:, n : 2 * n, first] = rows[:, :, first] = inverse @ pull
            A[:, first, first + 1], A[:, first + 1, first] = omega, -omega
        if integration is not None:
            A = _stepped(A, integration)
        rate_of_law = [inverse @ pull for pull, _ in laws]
        feed = np.stack(rate_of_law, axis=-1) if laws else np.zeros((variants, n, 0))  # (variant, dof, law)
        B = np.zeros((variants, self.states, len(laws)))
        B[:, n : 2 * n] = feed
        G = np.zeros((2 * len(laws), self.states))
        for number, (pull, _) in enumerate(laws):
            G[number, :n] = G[len(laws) + number, n : 2 * n] = pull
        seen, direct = np.zeros((variants, len(sensors), self.states)), np.zeros((variants, len(sensors), len(laws)))
        free = {int(row): i for i, row in enumerate(plant.dofs.free_rows)}
        for position, sensor in enumerate(sensors):
            row = free.get(plant.dofs.row(sensor.node, sensor.direction))
            if row is None:
                continue
            if sensor.quantity == "acceleration":
                seen[:, position], direct[:, position] = rows[:, row], feed[:, row]
            else:
                seen[:, position, row + n * (sensor.quantity == "velocity")] = 1.0
        forces = tuple(force for _, force in laws)
        return System(A, B, seen, direct, G, forces, gain, delay, slope, 1 / rate)

    def _damping(
        self, M: FloatArray, K: FloatArray, factor: FloatArray, replaced: list[tuple[int, FloatArray]]
    ) -> FloatArray:
        """Return C (variant, dof, dof): the nominal one, with the damping ratio of each present mode multiplied."""
        square = np.linalg.cholesky(M)
        inverse = np.linalg.inv(square)
        omega2, shapes = np.linalg.eigh(inverse @ K @ inverse.transpose(0, 2, 1))
        omega = np.sqrt(np.maximum(omega2, 1e-12 * omega2[:, -1:]))
        phi = inverse.transpose(0, 2, 1) @ shapes  # (variant, dof, mode)
        own = np.einsum("pdi,de,pei->pi", phi, self.plant.damping, phi)  # 2 xi omega
        assumed = 2 * self.plant.ratios * omega
        added = (own + assumed) * factor - own
        for mode, ratio in replaced:
            added[:, mode] = 2 * ratio * omega[:, mode] - own[:, mode]
        weighted = M @ phi
        return np.asarray(self.plant.damping + (weighted * added[:, None]) @ weighted.transpose(0, 2, 1))


def force_of(candidate: Candidate, plant: Plant, values: FloatArray, springs: FloatArray) -> Force:
    """Return the force of a law of ``values`` (variant, parameter); ``springs`` (variant, element): factors."""
    cause: Any = candidate.build(*(values[:, i, None] for i in range(values.shape[1])))
    if isinstance(cause, SlackCable):
        law: Any = SlackCable(cause.element, 1.0).law(plant.structure)
        own = law.stiffness * springs[:, cause.element - 1, None]
        law = replace(law, stiffness=own, pretension=cause.pretension)
    else:
        law = cause
    return _motion_only(law)


def _motion_only(law: Any) -> Force:
    return lambda u, v: law.force(u, v)


def _stepped(A: FloatArray, integration: TimeIntegration) -> FloatArray:
    """Return A (variant, state, state) of the system that the user's own time steps show instead."""
    roots, vectors = np.linalg.eig(A)
    shown = integration.shown_root(roots)
    return np.asarray(np.real((vectors * shown[:, None]) @ np.linalg.inv(vectors)))
