"""The hybrid and the FE model side by side: what is compared, and how often the bands hold what they should."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
import torch

from fe_models.arrays import FloatArray
from hybrid.estimation.experts import fe_counterpart
from hybrid.estimation.forecast import Forecast, forecast_windows
from hybrid.estimation.uncertainty import BandedForecast
from hybrid.neural_modal_ode.residuals.free_residual import FreeResidual
from hybrid.training.forecast_comparison import Comparison, band_scores, compare
from hybrid.training.gradient_training import TrainingDivergedError
from tests.hybrid_problems import HELD_OUT, SENSORS, chain_dataset, double_precision, starting_model
from tests.places_problems import NOISE, place_model, prior_of, residual_modes_of

WINDOWS, SAMPLES = 3, 40


@pytest.fixture(autouse=True, scope="module")
def _double() -> Iterator[None]:
    with double_precision():
        yield


def forecast_of(channels: FloatArray) -> Forecast:
    q = np.zeros((*channels.shape[:2], 4))
    return Forecast(q, q, q, channels)


def made_up(shares: FloatArray, std: float) -> tuple[Comparison, BandedForecast]:
    """Windows of zeros, and forecasts of 1 in a given share of each channel's samples and of 0 else."""
    channels = np.zeros((WINDOWS, SAMPLES, len(SENSORS)))
    for i, share in enumerate(shares):
        channels[:, : round(share * SAMPLES), i] = 1.0
    windows = np.zeros_like(channels)
    banded = BandedForecast(forecast_of(channels), np.full_like(channels, std))
    return Comparison(windows, forecast_of(windows), banded), banded


def test_band_scores_are_the_shares_inside_role_by_role() -> None:
    """An error of 1 lies outside of 1.645 x 0.5 and inside of 1.645 x 0.7; the noise here is next to nothing."""
    model = starting_model(chain_dataset())
    model.relative_error.fill_(0.25)
    comparison, _ = made_up(np.array([0.1, 0.2, 0.5, 0.3, 0.4]), 0.5)
    expected = {"held_out": 0.5, "measured": 1 - (0.1 + 0.2 + 0.3 + 0.4) / 4}
    found = band_scores(model, comparison, SENSORS)
    assert found == {"level": 0.9, "relative_error": 0.25, "hybrid": pytest.approx(expected, rel=1e-12)}
    wide, _ = made_up(np.array([0.1, 0.2, 0.5, 0.3, 0.4]), 0.7)
    assert band_scores(model, wide, SENSORS)["hybrid"] == {"held_out": 1.0, "measured": 1.0}


def test_the_noise_of_the_sensors_is_part_of_the_band() -> None:
    """A band of 0.5 with a noise of 0.5 in it is 0.707 wide; only the first two of the measured sensors have that."""
    model = place_model()
    prior_of(model).noise_std.copy_(torch.tensor([0.5, 0.5, 1e-6, 1e-6]))
    comparison, _ = made_up(np.full(5, 0.5), 0.5)
    found = band_scores(model, comparison, SENSORS)["hybrid"]
    assert found == pytest.approx({"measured": (1 + 1 + 0.5 + 0.5) / 4, "held_out": 0.5}, rel=1e-12)


def test_whole_records_are_scored_beside_forecasts() -> None:
    model = place_model()
    comparison, _ = made_up(np.full(5, 0.5), 0.1)
    _, better = made_up(np.full(5, 0.25), 0.1)
    found = band_scores(model, replace(comparison, whole_record=better), SENSORS)
    assert set(found) == {"level", "relative_error", "hybrid", "whole_record"}
    assert found["hybrid"] == pytest.approx({"measured": 0.5, "held_out": 0.5})
    assert found["whole_record"] == pytest.approx({"measured": 0.75, "held_out": 0.75})


def test_roles_that_no_sensor_has_are_left_out() -> None:
    model, (comparison, _) = place_model(), made_up(np.full(5, 0.5), 0.1)
    measured = tuple(replace(sensor, role="measured") for sensor in SENSORS)
    assert set(band_scores(model, comparison, measured)["hybrid"]) == {"measured"}


def test_forecasts_are_named_as_in_the_metrics() -> None:
    comparison, banded = made_up(np.full(5, 0.5), 0.1)
    assert list(comparison.by_name) == ["fe", "hybrid"]
    assert comparison.by_name["hybrid"] is banded.forecast
    whole = replace(comparison, whole_record=banded)
    assert list(whole.by_name) == ["fe", "hybrid", "whole_record"]


def test_a_comparison_has_all_windows_of_the_test_recordings() -> None:
    """Windows at the stride, the FE model from the hybrid's states, and whole records where states are solved for."""
    dataset, model = chain_dataset(), place_model()
    found = compare(model, dataset, 60, 20)
    assert found is not None
    recorded = dataset.recordings[-1].data
    expected = np.concatenate([recorded[r : r + 1, start : start + 60] for r in range(3) for start in (0, 20, 40)])
    np.testing.assert_array_equal(found.windows, expected)
    fe = forecast_windows(model, expected, fe_counterpart(model))
    np.testing.assert_array_equal(found.fe.channels, fe.channels)
    np.testing.assert_array_equal(found.fe.q[:, 0], forecast_windows(model, expected).q[:, 0])
    assert found.whole_record is not None
    whole = forecast_windows(model, expected, whole=True)
    np.testing.assert_allclose(found.whole_record.forecast.channels, whole.channels, rtol=0, atol=1e-9)
    assert np.abs(found.whole_record.forecast.channels - found.hybrid.forecast.channels).max() > 1e-3


def test_models_that_encode_their_states_have_no_whole_records() -> None:
    dataset = chain_dataset()
    found = compare(starting_model(dataset), dataset, 60, 20)
    assert found is not None
    assert found.whole_record is None


def test_without_test_recordings_there_is_nothing_to_compare() -> None:
    dataset = chain_dataset()
    assert compare(place_model(), replace(dataset, recordings=dataset.select("train")), 60, 20) is None


def test_forecasts_that_overflow_say_what_to_change() -> None:
    """A coupling so strong that no number holds what comes of it in 60 samples."""
    model = starting_model(chain_dataset())
    assert isinstance(model.dynamics.residual, FreeResidual)
    model.dynamics.residual.rest.weight.data.fill_(1e4)
    with pytest.raises(TrainingDivergedError, match=r"--fresh.*--learning-rate"):
        compare(model, chain_dataset(), 60, 20)


def test_states_that_cannot_be_solved_for_say_what_to_change() -> None:
    """The same of a residual at places: springs so negative that every motion but rest overflows."""
    model = place_model(net=0.0)
    residual_modes_of(model).set_coefficients(torch.full((7,), -1e40), torch.zeros(7))
    with pytest.raises(TrainingDivergedError, match="--fresh"):
        compare(model, chain_dataset(), 60, 20)


def test_the_held_out_sensor_of_these_problems_is_one() -> None:
    assert [sensor.role for sensor in SENSORS].index("held_out") == HELD_OUT
    assert len(NOISE) == len(SENSORS) - 1
