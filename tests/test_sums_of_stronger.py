"""What lies at a multiple or a sum of stronger modes' frequencies is told, and is no mode that moved far."""

import numpy as np
import pytest

from hybrid.identification.combinations import sums_of_stronger
from hybrid.identification.identified_modes import IdentifiedModes
from hybrid.identification.pairing import paired


def modes(frequencies: list[float], energy: list[float], error: float = 1e-4) -> IdentifiedModes:
    """Return modes whose frequencies are known to ``error``, relative."""
    count, omega = len(frequencies), 2 * np.pi * np.array(frequencies)
    covariance = np.zeros((count, 2 + 2 * count, 2 + 2 * count))
    covariance[:, 0, 0] = covariance[:, 1, 1] = (error * omega) ** 2
    roots = np.asarray(omega * complex(-0.01, np.sqrt(1 - 1e-4)), dtype=np.complex128)
    orders, numbers = np.zeros(count, dtype=int), np.arange(count)
    shapes = np.eye(count, dtype=complex)
    return IdentifiedModes(roots, shapes, numbers, covariance, np.array(energy), 0.0, orders, np.ones(count))


@pytest.mark.parametrize(
    ("frequency", "words"),
    [
        (3.674, "2 x 1.837"),
        (5.511, "3 x 1.837"),
        (8.096, "1.837 + 6.259"),
        (4.422, "6.259 - 1.837"),
        (3.69, ""),
        (7.0, ""),
    ],
)
def test_a_line_at_a_sum_of_stronger_modes_is_told(frequency: float, words: str) -> None:
    found = sums_of_stronger(modes([1.837, 6.259, frequency], [0.6, 0.3, 0.1]))
    assert found == ({2: words} if words else {})


def test_a_stronger_mode_is_no_sum_of_weaker_ones() -> None:
    assert sums_of_stronger(modes([1.837, 3.674], [0.3, 0.7])) == {}
    assert sums_of_stronger(modes([1.837], [1.0])) == {}


def test_what_is_known_badly_may_be_farther_off() -> None:
    assert sums_of_stronger(modes([2.0, 4.02], [0.9, 0.1], 1e-4)) == {}
    assert sums_of_stronger(modes([2.0, 4.02], [0.9, 0.1], 2e-3)) == {1: "2 x 2"}


def test_a_sum_is_no_mode_whose_frequency_moved_far() -> None:
    nominal, frequencies, energy = np.array([2.0, 9.0]), np.array([2.0, 4.0]), np.array([0.9, 0.1])
    criterion = np.array([[1.0, 0.1], [0.1, 0.999]])
    assert paired(nominal, frequencies, energy, criterion, 6, 100.0) == (0, 1)
    assert paired(nominal, frequencies, energy, criterion, 6, 100.0, {1: "2 x 2"}) == (0, -1)
    near = np.array([2.0, 4.2])
    assert paired(near, frequencies, energy, criterion, 6, 100.0, {1: "2 x 2"}) == (0, 1)
