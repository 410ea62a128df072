"""Recordings forecast from their first fifth by systems, one for each state that a structure may be in."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from fe_models.arrays import TINY, FloatArray
from fe_models.recordings import derivative_orders
from hybrid.diagnosis.discrepancy.config import DISCREPANCY
from hybrid.diagnosis.discrepancy.following import FollowedMotion, filtered_by, followed, likeliest_discrepancy
from hybrid.diagnosis.discrepancy.kalman import FilteredMotion
from hybrid.diagnosis.discrepancy.law_fit import LawFit, force_along
from hybrid.diagnosis.discrepancy.law_forces import RememberedForce
from hybrid.diagnosis.discrepancy.linearisation import linearised
from hybrid.diagnosis.discrepancy.modal_space import ModalSpace, amplitude_of
from hybrid.diagnosis.discrepancy.remembered_motion import moved_on
from hybrid.diagnosis.discrepancy.size import START, Discrepancy
from hybrid.diagnosis.fitting.config import INITIAL_STATES
from hybrid.diagnosis.fitting.forecast_score import (
    ForecastScore,
    scored,
    shown_of,
    spread_of,
    start_of,
    summed,
)
from hybrid.diagnosis.fitting.initial_states import states_of
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.recorded.batches import Batch, columns_of
from hybrid.diagnosis.recorded.noise_model import SensorRoles
from hybrid.diagnosis.response.forces import force_of
from hybrid.diagnosis.response.marching import respond
from hybrid.diagnosis.response.system import Force, System, observability


@dataclass(frozen=True, eq=False)
class Forecaster:
    """The ``spaces`` of modes that a structure may have, as ``systems`` under its force law, if any, with the
    ``spreads`` (state, state) of their initial states; the ``discrepancy`` of its motions; ``roles``: what recordings
    show. ``remembered``: the force of a law with a memory.
    """

    spaces: tuple[ModalSpace, ...]
    systems: tuple[System, ...]
    spreads: tuple[FloatArray, ...]
    discrepancy: Discrepancy
    roles: SensorRoles
    remembered: RememberedForce | None = None

    @classmethod
    def of(
        cls,
        spaces: Sequence[ModalSpace],
        nominal: NominalModel,
        law: LawFit | None,
        train: Sequence[Batch],
        roles: SensorRoles,
    ) -> "Forecaster":
        """Return the forecaster that expects initial states as large as those of the recordings for training, and to
        be as wrong as it is in these.
        """
        systems = tuple(system_of_modes(space, nominal, roles, law) for space in spaces)
        spreads = tuple(_spread_of(system, train, roles) for system in systems)
        loose = cls(tuple(spaces), systems, spreads, START, roles)
        acting = None if law is None else force_along(nominal, law.candidate, law.theta)
        if law is not None and isinstance(acting, RememberedForce):
            return replace(loose, remembered=acting, discrepancy=law.track.discrepancy)
        if law is not None:  # which goes from initial states alone
            return loose
        known = [loose.beginning_of(batch, number) for batch in train for number in range(len(batch.names))]
        motions = [(item.space, item.motion) for item in known]
        return replace(loose, discrepancy=likeliest_discrepancy(motions, START, DISCREPANCY.factors))

    def of_state(self, number: int) -> "Forecaster":
        """Return the forecaster of recordings that are known to be of one state, by its number."""
        only = slice(number, number + 1)
        return replace(self, spaces=self.spaces[only], systems=self.systems[only], spreads=self.spreads[only])

    def beginning_of(self, batch: Batch, number: int) -> "Beginning":
        """Return how a recording of a batch begins: its first fifth, by the space with which this is most probable."""
        (own,) = columns_of((batch,), self.roles.measured)
        data = own.data[number, : shown_of(own.samples)]
        noise = np.broadcast_to(own.sigma(self.roles.noise_model) ** 2, (len(own.names), 1, data.shape[1]))[number]
        motions = [followed(space, np.ascontiguousarray(data), noise[0]) for space in self.spaces]
        index = self._state_of(motions)
        space, motion = self.spaces[index], motions[index]
        return Beginning(index, space, motion, self._known(space, motion).states)

    def _state_of(self, motions: Sequence[FollowedMotion]) -> int:
        """Return the number of the space that a motion, as each of them follows it, is of most probably: each with the
        discrepancy that suits it best, as a large one follows the motion of any structure.
        """
        if len(motions) == 1:
            return 0
        found = []
        for space, motion in zip(self.spaces, motions, strict=True):
            own = likeliest_discrepancy([(space, motion)], self.discrepancy, DISCREPANCY.factors)
            found.append(filtered_by(space, motion, own).log_density + own.log_prior)
        return int(np.argmax(found))

    def _known(self, space: ModalSpace, motion: FollowedMotion) -> FilteredMotion:
        """Return what a filter makes of a motion, under the law with a memory where there is one: about a motion whose
        modes go their own way first, then about what it found itself.
        """
        if self.remembered is None:
            return filtered_by(space, motion, self.discrepancy)
        best = filtered_by(space, motion, Discrepancy(DISCREPANCY.loose_size, DISCREPANCY.loose_share))
        for _ in range(DISCREPANCY.passes):
            about = replace(motion, linearisation=linearised(space, best.states, [self.remembered]))
            best = filtered_by(space, about, self.discrepancy)
        return best

    def forecast(self, batch: Batch) -> FloatArray:
        """Return the channels (recording, time, sensor) as the first fifth of the measured ones has them go on.

        A law's from initial states alone; free motion, and one under a law with a memory, as a filter knows it at the
        end of that fifth.
        """
        if self.remembered is not None:
            return np.array([self._remembering(batch, number, self.remembered) for number in range(len(batch.names))])
        if self.systems[0].forces:
            return self._under_law(batch)
        return np.array([self._free(batch, number) for number in range(len(batch.names))])

    def _free(self, batch: Batch, number: int) -> FloatArray:
        """Return the channels (time, sensor) of a recording whose motion goes on freely."""
        begun = self.beginning_of(batch, number)
        output, n = self.systems[begun.index].C[0], begun.space.count
        last = len(begun.states) - 1
        later = np.arange(1, batch.samples - last) * begun.space.step
        of_q, of_rate = amplitude_of(begun.space.roots)
        z = (of_q * begun.states[-1, :n] + of_rate * begun.states[-1, n:]) * np.exp(np.outer(later, begun.space.roots))
        going_on = np.concatenate([z.real, np.real(begun.space.roots * z)], axis=1)
        return np.concatenate([begun.states, going_on]) @ output.T

    def _remembering(self, batch: Batch, number: int, law: RememberedForce) -> FloatArray:
        """Return the channels (time, sensor) of a recording whose motion goes on under a law with a memory."""
        begun = self.beginning_of(batch, number)
        system = self.systems[begun.index]
        states, force = moved_on(law, begun.space, begun.states, batch.samples)
        return np.asarray(states @ system.C[0].T + np.outer(force, system.D[0, :, 0]))

    def _under_law(self, batch: Batch) -> FloatArray:
        """Return the channels (recording, time, sensor) under a law, each by the system that fits its first fifth best;
        what grows beyond numbers stays large.
        """
        best, least = np.zeros_like(batch.recorded), np.full(len(batch.data), np.inf)
        far = INITIAL_STATES.max_motion_ratio * float(np.abs(batch.recorded).max())
        (own,) = columns_of((batch.first(shown_of(batch.samples)),), self.roles.measured)
        for system, spread in zip(self.systems, self.spreads, strict=True):
            states, cost = states_of(_seen_by(system, self.roles), spread, own, self.roles.noise_model)
            y = respond(system, states[None], batch.samples, batch.loads)[0]
            better = (cost < least)[:, None, None]
            best, least = (
                np.where(better, np.nan_to_num(y, nan=far, posinf=far, neginf=-far), best),
                np.minimum(least, cost),
            )
        return best

    def score(self, batches: Sequence[Batch]) -> ForecastScore:
        """Return the scores over the last 80 % of the recordings, of all sensors."""
        linear, spread = self.systems[0].unforced, self.spreads[0]
        parts = []
        for batch in batches:
            start = partial(start_of, linear, spread, batch.samples, self.roles)
            parts.append(scored(self.forecast(batch), batch, self.roles, start))
        return summed(parts)


@dataclass(frozen=True, eq=False)
class Beginning:
    """How a recording begins: by the space with an ``index`` among several, the ``motion``, and its ``states`` (time,
    2 mode) as a filter knows them.
    """

    index: int
    space: ModalSpace
    motion: FollowedMotion
    states: FloatArray


def system_of_modes(space: ModalSpace, nominal: NominalModel, roles: SensorRoles, law: LawFit | None) -> System:
    """Return the system of modes, under a force ``law``, as all sensors show it.

    Those that are measured by the shapes of the ``space``, the others by the structure's.
    """
    n, sensors = space.count, roles.sensors
    rows, orders = nominal.rows(sensors), derivative_orders(sensors)
    shown = (rows @ space.shapes) * space.roots ** orders[:, None]
    shown[list(roles.measured)] = space.shown
    of_q, of_rate = amplitude_of(space.roots)
    A = np.zeros((1, 2 * n, 2 * n))
    A[0, :n, n:] = np.eye(n)
    A[0, n:, :n], A[0, n:, n:] = -np.diag(space.omega**2), -np.diag(2 * space.ratio * space.omega)
    C = np.concatenate([np.real(shown * of_q), np.real(shown * of_rate)], axis=1)[None]
    laws = 0 if law is None else 1
    B, G, D = np.zeros((1, 2 * n, laws)), np.zeros((1, 2 * laws, 2 * n)), np.zeros((1, len(sensors), laws))
    forces: tuple[Force, ...] = ()
    if law is not None:
        along = law.candidate.pull @ space.shapes
        B[0, n:, 0], G[0, 0, :n], G[0, 1, n:] = along, along, along
        D[0, :, 0] = (rows @ space.shapes) @ along * (orders == 2)
        forces = (force_of(law.candidate, nominal, law.theta[None], np.ones((1, len(nominal.parts)))),)
    still, one = np.zeros((1, len(sensors))), np.ones((1, len(sensors)))
    return System(A, B, C, D, G, forces, one, still, still, space.step, lowpass=space.lowpass)


def _seen_by(system: System, roles: SensorRoles) -> System:
    """Return a system as the measured sensors alone show it."""
    own = list(roles.measured)
    parts = {name: getattr(system, name)[:, own] for name in ("C", "D", "gain", "delay", "slope")}
    return replace(system, **parts)


def _spread_of(system: System, train: Sequence[Batch], roles: SensorRoles) -> FloatArray:
    """Return the covariance (state, state) of initial states, as the first fifths of recordings have them."""
    linear = _seen_by(system.unforced, roles)
    found = []
    for batch in columns_of(tuple(train), roles.measured):
        own = batch.first(shown_of(batch.samples))
        shown = np.abs(observability(linear, own.samples)[0]).max(axis=(0, 1))  # (state,)
        loose = DISCREPANCY.initial_amplitude * float(np.abs(own.data).max()) / np.maximum(shown, TINY * shown.max())
        found.append(states_of(linear, np.diag(loose**2), own, roles.noise_model)[0])
    return spread_of(linear.A[0], np.concatenate(found))
