"""The values of a mode, in one order wherever they stand: what is measured, predicted, or left of both.

First the logarithm of its natural frequency (of omega, rad/s), then its damping ratio, then the real parts of its shape
at all sensors, then the imaginary parts: 2 + 2 sensor values. A shape has any scale and phase; to be compared it is
taken over one entry, its reference, which is then one and says nothing.
"""

from dataclasses import dataclass

import numpy as np

from fe_models.arrays import BoolArray, ComplexArray, FloatArray, IntArray

MODE_QUANTITIES = ("frequency", "ratio", "shape", "phase")
"""What values are of, each with an error of its own size (`ErrorSizes`); real parts are those of "shape"."""
FREQUENCY, RATIO = 0, 1  # where these values stand; of quantities, too, as either has one value alone
SHAPE = slice(2, None)  # where all values of the shape stand


@dataclass(frozen=True, eq=False)
class ModeValues:
    """The ``values`` (mode, value) of some modes over their references, and their ``covariance`` (mode, value, value),
    each mode's by itself.
    """

    values: FloatArray
    covariance: FloatArray

    def take(self, modes: IntArray) -> "ModeValues":
        """Return those of some ``modes``, by their numbers."""
        return ModeValues(self.values[modes], self.covariance[modes])


def value_count(sensors: int) -> int:
    """Return how many values a mode has."""
    return 2 + 2 * sensors


def shape_parts(sensors: int) -> tuple[slice, slice]:
    """Return where the real and where the imaginary parts of a shape stand."""
    return slice(2, 2 + sensors), slice(2 + sensors, 2 + 2 * sensors)


def quantities_of(sensors: int) -> IntArray:
    """Return the number among `MODE_QUANTITIES` of each value's, (value,)."""
    return np.array(
        [FREQUENCY, RATIO] + [MODE_QUANTITIES.index("shape")] * sensors + [MODE_QUANTITIES.index("phase")] * sensors
    )


def values_of_modes(log_omega: FloatArray, ratios: FloatArray, shapes: ComplexArray) -> FloatArray:
    """Return the values (..., mode, value) of modes, of ``log_omega`` and damping ``ratios`` (..., mode) and of
    ``shapes`` (..., mode, sensor).
    """
    return np.concatenate([np.stack([log_omega, ratios], axis=-1), shapes.real, shapes.imag], axis=-1)


def shapes_in(values: FloatArray) -> ComplexArray:
    """Return the shapes (..., sensor) that ``values`` (..., value) have."""
    real, imaginary = shape_parts(values.shape[-1] // 2 - 1)
    return np.asarray(values[..., real] + 1j * values[..., imaginary])


def free_values(reference: IntArray, sensors: int) -> BoolArray:
    """Return which values (mode, value) say something: all but both parts of each ``reference`` (mode,) entry."""
    free = np.ones((len(reference), value_count(sensors)), dtype=bool)
    for part in shape_parts(sensors):
        free[np.arange(len(reference)), part.start + reference] = False
    return free
