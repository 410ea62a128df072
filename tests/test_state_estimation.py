"""The most probable initial state: from ten samples and from whole windows, from near and from far out."""

from collections.abc import Iterator

import numpy as np
import pytest
import torch
from scipy.linalg import expm
from torch import Tensor

from hybrid.estimation.config import STATE
from hybrid.estimation.most_probable_state import estimate_state, smooth_state
from hybrid.neural_modal_ode.model import NeuralModalODE
from hybrid.neural_modal_ode.state_prior import StatePrior
from tests.hybrid_problems import HELD_OUT, MEASURED, SENSORS, STEP, double_precision
from tests.places_problems import (
    NOISE,
    crooked_precision,
    differences,
    measured_channels,
    place_model,
    prior_of,
    residual_modes_of,
)
from tests.test_places import DASHPOTS, SPRINGS, crooked_modes

SAMPLES = 60


@pytest.fixture(autouse=True)
def _double() -> Iterator[None]:
    with double_precision():
        yield


def from_prior(count: int, seed: int = 0) -> Tensor:
    """States (count, 8) that follow the prior."""
    root = torch.linalg.cholesky(torch.linalg.inv(crooked_precision()))
    return torch.randn(count, 8, generator=torch.Generator().manual_seed(seed)) @ root.T


def observed(model: NeuralModalODE, z0: Tensor, samples: int = SAMPLES, seed: int = 1) -> Tensor:
    """Channels of the model itself with the noise that it is given."""
    generator = torch.Generator().manual_seed(seed)
    with torch.no_grad():
        data = model.forecast(z0, samples).channels
    data[:, :, MEASURED] += torch.tensor(NOISE) * torch.randn(len(z0), samples, 4, generator=generator)
    return data


@pytest.mark.parametrize("whole", [False, True])
def test_the_posterior_holds_the_truth_as_often_as_it_says(whole: bool) -> None:
    """e^T cov^-1 e of 60 states with 8 numbers each has the mean 8; 4 standard deviations are 4 sqrt(2 8 / 60) = 2.1.

    Laplace is exact for linear models only: 1 more, as the nets bend within the spread that ten samples leave.
    """
    model = place_model(crooked_modes())
    z0 = from_prior(60)
    windows = observed(model, z0)
    prior = prior_of(model)
    found = smooth_state(model, prior, windows) if whole else estimate_state(model, prior, windows[:, :10])
    error = z0 - found.mean
    squares = torch.einsum("bi,bij,bj->b", error, torch.linalg.inv(found.covariance), error)
    assert float(squares.mean()) == pytest.approx(8, abs=2.1 if whole else 3.1)


def test_whole_windows_tell_more_than_ten_samples() -> None:
    """In a chain that is hardly damped: six times the samples leave less than 0.6 of the error, 6^-1/2 being 0.4."""
    model = place_model(crooked_modes(), net=0.01)
    residual_modes_of(model).set_coefficients(torch.tensor(SPRINGS), torch.tensor(0.1 * DASHPOTS))
    z0 = from_prior(40)
    windows, prior = observed(model, z0), prior_of(model)
    few, all_of_them = estimate_state(model, prior, windows[:, :10]), smooth_state(model, prior, windows)
    errors = [float((found.mean - z0).square().mean().sqrt()) for found in (few, all_of_them)]
    stds = [float(found.covariance.diagonal(dim1=1, dim2=2).mean().sqrt()) for found in (few, all_of_them)]
    assert errors[1] < 0.6 * errors[0], errors
    assert stds[1] < 0.6 * stds[0], stds


def test_of_a_linear_chain_whole_windows_give_the_gaussian_posterior() -> None:
    """The Kalman smoother's answer in closed form, of 200 samples that no search starts with; 1e-6 of the largest."""
    model = place_model(crooked_modes(), net=0.0)
    windows = observed(model, from_prior(1), 200)
    A = model.dynamics.linear_part().detach().numpy()
    with torch.no_grad():
        C = model.decode(torch.eye(8), torch.zeros(8, 4))[:, MEASURED].numpy().T  # (measured, 8)
    seen = np.concatenate([C @ expm(A * STEP * k) / NOISE[:, None] for k in range(200)])
    covariance = np.linalg.inv(seen.T @ seen + crooked_precision().numpy())
    mean = covariance @ seen.T @ (windows[0][:, MEASURED].numpy() / NOISE).ravel()
    found = smooth_state(model, prior_of(model), windows)
    np.testing.assert_allclose(found.mean[0].numpy(), mean, rtol=0, atol=1e-6 * np.abs(mean).max())
    np.testing.assert_allclose(found.covariance[0].numpy(), covariance, rtol=0, atol=1e-8 * np.abs(covariance).max())


