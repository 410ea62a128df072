"""How sure predictions are: against the closed-form Gaussian posterior, by coverage, and against known model errors."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pytest
import torch
from torch import Tensor

from fe_models.arrays import FloatArray
from fe_models.errors import InputError
from fe_models.recordings import Sensor
from hybrid.estimation.config import UNCERTAINTY
from hybrid.estimation.forecast import forecast_windows, posterior
from hybrid.estimation.most_probable_state import estimate_state, smooth_state
from hybrid.estimation.uncertainty import BandedForecast, banded_forecast, coverage, noise_std, relative_error
from hybrid.neural_modal_ode.encoder import WindowEncoder
from hybrid.neural_modal_ode.model import NeuralModalODE
from tests.hybrid_problems import HELD_OUT, MEASURED, SENSORS, chain_dataset, double_precision, starting_model
from tests.places_problems import NOISE, crooked_precision, place_model, prior_of
from tests.test_places import crooked_modes

SEEN = 10


@pytest.fixture(autouse=True, scope="module")
def _double() -> Iterator[None]:
    with double_precision():
        yield


@dataclass(frozen=True)
class Simulated:
    """Channels (window, time, sensor) of a model with states that follow its prior: without noise, and with it."""

    clean: FloatArray
    data: FloatArray


def simulated(model: NeuralModalODE, windows: int, samples: int, seed: int = 0) -> Simulated:
    """Only measured channels get noise; nothing else is ever read."""
    generator = torch.Generator().manual_seed(seed)
    root = torch.linalg.cholesky(torch.linalg.inv(crooked_precision()))
    z0 = torch.randn(windows, 8, generator=generator) @ root.T
    with torch.no_grad():
        clean = model.forecast(z0, samples).channels
    data = clean.clone()
    data[:, :, MEASURED] += torch.tensor(NOISE) * torch.randn(windows, samples, 4, generator=generator)
    return Simulated(clean.numpy(), data.numpy())


def linear_model() -> NeuralModalODE:
    return place_model(crooked_modes(), net=0.0)


def exact_std(model: NeuralModalODE, covariance: Tensor, samples: int) -> FloatArray:
    """sqrt(diag(O cov O^T)) (window, time, sensor): O of a linear model, column by column, from unit states."""
    with torch.no_grad():
        seen = model.forecast(torch.eye(8), samples).channels  # (8, time, sensor)
    return np.asarray(torch.einsum("its,bij,jts->bts", seen, covariance, seen).sqrt())


def noise_factor(misfit: Tensor, values: int) -> FloatArray:
    """The root of the variance's posterior mean under a chi-squared prior of 20 degrees of freedom, (window, 1, 1)."""
    assert UNCERTAINTY.noise_degrees_of_freedom == 20
    return np.sqrt((2 * misfit.numpy() + 20) / (values + 20))[:, None, None]


