"""What a linear model's channels say about initial states and parameters, whatever their values stand for."""

from typing import Protocol

from fe_models.arrays import FloatArray


class Channels(Protocol):
    """A batch and what a system makes of it, in units of the noise.

    A value is one of a sensor at a sample or, where there is a ``frame`` (time, coordinate), a sensor's part along one
    of these orthonormal functions of time.
    """

    @property
    def frame(self) -> FloatArray | None:
        """The functions of time that values are parts along; None where they are samples."""

    @property
    def data(self) -> FloatArray:
        """What initial states are to show (recording, value): the recordings less what is there without them."""

    @property
    def by_state(self) -> FloatArray:
        """What they show a unit (value, state), or (recording, value, state) where noise is not alike."""

    def left(self, states: FloatArray) -> FloatArray:
        """Return what ``states`` (recording, state) leave of the recordings, (recording, time, sensor)."""

    def changes(self, states: FloatArray) -> FloatArray:
        """Return what a unit of each parameter changes of motions from ``states``, (parameter, recording, value)."""
