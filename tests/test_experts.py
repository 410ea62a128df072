"""Experts: sharp where recordings are of slightly different structures, and what their mean has to keep."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
import torch

from fe_models.arrays import FloatArray
from fe_models.built_in.four_dof import four_dof
from fe_models.errors import InputError
from fe_models.recordings import Assumptions, Dataset, Recording
from hybrid.config import Config, paper_preset, places_preset
from hybrid.estimation.experts import Experts, fe_counterpart
from hybrid.estimation.forecast import forecast_windows, generate
from hybrid.neural_modal_ode.residuals.free_residual import FreeResidual, NoResidual
from hybrid.training.expert_preparation import prepare_experts
from hybrid.training.preparation import Prepared, prepare
from hybrid.training.scoring import nrmse
from tests.hybrid_problems import (
    HELD_OUT,
    MEASURED,
    SENSORS,
    STEP,
    TINY,
    chain_modes,
    double_precision,
    last_layer,
    off_chain,
    recorded,
)

EXPERTS = Config(replace(TINY.model, experts=True), TINY.training)
SHIFT = 1.1  # of all frequencies from one recording to the other: a radian after 80 samples of the slowest mode
NOISE = 0.01


@pytest.fixture(autouse=True)
def _double() -> Iterator[None]:
    with double_precision():
        yield


def two_days(noise: float = NOISE) -> Dataset:
    """Two training recordings of chains 10 % apart in frequency, and one of unseen decays of each."""
    one = off_chain()
    other = replace(one, omega=SHIFT * one.omega)
    recordings = (
        Recording("one", recorded(one, 20, 100, 1, noise)),
        Recording("other", recorded(other, 15, 100, 2, noise)),
        Recording("like one", recorded(one, 6, 80, 3, noise), "test"),
        Recording("like other", recorded(other, 6, 80, 4, noise), "test"),
    )
    return Dataset(four_dof(), 1 / STEP, SENSORS, recordings, assumptions=Assumptions(modal_model=chain_modes()))


@pytest.fixture(scope="module")
def dataset() -> Dataset:
    return two_days()


@pytest.fixture(scope="module")
def prepared(dataset: Dataset) -> Prepared[Experts]:
    with double_precision():
        return prepare_experts(dataset, EXPERTS)


@pytest.fixture(scope="module")
def windows(dataset: Dataset) -> FloatArray:
    return np.concatenate([recording.data for recording in dataset.select("test")])


def with_net(model: Experts) -> Experts:
    """The model with forces that are not linear, different in each member."""
    for member in model.members:
        with torch.no_grad():
            last_layer(member.dynamics).weight.normal_(std=0.02)
    return model


def test_a_window_is_recognised_by_its_start(prepared: Prepared[Experts], windows: FloatArray) -> None:
    """Six of each kind: ten noisy samples of four channels tell a shift of 10 %, every time."""
    weights = prepared.model.weights(torch.tensor(windows))
    assert torch.allclose(weights.sum(dim=1), torch.ones(12))
    assert weights.argmax(dim=1).tolist() == [0] * 6 + [1] * 6


def test_weights_read_the_first_samples_of_the_measured_channels_only(
    prepared: Prepared[Experts], windows: FloatArray
) -> None:
    spoilt = windows.copy()
    spoilt[:, 10:] = np.nan
    spoilt[:, :, HELD_OUT] = np.nan
    weights = prepared.model.weights(torch.tensor(windows))
    assert torch.equal(prepared.model.weights(torch.tensor(spoilt)), weights)
    for column in MEASURED:
        changed = windows.copy()
        changed[:, 9, column] += windows.std()
        assert not torch.allclose(prepared.model.weights(torch.tensor(changed)), weights, atol=1e-3)


def test_weights_do_not_depend_on_the_size_of_the_motion(prepared: Prepared[Experts], windows: FloatArray) -> None:
    weights = prepared.model.weights(torch.tensor(windows))
    assert torch.allclose(prepared.model.weights(torch.tensor(-1e-4 * windows)), weights, atol=1e-9)


def test_they_beat_one_model_of_both(dataset: Dataset, prepared: Prepared[Experts], windows: FloatArray) -> None:
    """Untrained, as calibrated: one model of both days is right about neither, and its phase is off by the end."""
    pooled = prepare(dataset, TINY).model
    errors = [nrmse(forecast_windows(model, windows).channels, windows).mean() for model in (prepared.model, pooled)]
    assert errors[0] < 0.4 * errors[1]


def test_each_member_is_what_its_recording_alone_gives(dataset: Dataset, prepared: Prepared[Experts]) -> None:
    for name, member, count in zip(
        ("one", "other"), prepared.model.members, prepared.model.counts.tolist(), strict=True
    ):
        only = tuple(recording for recording in dataset.recordings if recording.name == name)
        alone = prepare(replace(dataset, recordings=only), replace(TINY, training=replace(TINY.training, window=80)))
        assert len(alone.windows) == count
        for key, value in alone.model.state_dict().items():
            assert torch.equal(member.state_dict()[key], value), key
    assert prepared.kept == ("one", "other")


def test_the_forecast_is_the_weighted_mean_and_a_motion_of_its_own(
    prepared: Prepared[Experts], windows: FloatArray
) -> None:
    """Channels follow from the mean modal coordinates through the one decoder, as those of a single model do."""
    model = with_net(prepare_experts(two_days(), EXPERTS).model)
    weights = model.weights(torch.tensor(windows)).detach().numpy()
    parts = [forecast_windows(member, windows) for member in model.members]
    mean = forecast_windows(model, windows)
    for name in ("q", "q_dot", "q_ddot", "channels"):
        by_hand = sum(weights[:, i, None, None] * getattr(part, name) for i, part in enumerate(parts))
        np.testing.assert_allclose(getattr(mean, name), by_hand, rtol=0, atol=1e-12 * np.abs(by_hand).max())
    decoder = model.members[0].decoder
    decoded = decoder(*(torch.tensor(part) for part in (mean.q, mean.q_dot, mean.q_ddot))).numpy()
    np.testing.assert_allclose(mean.channels, decoded, rtol=0, atol=1e-12 * np.abs(decoded).max())


def test_the_fe_counterpart_starts_where_the_experts_do(prepared: Prepared[Experts], windows: FloatArray) -> None:
    """The FE model is linear: its mean forecast is the forecast from the mean state, which is the experts' own."""
    model = prepared.model
    fe_model = fe_counterpart(model)
    fe, hybrid = forecast_windows(model, windows, fe_model), forecast_windows(model, windows)
    np.testing.assert_allclose(fe.q[:, 0], hybrid.q[:, 0], rtol=0, atol=1e-12)
    np.testing.assert_allclose(fe.q_dot[:, 0], hybrid.q_dot[:, 0], rtol=0, atol=1e-12)
    again = generate(fe_counterpart(model.members[0]), fe.q[3, 0], fe.q_dot[3, 0], windows.shape[1])
    np.testing.assert_allclose(fe.q[3], again.q[0], rtol=0, atol=1e-11 * np.abs(again.q).max())
    assert all(isinstance(member.dynamics.residual, NoResidual) for member in fe_model.members)
    assert all(isinstance(member.dynamics.residual, FreeResidual) for member in model.members)


