"""Lines of a weak nonlinearity, and the verdict's arithmetic."""

import numpy as np
import pytest

from hybrid.diagnosis.spectra import combination_lines
from hybrid.diagnosis.verdict import Errors


def test_lines_are_sums_and_differences_of_the_strongest_modes() -> None:
    lines = combination_lines(np.array([1.0, 3.5, 8.0, 20.0]), np.array([0.5, 0.3, 0.2, 0.0]))
    assert lines == pytest.approx([2.0, 2.5, 4.5, 7.0, 9.0, 11.5, 16.0])  # 4.5 = 1 + 3.5 = 8 - 3.5, 7 = 2 x 3.5 = 8 - 1


def test_two_modes_are_enough() -> None:
    assert combination_lines(np.array([2.0]), np.array([1.0])) == pytest.approx([4.0])


@pytest.mark.parametrize(
    ("calibrated", "extended", "nothing", "reached"),
    [
        (1.04, 1.0, True, True),  # both within 5 % of the floor, and less than that apart
        (1.04, 0.98, False, True),  # a cause improves on it by more
        (1.20, 1.04, False, True),
        (1.20, 1.10, False, False),
    ],
)
def test_floor_is_reached_within_five_per_cent(
    calibrated: float, extended: float, nothing: bool, reached: bool
) -> None:
    errors = Errors(calibrated, extended, 1.0, 0.0)
    assert (errors.nothing_to_gain, errors.reached) == (nothing, reached)


@pytest.mark.parametrize(
    ("extended", "unexplained", "near"), [(1.1, 0.01, True), (1.2, 0.01, False), (1.1, 0.2, False)]
)
def test_near_the_floor_is_near_beside_what_was_wrong_too(extended: float, unexplained: float, near: bool) -> None:
    assert Errors(3.0, extended, 1.0, unexplained).nearly_reached is near
