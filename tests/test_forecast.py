"""Forecasts: what they depend on, the FE counterpart against modal superposition, motion from a state of one's own."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
import torch

from fe_models.arrays import FloatArray
from fe_models.recordings import Dataset
from hybrid.estimation.config import UNCERTAINTY
from hybrid.estimation.experts import fe_counterpart
from hybrid.estimation.forecast import forecast_windows, generate
from hybrid.estimation.windows import cut_all
from hybrid.neural_modal_ode.model import NeuralModalODE
from hybrid.neural_modal_ode.residuals.free_residual import FreeResidual, NoResidual
from hybrid.training.scoring import nrmse
from tests.hybrid_problems import (
    HELD_OUT,
    SENSORS,
    STEP,
    TINY,
    chain_dataset,
    chain_modes,
    channels,
    decay,
    double_precision,
    last_layer,
    learned,
    same,
    starting_model,
)

SEEN = TINY.model.encoder_samples
Q, Q_DOT = np.array([0.5, -0.2, 0.1, 0.05]), np.array([0.1, 0.3, -0.2, 0.4])


@pytest.fixture(autouse=True, scope="module")
def _double() -> Iterator[None]:
    with double_precision():
        yield


@pytest.fixture(scope="module")
def dataset() -> Dataset:
    return chain_dataset(noise=0.0)


@pytest.fixture(scope="module")
def windows(dataset: Dataset) -> FloatArray:
    return cut_all(dataset.select("test"), 80, 10)


@pytest.fixture
def model(dataset: Dataset) -> NeuralModalODE:
    """Calibrated, and with a network that does something."""
    model = starting_model(dataset)
    with torch.no_grad():
        last_layer(model.dynamics).weight.normal_(std=0.02, generator=torch.Generator().manual_seed(0))
    return model


def test_samples_after_those_of_the_encoder_are_never_seen(model: NeuralModalODE, windows: FloatArray) -> None:
    before = forecast_windows(model, windows).channels
    changed = windows.copy()
    changed[:, SEEN:] = 1e6
    np.testing.assert_array_equal(forecast_windows(model, changed).channels, before)
    changed[:, SEEN - 1] += 0.1
    assert not np.allclose(forecast_windows(model, changed).channels, before)


def test_held_out_sensors_are_never_seen(model: NeuralModalODE, windows: FloatArray) -> None:
    changed = windows.copy()
    changed[:, :, HELD_OUT] = 1e6
    np.testing.assert_array_equal(forecast_windows(model, changed).channels, forecast_windows(model, windows).channels)


def test_a_forecast_may_go_on_past_its_window(model: NeuralModalODE, windows: FloatArray) -> None:
    longer = forecast_windows(model, windows[:, :SEEN], samples=80)
    np.testing.assert_array_equal(longer.channels, forecast_windows(model, windows).channels)


def test_windows_are_forecast_independently(model: NeuralModalODE, windows: FloatArray) -> None:
    """More of them than one batch holds, in the same order; 1e-12: one product of matrices, or several."""
    many = np.concatenate([windows] * (UNCERTAINTY.windows_per_batch // len(windows) + 2))
    together = forecast_windows(model, many).channels
    assert together.shape == many.shape
    alone = [forecast_windows(model, window[None]).channels[0] for window in many[-3:]]
    np.testing.assert_allclose(together[-3:], alone, rtol=0, atol=1e-12)


def test_the_fe_counterpart_is_modal_superposition(model: NeuralModalODE, windows: FloatArray) -> None:
    """From the state that the hybrid encodes, with the nominal frequencies and damping; 1e-12 is rounding."""
    with torch.no_grad():
        mean, _ = model.encode(torch.tensor(windows))
    q, q_dot = (part.numpy() for part in model.dynamics.unscale(mean))
    exact = decay(chain_modes(), q, q_dot, STEP, 80)
    found = forecast_windows(model, windows, fe_counterpart(model))
    for name in ("q", "q_dot", "q_ddot"):
        np.testing.assert_allclose(getattr(found, name), getattr(exact, name), rtol=0, atol=1e-12)
    np.testing.assert_allclose(found.channels, channels(chain_modes(), exact, SENSORS), rtol=0, atol=1e-12)


@pytest.mark.parametrize("ratio", [0.02, (0.01, 0.02, 0.03, 0.04)])
def test_the_fe_counterpart_has_the_damping_that_the_dataset_assumes(
    ratio: float | tuple[float, ...], dataset: Dataset
) -> None:
    assumed = replace(dataset, assumptions=replace(dataset.assumptions, damping_ratio=ratio))
    exact = decay(chain_modes(np.broadcast_to(ratio, 4)), Q[None], Q_DOT[None], STEP, 50)
    found = generate(fe_counterpart(starting_model(assumed)), Q, Q_DOT, 50)
    np.testing.assert_allclose(found.q, exact.q, rtol=0, atol=1e-12)


def test_the_fe_counterpart_leaves_the_model_alone(model: NeuralModalODE) -> None:
    before = learned(model)
    fe = fe_counterpart(model)
    assert same(learned(model), before)
    assert isinstance(fe.dynamics.residual, NoResidual)
    assert isinstance(model.dynamics.residual, FreeResidual)
    assert float(model.dynamics.residual.rest.weight.detach().abs().max()) > 0.0


def test_the_fe_counterpart_is_exact_in_time_whatever_the_model_uses(model: NeuralModalODE) -> None:
    """rk4 with one step a sample would be off by 1e-2 at six samples a period."""
    model.config = type(model.config)(**{**vars(model.config), "integrator": "rk4"})
    exact = decay(chain_modes(), Q[None], Q_DOT[None], STEP, 50)
    np.testing.assert_allclose(generate(fe_counterpart(model), Q, Q_DOT, 50).q, exact.q, rtol=0, atol=1e-12)


def test_motion_from_a_state_of_ones_own(model: NeuralModalODE) -> None:
    """It starts there, and the FE model's is the closed form."""
    motion = generate(model, Q, Q_DOT, 30)
    np.testing.assert_allclose(motion.q[0, 0], Q, rtol=1e-14)
    np.testing.assert_allclose(motion.q_dot[0, 0], Q_DOT, rtol=1e-14)
    assert motion.channels.shape == (1, 30, len(SENSORS))
    exact = decay(chain_modes(), Q[None], Q_DOT[None], STEP, 30)
    found = generate(fe_counterpart(model), Q, Q_DOT, 30)
    np.testing.assert_allclose(found.channels, channels(chain_modes(), exact, SENSORS), rtol=0, atol=1e-12)


def test_at_rest_it_stays(model: NeuralModalODE) -> None:
    """But for rounding, as NN(z) and NN(0) are not evaluated in one product."""
    assert np.abs(generate(model, np.zeros(4), np.zeros(4), 40).channels).max() < 1e-16


def test_the_calibrated_start_forecasts_a_linear_truth(dataset: Dataset, windows: FloatArray) -> None:
    """Without noise, channels never fitted included; 1 % is left, as the estimator shrinks states of 10 samples."""
    start = starting_model(dataset)
    assert nrmse(forecast_windows(start, windows).channels, windows).max() < 0.01
