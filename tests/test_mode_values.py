"""The values of a mode stand in one order: what is written there is read from there."""

import numpy as np

from hybrid.diagnosis.modal.mode_values import (
    FREQUENCY,
    MODE_QUANTITIES,
    RATIO,
    SHAPE,
    free_values,
    quantities_of,
    shape_parts,
    shapes_in,
    value_count,
    values_of_modes,
)

SENSORS = 3
LOG_OMEGA, RATIOS = np.array([2.0, 3.0]), np.array([0.01, 0.02])
SHAPES = np.array([[1.0, 0.5 - 0.1j, 0.2j], [-0.3, 1.0, 0.7 + 0.4j]])


def test_values_are_those_of_the_modes() -> None:
    values = values_of_modes(LOG_OMEGA, RATIOS, SHAPES)
    real, imaginary = shape_parts(SENSORS)
    assert values.shape == (2, value_count(SENSORS))
    np.testing.assert_array_equal(values[:, FREQUENCY], LOG_OMEGA)
    np.testing.assert_array_equal(values[:, RATIO], RATIOS)
    np.testing.assert_array_equal(values[:, real], SHAPES.real)
    np.testing.assert_array_equal(values[:, imaginary], SHAPES.imag)
    np.testing.assert_array_equal(shapes_in(values), SHAPES)


def test_each_value_has_the_quantity_that_stands_there() -> None:
    names = [MODE_QUANTITIES[number] for number in quantities_of(SENSORS)]
    assert names == ["frequency", "ratio", *["shape"] * SENSORS, *["phase"] * SENSORS]
    real, imaginary = shape_parts(SENSORS)
    assert set(names[real]) == {"shape"} and set(names[imaginary]) == {"phase"}
    assert names[SHAPE] == [*names[real], *names[imaginary]]


def test_reference_entries_alone_are_not_free() -> None:
    """A shape over its own entry is one there, whatever it is: 1 + 0i says nothing."""
    reference = np.array([0, 2])
    over = SHAPES / SHAPES[np.arange(2), reference][:, None]
    values = values_of_modes(LOG_OMEGA, RATIOS, over)
    said = values[~free_values(reference, SENSORS)].reshape(2, 2)
    np.testing.assert_allclose(said, [[1.0, 0.0], [1.0, 0.0]], atol=1e-15)
    assert free_values(reference, SENSORS).sum() == 2 * (value_count(SENSORS) - 2)
