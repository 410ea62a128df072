"""Training: what it depends on and what not, its schedules, and how it stops when it diverges."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from fe_models.recordings import Dataset, Recording
from hybrid.config import Config, TrainingConfig, paper_preset
from hybrid.estimation.experts import fe_counterpart
from hybrid.estimation.forecast import forecast_windows
from hybrid.estimation.windows import cut_all, window_length
from hybrid.training.config import GRADIENT
from hybrid.training.elbo import Elbo, kl_to_standard_normal, negative_elbo
from hybrid.training.gradient_training import Trainer, TrainingDivergedError, horizon_of, learning_rate_of
from hybrid.training.scoring import nrmse
from tests.hybrid_problems import (
    HELD_OUT,
    MEASURED,
    TINY,
    chain_dataset,
    cubic_dataset,
    learned,
    same,
    trained,
    trainer_of,
    with_column,
)


@pytest.fixture(scope="module")
def dataset() -> Dataset:
    return chain_dataset()


@pytest.fixture(scope="module")
def usual(dataset: Dataset) -> Trainer:
    return trained(dataset)


def unseen(dataset: Dataset) -> np.ndarray:
    return cut_all(dataset.select("test"), window_length(dataset, TINY), TINY.training.stride)


def mean_error(trainer: Trainer, windows: np.ndarray) -> float:
    return float(nrmse(forecast_windows(trainer.model, windows).channels, windows).mean())


def std_of(trainer: Trainer) -> torch.Tensor:
    """The likelihood's standard deviation (window, 1, measured)."""
    assert isinstance(trainer.objective, Elbo)
    return trainer.objective.std


def test_the_same_seed_gives_the_same_bits(dataset: Dataset, usual: Trainer) -> None:
    assert same(learned(trained(dataset).model), learned(usual.model))


def test_another_seed_gives_another_model(dataset: Dataset, usual: Trainer) -> None:
    other = trained(dataset, replace(TINY, training=replace(TINY.training, seed=1)))
    assert not same(learned(other.model), learned(usual.model))


def test_the_callers_random_numbers_stay_as_they_are(dataset: Dataset) -> None:
    torch.manual_seed(11)
    expected = torch.rand(3)
    torch.manual_seed(11)
    trained(dataset, replace(TINY, training=replace(TINY.training, epochs=1)))
    assert torch.equal(torch.rand(3), expected)


def test_held_out_channels_never_influence_training(dataset: Dataset, usual: Trainer) -> None:
    changed = with_column(dataset, "train", HELD_OUT, 1e6)
    assert same(learned(trained(changed).model), learned(usual.model))


def test_measured_channels_do(dataset: Dataset, usual: Trainer) -> None:
    changed = with_column(dataset, "train", MEASURED[0], 1.0)
    assert not same(learned(trained(changed).model), learned(usual.model))


def test_test_recordings_never_influence_training(dataset: Dataset, usual: Trainer) -> None:
    noise = np.random.default_rng(0).standard_normal((3, 100, 5)) * 1e3
    others = (*dataset.select("train"), Recording("noise", noise, "test"))
    assert same(learned(trained(replace(dataset, recordings=others)).model), learned(usual.model))


def test_the_hybrid_learns_a_linear_truth(dataset: Dataset, usual: Trainer) -> None:
    """Frequencies up to 18 % off: the FE model fails, the hybrid forecasts within a few times the noise of 2 %."""
    windows = unseen(dataset)
    fe = forecast_windows(usual.model, windows, fe_counterpart(usual.model)).channels
    assert nrmse(fe, windows).mean() > 0.1
    assert mean_error(usual, windows) < 0.02


@pytest.mark.slow
def test_training_learns_what_a_linear_model_cannot() -> None:
    """A cubic spring: training lowers both the bound and the error on recordings it never saw, by a quarter or more."""
    dataset = cubic_dataset()
    training = replace(TINY.training, epochs=40, learning_rate=1e-2)
    config = Config(replace(TINY.model, net_hidden=16), training)
    start, end = trainer_of(dataset, config), trained(dataset, config)
    losses = [
        negative_elbo(t.model, t.windows, std_of(t), 80, 1.0, torch.Generator().manual_seed(0)).mean().item()
        for t in (start, end)
    ]
    assert losses[1] < losses[0]
    errors = [mean_error(t, unseen(dataset)) for t in (start, end)]
    assert errors[1] < 0.75 * errors[0], errors


@pytest.mark.parametrize("factor", [1024.0, 1e-3])
def test_units_do_not_matter(dataset: Dataset, usual: Trainer, factor: float) -> None:
    """Normalised or physical: all scales are relative, so only rounding differs.

    A factor that is a power of two shifts exponents and no digit, but the logarithms of the encoder's variance round
    differently, 1e-7 each. Twenty steps of Adam, which follow the sign of the smallest gradients, amplify that to 1e-4.
    """
    parts = tuple(replace(each, data=factor * each.data) for each in dataset.recordings)
    scaled = replace(dataset, recordings=parts)
    windows = unseen(dataset)
    assert mean_error(trained(scaled), factor * windows) == pytest.approx(mean_error(usual, windows), rel=1e-3)


