"""The channels of a linear model by the few functions of time that they consist of, and not by their samples.

All that initial states and parameters can do, to first order, is in the span of exp(root t) and t exp(root t): tens of
functions for thousands of samples. In an orthonormal frame of these all products of residual and slopes are the same.
"""

from dataclasses import dataclass
from functools import cached_property
from math import prod

import numpy as np

from fe_models.arrays import FloatArray
from hybrid.diagnosis.recorded.batches import Batch
from hybrid.diagnosis.recorded.noise_model import NoiseModel
from hybrid.diagnosis.response.exponentials import Exponentials, exponentials
from hybrid.diagnosis.response.system import System, drift, drifted


@dataclass(frozen=True)
class Condensed:
    """The `Channels` of a ``batch`` and a system; a value is a sensor's part along a vector of a frame.

    ``table`` (time, function) of the ``exponentials``, an orthonormal ``frame`` of it (time, coordinate), and what each
    function is in that, ``inside`` (coordinate, function).
    """

    exponentials: Exponentials
    batch: Batch
    noise_model: NoiseModel
    moved: FloatArray
    table: FloatArray
    frame: FloatArray
    inside: FloatArray

    @cached_property
    def data(self) -> FloatArray:
        """What initial states are to show (recording, value): the recordings less what is there without them."""
        own = self.frame.T @ self._rest
        return (own / self.batch.sigma(self.noise_model)).reshape(len(own), -1)

    @cached_property
    def by_state(self) -> FloatArray:
        """What they show a unit (value, state), or (recording, value, state) where noise is not alike."""
        shown = self._of(self._coefficients)  # (coordinate, sensor, state)
        shown = shown / self.batch.sigma(self.noise_model)[..., None]
        return shown.reshape(*shown.shape[:-3], -1, shown.shape[-1])[0 if len(shown) == 1 else slice(None)]

    def left(self, states: FloatArray) -> FloatArray:
        """Return what ``states`` (recording, state) leave of the recordings, (recording, time, sensor)."""
        c = self._coefficients @ states.T  # (function, sensor, recording)
        shown = (self.table @ c.reshape(len(c), -1)).reshape(-1, *c.shape[1:])
        return np.asarray((self._rest - shown.transpose(2, 0, 1)) / self.batch.sigma(self.noise_model))

    def changes(self, states: FloatArray) -> FloatArray:
        """Return what a unit of each parameter changes of motions from ``states``, (parameter, recording, value)."""
        system = self.exponentials.system
        moved = self.moved[: len(system.A) - 1]
        c = self.exponentials.changes(states, moved)  # (function, parameter, recording, sensor)
        since = (system.slope[1:] - system.slope[0]) / moved[:, None]  # (parameter, sensor)
        c[-2] += since[:, None] * (self.batch.begins * system.step)[:, None]
        own = self._of(c).transpose(1, 2, 0, 3) / self.batch.sigma(self.noise_model)
        return own.reshape(*own.shape[:2], prod(own.shape[2:]))

    def _of(self, c: FloatArray) -> FloatArray:
        """Return the coordinates (coordinate, ...) of coefficients (function, ...)."""
        return (self.inside @ c.reshape(len(c), prod(c.shape[1:]))).reshape(len(self.inside), *c.shape[1:])

    @cached_property
    def _coefficients(self) -> FloatArray:
        return self.exponentials.of_states()

    @cached_property
    def _rest(self) -> FloatArray:
        """The recordings less their drift, (recording, time, sensor)."""
        system, batch = self.exponentials.system.only(0), self.batch
        return np.asarray(batch.data - drifted(system, batch.begins)[0] - drift(system, batch.samples)[0])


def condense(system: System, batch: Batch, noise_model: NoiseModel, moved: FloatArray) -> Condensed | None:
    """Return a batch and a ``system`` whose further variants have ``moved`` (parameter,) one each, condensed.

    None under known loads, which make other motions, and where eigenvectors fall together.
    """
    found = None if batch.loads is not None else exponentials(system)
    if found is None:
        return None
    table = found.table(batch.samples)
    return Condensed(found, batch, noise_model, moved, table, *np.linalg.qr(table))
