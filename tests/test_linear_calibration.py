"""Linear calibration: a truth with other frequencies and damping is found from its free decays."""

from dataclasses import replace

import numpy as np
import pytest
import torch
from scipy.linalg import expm

from fe_models.arrays import FloatArray
from hybrid.estimation.config import LINEAR_CALIBRATION
from hybrid.estimation.linear_calibration import LinearFit, Observer, fit_linear_rest, initial_state_estimator, smooth
from hybrid.estimation.windows import cut
from tests.hybrid_problems import (
    MEASURED,
    OFF_FREQUENCY,
    OFF_RATIO,
    SENSORS,
    STEP,
    chain_dataset,
    chain_modes,
    channels,
    decay,
    off_chain,
    recorded,
    with_column,
)

FITTED = tuple(SENSORS[i] for i in MEASURED)
SAMPLES = 120


def observer() -> Observer:
    return Observer(chain_modes(), FITTED, STEP)


def fit_to(windows: FloatArray) -> LinearFit:
    return fit_linear_rest(observer(), torch.tensor(windows))


def modes_of(fit: LinearFit) -> tuple[FloatArray, FloatArray]:
    """Frequencies (rad/s), ascending, and damping ratios of the calibrated model, from the eigenvalues of its A."""
    stiffness, damping = observer().rates(torch.tensor(fit.rest))
    omega = np.diag(chain_modes().omega)
    values = np.linalg.eigvals(np.block([[np.zeros((4, 4)), omega], [stiffness.numpy(), damping.numpy()]]))
    values = values[values.imag > 0]
    values = values[np.argsort(abs(values))]
    return abs(values), -values.real / abs(values)


@pytest.fixture(scope="module")
def exact_fit() -> LinearFit:
    return fit_to(recorded(off_chain(), 20, SAMPLES, seed=0, sensors=FITTED))


def test_the_observer_sees_what_the_closed_form_says() -> None:
    """x_k = C exp(A k h) z, z = [omega q, q'], here with the nominal rest of zero; 1e-12 is rounding."""
    modal = chain_modes(0.03)
    q, q_dot = np.random.default_rng(0).standard_normal((2, 6, 4))
    seen = channels(modal, decay(modal, q, q_dot, STEP, 90), SENSORS)
    matrix = Observer(modal, SENSORS, STEP).matrix(torch.zeros(2, 4, 4, dtype=torch.float64), 90).numpy()
    z = np.hstack([modal.omega * q, q_dot])
    np.testing.assert_allclose(np.einsum("ksz,wz->wks", matrix, z), seen, rtol=0, atol=1e-12)


def test_the_observer_uses_the_rest_as_documented() -> None:
    """K and C gain omega_i omega_j rest_0 and sqrt(omega_i omega_j) rest_1."""
    rest = 0.1 * np.random.default_rng(0).standard_normal((2, 4, 4))
    w = chain_modes().omega
    K = np.diag(w**2) + np.outer(w, w) * rest[0]
    C = np.diag(0.02 * w) + np.sqrt(np.outer(w, w)) * rest[1]
    shapes = chain_modes().shapes[[3, 0, 2, 3]]
    rows = [np.hstack([shapes[:1], 0 * shapes[:1]]), np.hstack([-shapes[1:] @ K, -shapes[1:] @ C])]  # of q and q'
    A = np.block([[np.zeros((4, 4)), np.eye(4)], [-K, -C]])
    expected = np.vstack(rows) @ expm(7 * STEP * A) / np.concatenate([w, np.ones(4)])
    found = observer().matrix(torch.tensor(rest), 8)[7].numpy()
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-12)


def test_frequencies_and_damping_are_found(exact_fit: LinearFit) -> None:
    """18 % off in frequency and 1 % damping for 7 %: what the penalty of 1e-5 leaves is below 1e-4 and 1e-2."""
    omega, ratio = modes_of(exact_fit)
    np.testing.assert_allclose(omega, np.sort(chain_modes().omega * OFF_FREQUENCY), rtol=1e-4)
    np.testing.assert_allclose(ratio, OFF_RATIO, rtol=1e-2)
    assert exact_fit.unexplained < 1e-6


def test_noise_of_three_percent_costs_little() -> None:
    """Of 20 windows of 120 samples: 0.2 % of a frequency and a twentieth of a damping ratio are about five sigma."""
    fit = fit_to(recorded(off_chain(), 20, SAMPLES, seed=0, noise=0.03, sensors=FITTED))
    omega, ratio = modes_of(fit)
    np.testing.assert_allclose(omega, np.sort(chain_modes().omega * OFF_FREQUENCY), rtol=2e-3)
    np.testing.assert_allclose(ratio, OFF_RATIO, rtol=0.05)
    assert 2e-4 < fit.unexplained < 3e-3  # 0.03^2 of the energy is noise, weighted by the windows' sizes


def test_an_exact_model_is_left_alone() -> None:
    fit = fit_to(recorded(chain_modes(), 20, SAMPLES, seed=0, sensors=FITTED))
    assert np.abs(fit.rest).max() < 1e-6
    assert fit.unexplained < 1e-7  # left by the ridge of 1e-4 on the initial state, squared


@pytest.mark.parametrize("factor", [1024.0, 1e-3])
def test_units_do_not_matter(exact_fit: LinearFit, factor: float) -> None:
    """A power of two changes no digit; 1e-3 changes rounding, which the last iterations of L-BFGS amplify."""
    fit = fit_to(factor * recorded(off_chain(), 20, SAMPLES, seed=0, sensors=FITTED))
    if factor == 1024.0:
        np.testing.assert_array_equal(fit.rest, exact_fit.rest)
    np.testing.assert_allclose(fit.rest, exact_fit.rest, rtol=0, atol=1e-4)


