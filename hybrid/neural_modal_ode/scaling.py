"""Units: channels are divided by their own size and modal states by theirs, so that networks see numbers near one."""

from dataclasses import dataclass

import numpy as np

from fe_models.arrays import FloatArray


@dataclass(frozen=True)
class StateScale:
    """Sizes of the modal coordinates: ``displacement`` a and ``velocity`` b, each (mode,); z = [q / a, q' / b]."""

    displacement: FloatArray
    velocity: FloatArray

    @classmethod
    def unit(cls, modes: int) -> "StateScale":
        """Return the scale of the paper: the state as it is."""
        return cls(np.ones(modes), np.ones(modes))

    @classmethod
    def of_velocity(cls, velocity: FloatArray, omega: FloatArray) -> "StateScale":
        """Return a scale under which a freely vibrating mode moves on a circle: a = b / omega."""
        return cls(velocity / omega, velocity)


def channel_scale(windows: FloatArray) -> FloatArray:
    """Return the standard deviation of each channel, shape (sensor,), over windows (window, time, sensor)."""
    return windows.std(axis=(0, 1))
