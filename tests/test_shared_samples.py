"""A test recording that was trained on is found by its samples, whatever its name and wherever it begins."""

from collections.abc import Callable

import numpy as np
import pytest

from fe_models.arrays import FloatArray
from fe_models.files.shared_samples import shared_stretches
from fe_models.recordings import Recording

TRAIN: FloatArray = np.random.default_rng(0).standard_normal((3, 400, 2))
OTHER: FloatArray = np.random.default_rng(1).standard_normal((2, 300, 2))


def faults(test: FloatArray, train: FloatArray = TRAIN) -> list[str]:
    return shared_stretches([Recording("monday", train), Recording("tuesday", test, "test")])


@pytest.mark.parametrize(
    ("cut", "word"),
    [
        (lambda data: data, "the same samples as"),
        (lambda data: data[1:2, 50:200], "a stretch of"),
        (lambda data: data[2:, 368:], "a stretch of"),
        (lambda data: np.concatenate([data[:1, 100:], OTHER[:1]], axis=1), "a stretch of"),
        (lambda data: np.concatenate([OTHER[:1], data[:1, :80]], axis=1), "a stretch of"),
        (lambda data: np.concatenate([np.zeros((1, 64, 2)), data[:1, 40:120]], axis=1), "a stretch of"),
    ],
)
def test_what_was_trained_on_is_no_test(cut: Callable[[FloatArray], FloatArray], word: str) -> None:
    (fault,) = faults(cut(TRAIN))
    assert f"'tuesday' is for testing, but holds {word}" in fault
    assert fault.endswith("'monday', which is trained on")


def test_other_motions_share_nothing() -> None:
    """Nor do those that are silent at first, or differ in one channel or in noise."""
    assert faults(OTHER) == []
    silent = [np.concatenate([np.zeros((1, 100, 2)), motions[:1]], axis=1) for motions in (TRAIN, OTHER)]
    assert faults(*silent) == []
    assert faults(TRAIN + np.array([0.0, 1e-9])) == []
    assert faults(np.round(OTHER, 1), np.round(TRAIN, 1)) == []  # of a converter with few steps
    assert faults(OTHER[..., :1], TRAIN) == []


def test_many_long_motions_take_no_time() -> None:
    train = np.random.default_rng(2).standard_normal((100, 2000, 3))
    assert faults(train[-1:, 1900:], train) != []
    assert faults(train[:20] + 1.0, train) == []