def test_one_loud_window_does_not_drown_the_others() -> None:
    """Windows are weighed by their own size: a window a thousand times louder of another structure changes little."""
    quiet = recorded(off_chain(), 20, SAMPLES, seed=0, sensors=FITTED)
    loud = replace(chain_modes(), omega=0.95 * chain_modes().omega)
    few = 30 * recorded(loud, 1, SAMPLES, seed=1, sensors=FITTED)
    omega, _ = modes_of(fit_to(np.concatenate([quiet, few])))
    np.testing.assert_allclose(omega, np.sort(chain_modes().omega * OFF_FREQUENCY), rtol=0.03)


def test_a_frequency_far_off_is_found_over_many_periods() -> None:
    """300 samples hold up to 50 periods, which 18 % shift by nine: only windows that grow lead there."""
    truth = replace(off_chain(), damping_ratio=np.full(4, 0.01))
    windows = torch.tensor(recorded(truth, 12, 300, seed=0, sensors=FITTED))
    assert fit_linear_rest(observer(), windows).unexplained < 1e-6


def test_a_channel_that_only_drifts_leaves_finite_numbers() -> None:
    """No vibration explains a ramp: the search for one runs into numbers that overflow, and must come back."""
    drifting = with_column(chain_dataset(), "train", 0, 1.0)
    fit = fit_to(cut(drifting.recordings[0], 80, 20)[:, :, MEASURED])
    assert np.isfinite(fit.rest).all()
    assert 0 < fit.unexplained < 0.2


def test_what_is_unexplained_is_that_of_the_rest_that_is_returned() -> None:
    """Not of the last trial of the line search. Windows of equal rms, so that their weights do not matter."""
    windows = recorded(off_chain(), 8, SAMPLES, seed=0, noise=0.1, sensors=FITTED)
    windows /= np.sqrt(np.mean(windows**2, axis=(1, 2), keepdims=True))
    fit = fit_to(windows)
    _, fitted = smooth(observer().matrix(torch.tensor(fit.rest), SAMPLES), torch.tensor(windows))
    left = np.mean((fitted.numpy() - windows) ** 2) / np.mean(windows**2)
    assert fit.unexplained == pytest.approx(left, rel=1e-9)


def test_smoothing_is_ridge_regression() -> None:
    """The same by an augmented least-squares problem, [X; sqrt(ridge) I] z = [x; 0]."""
    rng = np.random.default_rng(0)
    observability, windows = rng.standard_normal((9, 2, 5)), rng.standard_normal((4, 9, 2))
    states, fitted = smooth(torch.tensor(observability), torch.tensor(windows))
    X = observability.reshape(18, 5)
    ridge = LINEAR_CALIBRATION.ridge * (X**2).sum(axis=0).mean()
    tall = np.vstack([X, np.sqrt(ridge) * np.eye(5)])
    expected = np.linalg.lstsq(tall, np.vstack([windows.reshape(4, 18).T, np.zeros((5, 4))]))[0].T
    np.testing.assert_allclose(states.numpy(), expected, rtol=1e-10)
    np.testing.assert_allclose(fitted.numpy(), (expected @ X.T).reshape(4, 9, 2), rtol=1e-10)


def test_the_estimator_is_the_posterior_mean() -> None:
    """In the information form, (O^T R^-1 O + P^-1)^-1 O^T R^-1 x, from the same P and R; 1e-3: the ridge on z."""
    rng = np.random.default_rng(0)
    observability, windows = rng.standard_normal((12, 2, 3)), rng.standard_normal((40, 12, 2))
    found = initial_state_estimator(torch.tensor(observability), torch.tensor(windows), 2).numpy()
    z = np.linalg.lstsq(observability.reshape(24, 3), windows.reshape(40, 24).T)[0].T  # but for the ridge of 1e-4
    error = (windows - np.einsum("ksz,wz->wks", observability, z))[:, :2].reshape(40, 4)
    R = error.T @ error / 40
    R += LINEAR_CALIBRATION.covariance_shrinkage * np.trace(R) / 4 * np.eye(4)
    seen, precision = observability[:2].reshape(4, 3), np.linalg.inv(z.T @ z / 40)
    expected = np.linalg.solve(seen.T @ np.linalg.inv(R) @ seen + precision, seen.T @ np.linalg.inv(R))
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-3 * np.abs(expected).max())


def test_the_estimator_is_nearly_as_good_as_one_that_knows_all() -> None:
    """On new windows, against the Gaussian posterior with the true covariances of state (I) and noise."""
    modal, samples = off_chain(), 10
    seen = Observer(modal, FITTED, STEP).matrix(torch.zeros(2, 4, 4, dtype=torch.float64), SAMPLES)
    noise = 0.05 * recorded(modal, 300, SAMPLES, seed=0, sensors=FITTED).std(axis=(0, 1))  # as `recorded` draws it
    windows = recorded(modal, 300, SAMPLES, seed=0, noise=0.05, sensors=FITTED)
    W = initial_state_estimator(seen, torch.tensor(windows), samples).numpy()
    rows = seen[:samples].reshape(-1, 8).numpy()
    oracle = rows.T @ np.linalg.inv(rows @ rows.T + np.diag(np.tile(noise**2, samples)))
    rng = np.random.default_rng(5)
    z = rng.standard_normal((2000, 8))
    x = z @ rows.T + np.tile(noise, samples) * rng.standard_normal((2000, len(rows)))
    error, least = (np.sqrt(np.mean((x @ weights.T - z) ** 2)) for weights in (W, oracle))
    assert least < error < 1.15 * least
