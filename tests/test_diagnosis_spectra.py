"""Lines that a weak nonlinearity makes: sums and differences of natural frequencies."""

import numpy as np
import pytest

from hybrid.diagnosis.recorded.spectra import combination_lines, energy_near


def test_lines_are_sums_and_differences_of_the_strongest_modes() -> None:
    lines = combination_lines(np.array([1.0, 3.5, 8.0, 20.0]), np.array([0.5, 0.3, 0.2, 0.0]))
    assert lines == pytest.approx([2.0, 2.5, 4.5, 7.0, 9.0, 11.5, 16.0])  # 4.5 = 1 + 3.5 = 8 - 3.5, 7 = 2 x 3.5 = 8 - 1


def test_two_modes_are_enough() -> None:
    assert combination_lines(np.array([2.0]), np.array([1.0])) == pytest.approx([4.0])


def test_where_there_are_no_modes_no_energy_is_near_one() -> None:
    assert energy_near(np.zeros(0), (np.ones((1, 50, 2)),), 10.0).shape == (0,)