@pytest.mark.parametrize("whole", [False, True])
def test_on_a_linear_chain_the_band_is_that_of_the_gaussian_posterior(whole: bool) -> None:
    """In closed form, times what each window's misfit says of the noise.

    50 draws tell a deviation to 1 / sqrt(100) = 10 %, so that no entry is off by half; all 40 windows to 2 %.
    """
    model = linear_model()
    data, prior = simulated(model, 40, 30).data, prior_of(model)
    found = banded_forecast(model, data, whole=whole)
    seen = torch.tensor(data)
    estimate = smooth_state(model, prior, seen) if whole else estimate_state(model, prior, seen[:, :SEEN])
    exact = exact_std(model, estimate.covariance, 30) * noise_factor(estimate.misfit, 4 * (30 if whole else SEEN))
    ratio = found.std / exact
    assert UNCERTAINTY.draws == 50
    assert np.abs(ratio - 1).max() < 0.5
    np.testing.assert_allclose(np.sqrt((ratio**2).mean(axis=(0, 1))), 1, atol=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("whole", [False, True])
def test_bands_of_90_percent_hold_87_to_93(whole: bool) -> None:
    """Of the motion, the channel that is never fitted too.

    600 windows with some four independent numbers each tell a share of 0.9 to sqrt(0.09 / 2400) = 0.6 %; that the
    deviation comes from 50 draws and a window's own noise costs 0.7 %: 87 % is nearly four standard errors away.
    A single channel has one or two independent numbers a window: 1.2 %, and 85 to 95 %.
    """
    model = linear_model()
    given = simulated(model, 600 if not whole else 400, 14, seed=3)
    found = banded_forecast(model, given.data, whole=whole)
    inside = coverage(given.clean - found.forecast.channels, found.std)
    assert inside.shape == (5,)
    assert 0.87 < inside.mean() < 0.93, inside
    assert np.abs(inside - 0.9).max() < 0.05, inside


def test_bands_hold_the_data_once_the_noise_is_added() -> None:
    """As `band_scores` adds it, after the samples that were fitted; noise is most of it, which keeps 200 x 14 numbers
    nearly independent: 0.6 %, of which 2 % are three and a half.
    """
    model = linear_model()
    given = simulated(model, 200, 24, seed=4)
    found = banded_forecast(model, given.data)
    std = np.hypot(found.std, noise_std(model, SENSORS))
    inside = coverage((given.data - found.forecast.channels)[:, SEEN:], std[:, SEEN:])[MEASURED]
    assert np.abs(inside - 0.9).max() < 0.02, inside


def test_the_model_s_own_error_comes_on_top() -> None:
    """sqrt(draws^2 + (relative error x rms of the channel)^2), to rounding; the forecast stays as it is."""
    model = linear_model()
    data = simulated(model, 12, 30).data
    before = banded_forecast(model, data)
    model.relative_error.fill_(0.3)
    after = banded_forecast(model, data)
    rms = np.sqrt((before.forecast.channels**2).mean(axis=1, keepdims=True))
    np.testing.assert_allclose(after.std, np.sqrt(before.std**2 + (0.3 * rms) ** 2), rtol=1e-12)
    np.testing.assert_array_equal(after.forecast.channels, before.forecast.channels)


def test_the_same_prediction_has_the_same_band_and_is_the_forecast() -> None:
    """To the bit; 1e-8 against `forecast_windows`, whose batches end their searches elsewhere; and past the window."""
    model = place_model()
    data = simulated(model, 13, 30).data
    one, other = banded_forecast(model, data), banded_forecast(model, data)
    np.testing.assert_array_equal(one.std, other.std)
    np.testing.assert_allclose(one.forecast.channels, forecast_windows(model, data).channels, rtol=0, atol=1e-8)
    longer = banded_forecast(model, data[:, :SEEN], samples=30)
    np.testing.assert_allclose(longer.std, one.std, rtol=0, atol=1e-12)
    assert one.std.shape == data.shape
    assert bool((one.std > 0).all())


def test_a_window_that_is_explained_badly_has_a_wide_band() -> None:
    """Noise of three times the size, in one window: its own band grows by nearly as much, the others' stay."""
    model = linear_model()
    given = simulated(model, 6, 30)
    louder = given.data.copy()
    louder[2] = given.clean[2] + 3 * (given.data[2] - given.clean[2])
    before, after = banded_forecast(model, given.data), banded_forecast(model, louder)
    ratio = (after.std / before.std).mean(axis=(1, 2))
    np.testing.assert_allclose(np.delete(ratio, 2), 1, rtol=1e-9)
    assert 1.5 < ratio[2] < 3


def test_the_posterior_s_root_is_one_of_its_covariance() -> None:
    """Root root^T is cov times the noise factor; of an encoder that gives variances, their roots in the diagonal."""
    model = linear_model()
    seen = torch.tensor(simulated(model, 5, 30).data)
    mean, root = posterior(model, seen)
    estimate = estimate_state(model, prior_of(model), seen[:, :SEEN])
    factor = torch.tensor(noise_factor(estimate.misfit, 40)) ** 2
    torch.testing.assert_close(root @ root.mT, estimate.covariance * factor, rtol=0, atol=1e-12)
    assert torch.equal(mean, estimate.mean)
    encoding = starting_model(chain_dataset())
    with torch.no_grad():
        expected, log_variance = encoding.encode(seen)
    mean, root = posterior(encoding, seen)
    assert torch.equal(mean, expected)
    torch.testing.assert_close(root @ root.mT, torch.diag_embed(log_variance.exp()), rtol=1e-12, atol=0)


def test_only_models_that_solve_for_states_use_whole_records() -> None:
    encoding = starting_model(chain_dataset())
    with pytest.raises(InputError, match="--preset places"):
        banded_forecast(encoding, simulated(linear_model(), 2, 40).data, whole=True)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_an_exact_model_has_hardly_an_error_of_its_own(seed: int) -> None:
    """White noise of 3 to 10 % of the channels leaves less than 2 %: neighbouring fits are nearly the same."""
    model = linear_model()
    assert relative_error(model, simulated(model, 40, 40, seed).data) < 0.02


def test_without_noise_an_exact_model_has_none() -> None:
    """Told of a noise of 1e-4, and shown none: what is left is what the band makes of it, of channels near one."""
    model = linear_model()
    clean = simulated(model, 20, 40).clean
    prior_of(model).noise_std.fill_(1e-4)
    assert relative_error(model, clean) < 1e-3


@pytest.mark.parametrize("share", [0.05, 0.2])
def test_a_known_share_of_slow_error_is_found(share: float) -> None:
    """A ramp of random sign on each channel, of ``share`` of its rms in each window, that no free vibration follows.

    To 30 %: a state with eight numbers can follow a part of it, noise is distinguished by chance only.
    """
    model = linear_model()
    given = simulated(model, 60, 60)
    rms = np.sqrt((given.clean**2).mean(axis=1, keepdims=True))
    signs = np.random.default_rng(0).choice([-1.0, 1.0], size=rms.shape)
    ramp = np.sqrt(3) * np.linspace(-1, 1, 60)[:, None]
    found = relative_error(model, given.data + share * rms * signs * ramp)
    assert found == pytest.approx(share, rel=0.3)


def test_the_share_of_a_model_that_encodes_its_states_is_that_of_its_misfit() -> None:
    """Each channel is off by 20 % of its rms, all of it after the ten samples that the encoder sees.

    To 5 %: the first ten are forecast to 1 %, and the draws, whose spread counts as explained, are made tiny.
    """
    model = starting_model(chain_dataset(noise=0.0))
    assert isinstance(model.encoder, WindowEncoder)
    model.encoder.log_variance.data.fill_(-30.0)
    data = np.concatenate([recording.data[:, :80] for recording in chain_dataset(noise=0.0).recordings])
    forecast = forecast_windows(model, data).channels
    rms = np.sqrt((forecast**2).mean(axis=1, keepdims=True))
    turns = np.where(np.arange(80 - SEEN) % 3 == 0, -1.0, 1.0)[:, None]
    data[:, SEEN:] = forecast[:, SEEN:] + 0.2 * np.sqrt(80 / (80 - SEEN)) * rms * turns
    assert relative_error(model, data) == pytest.approx(0.2, rel=0.05)


def test_the_error_is_estimated_anew_and_leaves_the_model_alone() -> None:
    """Whatever error it had before takes no part, and stays until somebody sets the new one."""
    model = linear_model()
    data = simulated(model, 20, 40).data
    first = relative_error(model, data)
    model.relative_error.fill_(0.7)
    assert relative_error(model, data) == first
    assert float(model.relative_error) == pytest.approx(0.7, rel=1e-15)


def test_a_sensor_that_is_not_fitted_is_as_noisy_as_those_like_it() -> None:
    """Of its quantity and its unit, the mean; zero where there are none, or where the model knows no noise."""
    model = linear_model()
    found = noise_std(model, SENSORS)
    np.testing.assert_allclose(found, [NOISE[0], NOISE[1], 0.0, NOISE[2], NOISE[3]], rtol=1e-15)
    like = list(SENSORS)
    like[HELD_OUT] = Sensor("a2", 2, "x", "acceleration", "m/s^2", "held_out")
    assert noise_std(model, tuple(like))[HELD_OUT] == pytest.approx(NOISE[1:].mean(), rel=1e-15)
    like[HELD_OUT] = Sensor("a2", 2, "x", "acceleration", "1", "held_out")
    assert noise_std(model, tuple(like))[HELD_OUT] == 0.0
    assert not noise_std(starting_model(chain_dataset()), SENSORS).any()


def test_coverage_counts_sensor_by_sensor() -> None:
    """1.645 deviations either side, the edge included."""
    error = np.array([[[1.64, 1.645], [-1.65, -1.64]], [[0.0, 3.0], [-1.0, 3.0]]])
    np.testing.assert_array_equal(coverage(error, np.ones_like(error)), [0.75, 0.5])
    np.testing.assert_array_equal(coverage(error, np.full_like(error, 2.0)), [1.0, 1.0])


def test_a_normal_error_is_covered_nine_times_in_ten() -> None:
    """100,000 numbers tell a share of 0.9 to 0.1 %."""
    error = np.random.default_rng(0).standard_normal((100, 1000, 1))
    assert coverage(error, np.ones_like(error))[0] == pytest.approx(0.9, abs=0.004)


def test_a_banded_forecast_is_a_forecast_and_its_deviation() -> None:
    assert set(BandedForecast.__dataclass_fields__) == {"forecast", "std"}