def test_starts_far_out_end_where_the_search_from_rest_does() -> None:
    """Five times as far as any state, over 40 samples: the same least misfit, to 1e-6 of it."""
    model = place_model(crooked_modes())
    windows, prior = observed(model, from_prior(12), 40), prior_of(model)
    rest = smooth_state(model, prior, windows)
    for seed in range(3):
        far = 5 * torch.randn(12, 8, generator=torch.Generator().manual_seed(seed))
        found = estimate_state(model, prior, windows, far, iterations=40)
        torch.testing.assert_close(found.misfit, rest.misfit, rtol=1e-6, atol=0)
        torch.testing.assert_close(found.mean, rest.mean, rtol=0, atol=1e-4)


def test_no_state_is_more_probable_nearby() -> None:
    """The misfit's slope at the mean is zero, by differences; and the covariance is that of the brute-force Jacobian.

    1e-6 of the largest entry of the normal matrix.
    """
    model = place_model(crooked_modes(), substeps=2)
    windows, prior = observed(model, from_prior(1), 20), prior_of(model)
    found = estimate_state(model, prior, windows, iterations=30)
    J = differences(lambda z: measured_channels(model, z, 20), found.mean)[0, :, 0]  # (8, value)
    left = (windows[0][:, MEASURED] / torch.tensor(NOISE)).flatten() - measured_channels(model, found.mean, 20)[0]
    normal = J @ J.T + crooked_precision()
    slope = J @ left - crooked_precision() @ found.mean[0]
    assert float(slope.abs().max()) < 1e-6 * float(normal.abs().max())
    torch.testing.assert_close(found.covariance[0], torch.linalg.inv(normal), rtol=0, atol=1e-6)


def test_windows_are_solved_for_independently_and_in_order() -> None:
    """More of them than one part holds; 1e-9: each search's own path, and one product of matrices or several."""
    model = place_model()
    windows, prior = observed(model, from_prior(STATE.windows_per_batch + 3), 30), prior_of(model)
    together = smooth_state(model, prior, windows)
    alone = [smooth_state(model, prior, window[None]).mean[0] for window in windows[-4:]]
    torch.testing.assert_close(together.mean[-4:], torch.stack(alone), rtol=0, atol=1e-9)
    assert together.mean.shape == (STATE.windows_per_batch + 3, 8)
    assert together.covariance.shape == (STATE.windows_per_batch + 3, 8, 8)
    assert together.misfit.shape == (STATE.windows_per_batch + 3,)


def test_a_window_far_beyond_the_model_spoils_no_other() -> None:
    """A thousand times as large: its search does not get there, and the others' do not notice."""
    model = place_model()
    windows, prior = observed(model, from_prior(3), 30), prior_of(model)
    spoiled = windows.clone()
    spoiled[1] *= 1e3
    found, clean = smooth_state(model, prior, spoiled), smooth_state(model, prior, windows)
    torch.testing.assert_close(found.mean[[0, 2]], clean.mean[[0, 2]], rtol=0, atol=1e-12)
    assert bool(torch.isfinite(found.mean).all() and torch.isfinite(found.covariance).all())


def test_held_out_sensors_are_never_seen() -> None:
    model = place_model()
    windows, prior = observed(model, from_prior(2), 30), prior_of(model)
    changed = windows.clone()
    changed[:, :, HELD_OUT] = 1e6
    assert SENSORS[HELD_OUT].role == "held_out"
    assert torch.equal(smooth_state(model, prior, changed).mean, smooth_state(model, prior, windows).mean)


def test_nothing_seen_is_rest_with_the_spread_of_the_prior() -> None:
    """Where the noise hides everything, what is known before is all: 1e-8 of it is left by a noise of 1e6."""
    model = place_model()
    prior = StatePrior(crooked_precision(), torch.full((4,), 1e6))
    found = smooth_state(model, prior, observed(model, from_prior(1), 30))
    assert float(found.mean.abs().max()) < 1e-8
    torch.testing.assert_close(found.covariance[0], torch.linalg.inv(crooked_precision()), rtol=0, atol=1e-8)