def test_a_users_own_state_is_nobodys_more_than_others(prepared: Prepared[Experts]) -> None:
    model = prepared.model
    q, q_dot = np.random.default_rng(0).standard_normal((2, 4))
    found = generate(model, q, q_dot, 40)
    parts = [generate(member, q, q_dot, 40) for member in model.members]
    np.testing.assert_allclose(found.q, (parts[0].q + parts[1].q) / 2, rtol=0, atol=1e-12 * np.abs(found.q).max())
    np.testing.assert_allclose(found.q[0, 0], q, rtol=1e-12)
    assert np.abs(parts[0].q - parts[1].q).max() > 0.1 * np.abs(q).max()


def test_a_recording_that_contradicts_the_others_gets_no_expert(dataset: Dataset) -> None:
    """Frequencies half as high again are of another structure: that recording is left out, as from one model of all."""
    one = off_chain()
    odd = Recording("odd", recorded(replace(one, omega=1.5 * one.omega), 10, 100, 5, NOISE))
    alike = Recording("third", recorded(one, 10, 100, 6, NOISE))
    prepared = prepare_experts(replace(dataset, recordings=(odd, dataset.recordings[0], alike)), EXPERTS)
    assert prepared.kept == ("one", "third")
    assert prepared.left_out == ("odd",)
    assert len(prepared.model.members) == 2


@pytest.mark.parametrize("preset", [places_preset(), paper_preset("four_dof")])
def test_what_experts_cannot_be_made_of_is_refused(preset: Config, dataset: Dataset) -> None:
    with pytest.raises(InputError, match="experts need an encoder that reads windows"):
        prepare_experts(dataset, replace(preset, model=replace(preset.model, experts=True)))
