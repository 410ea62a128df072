"""Scores by hand, and the table that goes into metrics.json."""

import numpy as np
import pytest

from fe_models.recordings import Sensor
from hybrid.training.evaluation import FIRST_WINDOWS, score_table
from hybrid.training.scoring import nrmse, r2
from tests.hybrid_problems import SENSORS


def test_scores_of_a_sine_by_hand() -> None:
    """Off by c everywhere: NRMSE = c / 2, R2 = 1 - c^2 / (1/2). Silence: NRMSE = sqrt(1/2) / 2, R2 = 0."""
    sine = np.sin(2 * np.pi * np.arange(400) / 100)[None, :, None]  # extremes +-1 are among the samples
    assert nrmse(sine + 0.3, sine)[0, 0] == pytest.approx(0.15)
    assert r2(sine + 0.3, sine)[0, 0] == pytest.approx(1 - 0.09 / 0.5)
    assert nrmse(0 * sine, sine)[0, 0] == pytest.approx(0.125**0.5)
    assert r2(0 * sine, sine)[0, 0] == pytest.approx(0.0)
    assert r2(sine, sine)[0, 0] == 1.0


def test_a_wrong_scale_or_offset_is_not_forgiven() -> None:
    """A regression line through (truth, prediction) would score all of these 1."""
    x = np.random.default_rng(0).standard_normal((1, 500, 1))
    assert r2(2 * x, x)[0, 0] == pytest.approx(0.0, abs=0.01)  # 1 - sum x^2 / sum (x - mean)^2
    assert r2(x + 5.0, x)[0, 0] < -20
    assert r2(-x, x)[0, 0] == pytest.approx(-3.0, abs=0.05)


def test_each_window_and_each_channel_has_its_own_range_and_mean() -> None:
    rng = np.random.default_rng(0)
    measured, error = rng.standard_normal((2, 3, 50, 4))
    scale, offset = 10.0 ** rng.uniform(-3, 3, (2, 3, 1, 4))
    for score in (nrmse, r2):
        plain = score(measured + error, measured)
        assert plain.shape == (3, 4)
        moved = score((measured + error) * scale + offset, measured * scale + offset)
        np.testing.assert_allclose(moved, plain, rtol=1e-6)  # cancellation under offsets of up to 1e6 widths
    for window, channel in np.ndindex(3, 4):
        x, y = measured[window, :, channel], (measured + error)[window, :, channel]
        alone = np.sqrt(np.mean((x - y) ** 2)) / (x.max() - x.min())
        assert nrmse(measured + error, measured)[window, channel] == pytest.approx(alone, rel=1e-12)


def test_the_table_averages_measured_and_held_out_channels_apart() -> None:
    rng = np.random.default_rng(1)
    measured, error = rng.standard_normal((2, 20, 30, 5))
    errors, fits = nrmse(measured + error, measured), r2(measured + error, measured)
    fitted, unseen = [0, 1, 3, 4], [2]
    table = score_table({"hybrid": measured + error, "fe": measured}, measured, SENSORS)
    assert table["fe"]["measured"]["nrmse"] == 0.0
    for role, picks in (("measured", fitted), ("held_out", unseen)):
        scores = table["hybrid"][role]
        assert scores["nrmse"] == pytest.approx(errors[:, picks].mean(), rel=1e-12)
        assert scores["r2"] == pytest.approx(fits[:, picks].mean(), rel=1e-12)
        assert scores["nrmse_first_16_windows"] == pytest.approx(errors[:FIRST_WINDOWS, picks].mean(), rel=1e-12)
        assert scores["r2_first_16_windows"] == pytest.approx(fits[:FIRST_WINDOWS, picks].mean(), rel=1e-12)
        by_window = errors[:, picks].mean(axis=1)
        assert scores["nrmse_worst_window"] == pytest.approx(by_window.max(), rel=1e-12)
        assert scores["worst_window"] == 1 + by_window.argmax()  # from 1, as people count
    one = table["hybrid"]["channels"]["v2"]
    assert one["role"] == "held_out"
    assert one["nrmse"] == pytest.approx(errors[:, 2].mean(), rel=1e-12)


def test_without_held_out_channels_there_is_no_score_for_them() -> None:
    data = np.random.default_rng(0).standard_normal((1, 9, 1))
    table = score_table({"fe": data}, data, [Sensor("a", 1, "x", "acceleration", "1")])
    assert table["fe"]["held_out"] is None
    assert table["fe"]["measured"]["nrmse"] == 0.0
