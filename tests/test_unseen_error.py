"""How sure experts are: judged on the recordings that they did not see, never on their own."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm

from fe_models.arrays import FloatArray
from fe_models.built_in.four_dof import four_dof
from fe_models.recordings import Assumptions, Dataset, Recording
from hybrid.estimation.experts import Experts
from hybrid.estimation.forecast import forecast_windows
from hybrid.estimation.uncertainty import banded_forecast, coverage, relative_error, set_relative_error, unseen_error
from hybrid.training.expert_preparation import prepare_experts
from hybrid.training.preparation import Prepared
from tests.hybrid_problems import MEASURED, SENSORS, STEP, chain_modes, double_precision, off_chain, recorded
from tests.test_experts import EXPERTS, two_days

SEEN = 10


@pytest.fixture(autouse=True, scope="module")
def _double() -> Iterator[None]:
    with double_precision():
        yield


@pytest.fixture(scope="module")
def prepared(_double: None) -> Prepared[Experts]:
    return prepare_experts(two_days(), EXPERTS)


def noisy(model: Experts, clean: FloatArray, share: float, seed: int) -> FloatArray:
    """Starts as in ``clean``, after them the model's forecast with white noise of ``share`` of each channel's rms."""
    forecast = forecast_windows(model, clean).channels
    rms = np.sqrt((forecast**2).mean(axis=1, keepdims=True))
    data = forecast + share * rms * np.random.default_rng(seed).standard_normal(forecast.shape)
    data[:, :SEEN] = clean[:, :SEEN]
    return data


@pytest.mark.parametrize("share", [0.5, 1.5])
def test_a_known_error_of_the_others_is_found(prepared: Prepared[Experts], share: float) -> None:
    """Each recording is what the other's expert makes of it, and noise: of an expert's own fit nothing must be left.

    70 of 80 samples are noisy, the first ten nearly exact: 90 % are inside where (0.9 - 1/8) / (7/8) of the noisy are.
    20 x 4 x 70 numbers tell a quantile to 1.5 %, and the starts, of other days, are fitted to a tenth: to 6 %.
    """
    model, (first, _) = prepared.model, prepared.model.counts.tolist()
    windows = np.concatenate(
        [
            noisy(model.without(0), prepared.windows[:first], share, 1),
            noisy(model.without(1), prepared.windows[first:], share, 2),
        ]
    )
    inside = (0.9 - SEEN / 80) / (1 - SEEN / 80)
    expected = share * norm.ppf((1 + inside) / 2) / norm.ppf(0.95)
    assert unseen_error(model, windows) == pytest.approx(expected, rel=0.06)


def test_days_that_differ_are_detected_where_training_windows_are_not(prepared: Prepared[Experts]) -> None:
    """A tenth in frequency is a radian by the end: each expert knows its own day to a few per cent, the other's not."""
    model = prepared.model
    assert relative_error(model, prepared.windows) < 0.1
    assert unseen_error(model, prepared.windows) > 0.4


def test_the_held_out_sensor_takes_no_part(prepared: Prepared[Experts]) -> None:
    windows = prepared.windows.copy()
    windows[:, :, [i for i in range(len(SENSORS)) if i not in MEASURED]] = np.nan
    assert unseen_error(prepared.model, windows) == unseen_error(prepared.model, prepared.windows)


@pytest.mark.slow
def test_the_band_holds_a_day_that_nobody_saw() -> None:
    """Four days, frequencies 3 % apart at random; the bands of three of them on the fourth, each in turn.

    Over all four 90 % are meant; a day's coverage is one draw with a spread of some 10 %, their mean's is 5 %. Bands
    set on the days' own windows hold less than two thirds.
    """
    rng, one = np.random.default_rng(5), off_chain()
    days = [replace(one, omega=(1 + 0.03 * shift) * one.omega) for shift in rng.standard_normal(4)]
    recordings = tuple(Recording(f"day {i}", recorded(day, 6, 80, i, 0.01)) for i, day in enumerate(days))
    assumed = Assumptions(modal_model=chain_modes())
    every = prepare_experts(Dataset(four_dof(), 1 / STEP, SENSORS, recordings, assumptions=assumed), EXPERTS)
    assert len(every.kept) == len(days)
    counts = every.model.counts.tolist()
    found = []
    for i, unseen in enumerate(np.split(every.windows, np.cumsum(counts)[:-1])):
        others = every.model.without(i)
        set_relative_error(others, np.delete(every.windows, np.s_[sum(counts[:i]) : sum(counts[: i + 1])], axis=0))
        banded = banded_forecast(others, unseen)
        found.append(coverage(unseen - banded.forecast.channels, banded.std)[MEASURED].mean())
    assert 0.8 < np.mean(found) < 0.97, found


def test_a_single_expert_has_only_its_own_windows(prepared: Prepared[Experts]) -> None:
    alone = prepared.model.without(1)
    windows = prepared.windows[: int(alone.counts[0])]
    set_relative_error(alone, windows)
    assert float(alone.relative_error) == pytest.approx(relative_error(alone, windows), rel=1e-12)


def test_the_others_are_the_experts_of_the_other_recordings(prepared: Prepared[Experts]) -> None:
    """With one of two left, the forecast is its own, to rounding: its weight is one."""
    model, windows = prepared.model, prepared.windows[:5]
    for left_out, other in ((0, 1), (1, 0)):
        found = forecast_windows(model.without(left_out), windows).channels
        np.testing.assert_allclose(found, forecast_windows(model.members[other], windows).channels, rtol=1e-12)
        assert model.without(left_out).counts.tolist() == [model.counts.tolist()[other]]
    assert len(model.members) == 2


def test_the_band_of_a_certain_start_is_the_model_s_own_error_alone(prepared: Prepared[Experts]) -> None:
    model, windows = prepared.model, prepared.windows[:5]
    model.relative_error.fill_(0.3)
    banded = banded_forecast(model, windows)
    rms = np.sqrt((banded.forecast.channels**2).mean(axis=1, keepdims=True))
    np.testing.assert_allclose(banded.std, np.broadcast_to(0.3 * rms, banded.std.shape), rtol=1e-12)
