"""The channels of a linear model at samples, and their slopes by finite differences, under known loads as well."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fe_models.arrays import FloatArray
from hybrid.diagnosis.recorded.batches import Batch
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.response.loaded import given
from hybrid.diagnosis.response.marching import respond
from hybrid.diagnosis.response.system import System, drift, observability


@dataclass(frozen=True)
class Sampled:
    """The `Channels` of a ``batch`` and a ``system``, whose further variants have ``moved`` (parameter,) one each.

    A value is one of a sensor at a sample.
    """

    system: System
    batch: Batch
    noise_model: NoiseModel
    moved: FloatArray
    frame = None

    @cached_property
    def data(self) -> FloatArray:
        """What initial states are to show (recording, value): the recordings less what is there without them."""
        rest = self.batch.data - self._late[0]
        return (rest.reshape(len(rest), -1) - drift(self.system, self.batch.samples)[0].ravel()) * self._weight

    @cached_property
    def by_state(self) -> FloatArray:
        """What they show a unit (value, state), or (recording, value, state) where noise is not alike."""
        shown = observability(self.system.only(0), self.batch.samples)
        shown = shown.reshape(-1, shown.shape[-1])
        return shown * (self._weight[0, :, None] if len(self._weight) == 1 else self._weight[..., None])

    def left(self, states: FloatArray) -> FloatArray:
        """Return what ``states`` (recording, state) leave of the recordings, (recording, time, sensor)."""
        shown = (self.by_state @ states[..., None])[..., 0] if self.by_state.ndim == 3 else states @ self.by_state.T
        return np.asarray(self.data - shown).reshape(self.batch.data.shape)

    def changes(self, states: FloatArray) -> FloatArray:
        """Return what a unit of each parameter changes of motions from ``states``, (parameter, recording, value)."""
        variants = len(self.system.A)
        start = np.broadcast_to(states, (variants, *states.shape))
        y = respond(self.system, start, self.batch.samples) + self._late
        y = y.reshape(variants, len(states), -1) * self._weight
        return np.asarray((y[1:] - y[0]) / self.moved[: variants - 1, None, None])

    @cached_property
    def _late(self) -> FloatArray:
        return given(self.system, self.batch)

    @cached_property
    def _weight(self) -> FloatArray:
        return self.batch.weights(self.noise_model)
