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


def test_what_does_not_swing_is_at_zero_where_that_is_asked_for() -> None:
    """A mean beside a wave of that amplitude: a Hann window makes lines of 1/2 and, beside each, of 1/4 of them."""
    time = np.arange(1000) / 100
    part = 100 * (1 + np.sin(2 * np.pi * 5 * time))[None, :, None]  # noise of 1 is next to nothing
    shares = energy_near(np.array([0.0, 5.0]), (part,), 100.0)
    # of positive frequencies: of the mean 1/4 + 1/16, of the wave, half as high, (1/4 + 2/16) / 4; noise adds 1e-4
    assert shares == pytest.approx([10 / 13, 3 / 13], abs=1e-3)
    assert energy_near(np.array([2.0, 5.0]), (part,), 100.0) == pytest.approx([0.0, 1.0], abs=0.02)
