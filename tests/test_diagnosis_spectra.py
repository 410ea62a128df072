"""Lines that a weak nonlinearity makes: sums and differences of natural frequencies."""

import numpy as np
import pytest

from hybrid.diagnosis.recorded.spectra import combination_lines


def test_lines_are_sums_and_differences_of_the_strongest_modes() -> None:
    lines = combination_lines(np.array([1.0, 3.5, 8.0, 20.0]), np.array([0.5, 0.3, 0.2, 0.0]))
    assert lines == pytest.approx([2.0, 2.5, 4.5, 7.0, 9.0, 11.5, 16.0])  # 4.5 = 1 + 3.5 = 8 - 3.5, 7 = 2 x 3.5 = 8 - 1


def test_two_modes_are_enough() -> None:
    assert combination_lines(np.array([2.0]), np.array([1.0])) == pytest.approx([4.0])