def test_the_bound_is_of_measured_channels_up_to_the_horizon(dataset: Dataset) -> None:
    """By hand, from the model's own parts, with the draw of z0 repeated; 1e-5 is float32 summed 80 x 4 times."""
    trainer = trainer_of(dataset)
    model, windows, std = trainer.model, trainer.windows[:3], std_of(trainer)[:3]
    with torch.no_grad():
        found = negative_elbo(model, windows, std, 30, 0.5, torch.Generator().manual_seed(2))
        mean, log_variance = model.encode(windows)
        noise = torch.randn(mean.shape, generator=torch.Generator().manual_seed(2))
        decoded = model.forecast(mean + noise * torch.exp(log_variance / 2), 30).channels
        x, y = windows[:, :30, MEASURED], decoded[:, :, MEASURED]
        fit = torch.distributions.Normal(y, std.expand_as(y)).log_prob(x).sum(dim=(1, 2))
        expected = 0.5 * kl_to_standard_normal(mean, log_variance) - fit
    assert torch.allclose(found, expected, rtol=1e-5)


def test_noise_is_relative_to_each_window_and_channel(dataset: Dataset) -> None:
    """10 % of a channel's rms in that window, and never less than 5 % of that of its rms over all windows."""
    trainer = trainer_of(dataset)
    data = trainer.windows[:, :, MEASURED]
    own = data.square().mean(dim=1).sqrt()
    overall = data.square().mean(dim=(0, 1)).sqrt()
    assert torch.allclose(std_of(trainer)[:, 0], TINY.training.noise_std * (own + 0.05 * overall))


def test_the_horizon_grows_to_the_whole_window_by_half_of_the_epochs() -> None:
    config = TrainingConfig(epochs=20, first_horizon=100)
    horizons = [horizon_of(config, epoch, 400) for epoch in range(1, 21)]
    assert horizons[0] == 100
    assert horizons[5] == 200  # a quarter of the epochs: the geometric mean
    assert horizons[10:] == [400] * 10
    assert horizons == sorted(horizons)
    assert horizons[9] < 400
    assert horizon_of(TrainingConfig(epochs=1, first_horizon=100), 1, 60) == 60  # never past the window


def test_the_learning_rate_follows_a_cosine() -> None:
    config = TrainingConfig(epochs=21, learning_rate=0.01)
    rates = [learning_rate_of(config, epoch) for epoch in range(1, 22)]
    assert rates[0] == pytest.approx(0.01)
    # halfway: the mean of first and last
    assert rates[10] == pytest.approx(0.01 * (1 + GRADIENT.last_learning_rate_share) / 2)
    assert rates[-1] == pytest.approx(0.01 * GRADIENT.last_learning_rate_share)
    assert rates == sorted(rates, reverse=True)
    assert learning_rate_of(TrainingConfig(epochs=1, learning_rate=0.01), 1) == pytest.approx(0.01)


def test_schedules_are_what_the_optimiser_and_the_epochs_do(usual: Trainer) -> None:
    last = learning_rate_of(TINY.training, TINY.training.epochs)
    assert [group["lr"] for group in usual.optimiser.param_groups] == [pytest.approx(last)]
    assert usual.done == TINY.training.epochs
    assert list(usual.epochs()) == []


def test_an_epoch_shuffles_every_window_once(usual: Trainer) -> None:
    first, second = usual.batches(1), usual.batches(2)
    for batches in (first, second):
        assert sorted(np.concatenate(batches).tolist()) == list(range(len(usual.windows)))
        assert all(8 <= len(batch) < 16 for batch in batches)  # of 8, the remainder shared out
    assert not np.array_equal(np.concatenate(first), np.concatenate(second))


def test_divergence_says_what_to_change_and_spares_the_model(dataset: Dataset) -> None:
    trainer = trainer_of(dataset, replace(TINY, training=replace(TINY.training, batch=1000)))
    before = learned(trainer.model)
    trainer.windows[0, 5, MEASURED[0]] = float("inf")
    with pytest.raises(TrainingDivergedError, match=r"epoch 1 .*1\.0e-03.*20 samples.*smaller --learning-rate"):
        list(trainer.epochs())
    assert same(learned(trainer.model), before)
    assert trainer.done == 0


def test_a_learning_rate_far_too_high_is_a_divergence(dataset: Dataset) -> None:
    with pytest.raises(TrainingDivergedError):
        trained(dataset, replace(TINY, training=replace(TINY.training, learning_rate=1e4)))


def test_the_paper_trains_without_calibration_from_a_free_net() -> None:
    """Sizes of Lai et al. 2022: MLP 2 x 128, RNN of 32 units for the chain and 128 for the bridge, n_t = 10."""
    chain, bridge = paper_preset("four_dof"), paper_preset("bridge")
    assert (chain.model.modes, chain.model.rnn_hidden, chain.training.window) == (4, 32, 501)
    assert (bridge.model.modes, bridge.model.rnn_hidden, bridge.training.window) == (10, 128, 500)
    for config in (chain, bridge):
        assert (config.model.encoder, config.model.encoder_hidden, config.model.net_hidden) == ("paper", 128, 128)
        assert (config.model.encoder_samples, config.model.integrator, config.training.batch) == (10, "rk4", 16)
        assert not config.training.calibrate
        assert not config.model.zero_at_rest


def test_the_papers_configuration_learns(dataset: Dataset) -> None:
    """With all its parts, in a small size; an epoch costs seconds, so that the loss need only fall."""
    paper = paper_preset("four_dof")
    small = Config(
        replace(paper.model, net_hidden=8, encoder_hidden=8, rnn_hidden=8),
        replace(paper.training, window=40, epochs=3, batch=8, learning_rate=1e-2, first_horizon=40, threads=1),
    )
    trainer = trainer_of(dataset, small)
    losses = [result.loss for result in trainer.epochs()]
    assert losses == sorted(losses, reverse=True)
