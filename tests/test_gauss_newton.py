"""Gauss-Newton: springs, dashpots, laws and noise come back from data that models of the family made.

The linear chain's data are the matrix exponential's, the nonlinear ones those of a model with known laws, with twice as
many substeps. All training starts from a modal model that is 3 % off, in shapes and in frequencies.
"""

import shutil
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
import torch
from torch import Tensor

from fe_models.arrays import FloatArray
from fe_models.recordings import Dataset
from hybrid.config import TrainingConfig, places_preset
from hybrid.neural_modal_ode.model import NeuralModalODE
from hybrid.neural_modal_ode.residuals.connector_residual import ConnectorResidual
from hybrid.training.checkpoint import load_checkpoint
from hybrid.training.gauss_newton import GaussNewtonTrainer
from hybrid.training.gradient_training import EpochResult, Trainer, TrainingDivergedError
from hybrid.training.preparation import prepare
from hybrid.training.run import PARTIAL_CHECKPOINT, begin, resume
from hybrid.training.trainers import trainer_for
from tests.hybrid_problems import MEASURED, STEP, TINY, chain_dataset, chain_modes, double_precision, learned, same
from tests.places_problems import (
    free_motions,
    place_model,
    prior_of,
    random_states,
    residual_modes_of,
)
from tests.test_places import DASHPOTS, SPRINGS, crooked_modes

SAMPLES = 80
CONFIG = TrainingConfig(epochs=25, batch=25, first_horizon=20)
SENSOR_NOISE = np.array([0.01, 0.02, 0.01, 0.015, 0.01])  # of all sensors, in their units
PLACES = replace(places_preset(), training=replace(places_preset().training, window=80, epochs=4, batch=9))


@pytest.fixture(autouse=True, scope="module")
def _double() -> Iterator[None]:
    with double_precision():
        yield


@dataclass(frozen=True)
class Trained:
    """A trainer after its last epoch and what each epoch did."""

    trainer: GaussNewtonTrainer
    results: list[EpochResult]

    @property
    def residual(self) -> ConnectorResidual:
        return residual_modes_of(self.trainer.model)


def untrained(hidden: int, substeps: int = 2) -> NeuralModalODE:
    """The crooked chain with nets that are zero, a prior of ones, and a noise five times as large as the largest."""
    model = place_model(crooked_modes(), net=0.0, hidden=hidden, substeps=substeps)
    prior_of(model).noise_std.fill_(0.1)
    prior_of(model).precision.copy_(torch.eye(8))
    return model


def noisy(data: FloatArray, noise: float | FloatArray) -> FloatArray:
    return np.asarray(data + noise * np.random.default_rng(0).standard_normal(data.shape))


def train(model: NeuralModalODE, data: FloatArray, config: TrainingConfig = CONFIG) -> Trained:
    trainer = trainer_for(model, data, config)
    assert isinstance(trainer, GaussNewtonTrainer)
    return Trained(trainer, list(trainer.epochs()))


@pytest.fixture(scope="module")
def linear() -> Trained:
    """From springs a fifth and dashpots two thirds off, by sensors with a noise of 1e-3 on motions near one."""
    model = untrained(hidden=2)
    residual_modes_of(model).set_coefficients(torch.tensor(0.8 * SPRINGS + 0.1), torch.tensor(0.3 * DASHPOTS))
    return train(model, noisy(free_motions(25, SAMPLES, 0), 1e-3))


def true_model() -> NeuralModalODE:
    """The chain of the textbook with nets at all places, forces of a tenth to a half of the springs'."""
    return place_model(chain_modes(), net=0.05, hidden=2, substeps=4)


@pytest.fixture(scope="module")
def nonlinear() -> Trained:
    """Data of known laws, each sensor with its own noise; training knows the chain's springs but no law."""
    with torch.no_grad():
        data = true_model().forecast(random_states(25), SAMPLES).channels.numpy()
    return train(untrained(hidden=3), noisy(data, SENSOR_NOISE))


def forces(residual: ConnectorResidual, u: Tensor, v: Tensor) -> FloatArray:
    """All forces (place, n) at elongations and rates (place, n), of springs, dashpots and nets."""
    with torch.no_grad():
        k, c = residual.coefficients()
        return np.asarray(residual.laws(u, v) + k[:, None] * u + c[:, None] * v)


def test_springs_and_dashpots_are_found_to_three_digits(linear: Trained) -> None:
    """As secants over the motion's size: nets could hold a linear part, too.

    A noise of 1e-3 in 8000 numbers near one leaves some 1e-4 of a spring; a node that no sensor sees, tenfold.
    """
    residual = linear.residual
    u, v = (residual.sizes[i][:, None] for i in range(2))
    nothing = torch.zeros_like(u)
    k = (forces(residual, u, nothing) - forces(residual, -u, nothing))[:, 0] / (2 * u[:, 0].numpy())
    c = (forces(residual, nothing, v) - forces(residual, nothing, -v))[:, 0] / (2 * v[:, 0].numpy())
    np.testing.assert_allclose(k, SPRINGS, rtol=0, atol=2e-3)
    np.testing.assert_allclose(c, DASHPOTS, rtol=0, atol=1e-3)


@pytest.mark.parametrize("which", ["linear", "nonlinear"])
def test_the_noise_of_each_sensor_is_found(which: str, request: pytest.FixtureRequest) -> None:
    """2000 numbers a channel: their median tells the deviation to 1.17 / sqrt(2 2000) = 2 %; 10 %: and 8 of 80 are fit.

    The noise that the model takes is what it leaves: so the loss is half the number of channels a sample.
    """
    trained: Trained = request.getfixturevalue(which)
    expected = np.full(4, 1e-3) if which == "linear" else SENSOR_NOISE[MEASURED]
    np.testing.assert_allclose(trained.trainer.prior.noise_std.numpy(), expected, rtol=0.1)
    assert trained.results[-1].loss / SAMPLES == pytest.approx(2.0, rel=0.1)


def test_the_laws_come_back_where_they_were_put(nonlinear: Trained) -> None:
    """At rms elongations and rates of either sign, all places: to 3 % of the largest force, noise being 5 % of motion.

    The nets that found them have other sizes and other weights.
    """
    truth = residual_modes_of(true_model())
    for sign in (1.0, -1.0):
        u, v = (sign * truth.sizes[i][:, None] for i in range(2))
        nothing = torch.zeros_like(u)
        for given in ((u, nothing), (nothing, v)):
            expected, found = forces(truth, *given), forces(nonlinear.residual, *given)
            largest = np.abs(forces(truth, u, nothing)).max()
            np.testing.assert_allclose(found, expected, rtol=0, atol=0.03 * largest)
        beyond = forces(truth, u, nothing) - SPRINGS[:, None] * u.numpy()
        assert np.abs(beyond).max() > 0.1 * largest  # there was something to find


def test_motions_never_seen_are_simulated(nonlinear: Trained) -> None:
    """From true states in physical coordinates, 80 samples, held-out sensors as well: to 4 % of each channel's size."""
    model, fresh = nonlinear.trainer.model, random_states(20, seed=9)
    basis = torch.tensor(np.linalg.solve(crooked_modes().shapes, chain_modes().shapes)).T
    with torch.no_grad():
        truth = true_model().forecast(fresh, SAMPLES)
        found = model.forecast(model.scale_state(truth.q[:, 0] @ basis, truth.q_dot[:, 0] @ basis), SAMPLES)
    error = (found.channels - truth.channels).square().mean(dim=(0, 1)).sqrt()
    size = truth.channels.square().mean(dim=(0, 1)).sqrt()
    assert float((error / size).max()) < 0.04, error / size


@pytest.mark.parametrize("which", ["linear", "nonlinear"])
def test_it_converges_in_fewer_epochs_than_it_has(which: str, request: pytest.FixtureRequest) -> None:
    """In 15: six or so at the shortest horizon, and a few at each of the two that follow."""
    trained: Trained = request.getfixturevalue(which)
    assert trained.trainer.converged
    assert trained.trainer.finished
    assert len(trained.results) <= 15
    assert [result.epoch for result in trained.results] == list(range(1, len(trained.results) + 1))
    horizons = [result.horizon for result in trained.results]
    assert horizons == sorted(horizons)
    assert set(horizons) == {20, 40, 80}


def test_the_states_of_the_training_windows_are_found(nonlinear: Trained) -> None:
    """In physical coordinates, displacements and velocities of all masses; 0.05 rms is near the largest noise."""
    states = nonlinear.trainer.states
    assert states is not None
    model, truth = nonlinear.trainer.model, true_model()
    with torch.no_grad():
        found, expected = model.dynamics.unscale(states), truth.dynamics.unscale(random_states(25))
    for one, other in zip(found, expected, strict=True):
        error = one.numpy() @ crooked_modes().shapes.T - other.numpy() @ chain_modes().shapes.T
        assert np.sqrt((error**2).mean()) < 0.02


def test_outlying_windows_count_little() -> None:
    """Four windows among 25 of a structure that is a fifth faster: the springs stay, to 2 % of the stiffest."""
    data = noisy(free_motions(25, SAMPLES, 0), 1e-2)
    data[:4] = noisy(free_motions(4, SAMPLES, 1, 1.2 * STEP), 1e-2)
    model = untrained(hidden=2)
    residual_modes_of(model).set_coefficients(torch.tensor(0.9 * SPRINGS), torch.tensor(0.5 * DASHPOTS))
    residual = train(model, data).residual
    k, _ = residual.coefficients()
    u = residual.sizes[0][:, None]
    secant = (forces(residual, u, 0 * u) - forces(residual, -u, 0 * u))[:, 0] / (2 * u[:, 0].numpy())
    np.testing.assert_allclose(secant, SPRINGS, rtol=0, atol=0.02 * 4)
    assert bool(torch.isfinite(k).all())


def test_a_step_that_does_not_help_is_not_made(linear: Trained) -> None:
    """Once converged, another epoch loses nothing: the loss stays, to 1 %."""
    model = untrained(hidden=2)
    trainer = GaussNewtonTrainer(model, noisy(free_motions(25, SAMPLES, 0), 1e-3), CONFIG)
    residual_modes_of(model).table.data.copy_(linear.residual.table.data)
    prior_of(model).load_state_dict(linear.trainer.prior.state_dict())
    trainer.load_state(linear.trainer.state())
    before = trainer.residual.table.detach().clone()
    again = trainer.train_epoch(26)
    assert again.loss == pytest.approx(linear.results[-1].loss, rel=0.01)
    assert float((trainer.residual.table - before).detach().abs().max()) < 0.1


def test_a_quiet_start_reports_no_progress_beyond_its_epochs() -> None:
    trained = train(untrained(hidden=2), noisy(free_motions(9, 40, 0), 1e-2), replace(CONFIG, epochs=2))
    assert len(trained.results) == 2
    assert not trained.trainer.converged
    assert trained.trainer.finished


def test_the_windows_chosen_follow_the_seed() -> None:
    """As many as a batch holds, each once, in their order; the device is the one named."""
    data = noisy(free_motions(12, 40, 0), 1e-2)
    chosen = [trainer_for(untrained(2), data, replace(CONFIG, batch=5, seed=seed), device="cpu") for seed in (0, 0, 1)]
    parts = []
    for trainer in chosen:
        assert isinstance(trainer, GaussNewtonTrainer)
        assert trainer.windows.device == torch.device("cpu")
        assert all(value.device == torch.device("cpu") for value in trainer.model.state_dict().values())
        parts.append(trainer.chosen)
    assert torch.equal(parts[0], parts[1])
    assert not torch.equal(parts[0], parts[2])
    numbers = [int(np.flatnonzero((data == window.numpy()).all(axis=(1, 2)))[0]) for window in parts[0]]
    assert len(set(numbers)) == 5
    assert numbers == sorted(numbers)


def test_the_same_data_give_the_same_bits() -> None:
    data = noisy(free_motions(8, 40, 0), 1e-2)
    one, other = (train(untrained(2), data, replace(CONFIG, epochs=3)) for _ in range(2))
    assert one.results == other.results
    assert same(one.trainer.model.state_dict(), other.trainer.model.state_dict())


def test_models_that_encode_their_states_are_trained_by_gradients() -> None:
    prepared = prepare(chain_dataset(), TINY)
    assert isinstance(trainer_for(prepared.model, prepared.windows, TINY.training), Trainer)
    with pytest.raises(TypeError, match="tied to places"):
        GaussNewtonTrainer(prepared.model, prepared.windows, TINY.training)


@pytest.fixture(scope="module")
def dataset() -> Dataset:
    return chain_dataset()


@pytest.fixture(scope="module")
def folders(dataset: Dataset, tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """What is on disk after each epoch of one uninterrupted training."""
    whole = tmp_path_factory.mktemp("whole")
    left = []
    for result in begin(dataset, PLACES, whole, device="cpu").epochs():
        left.append(tmp_path_factory.mktemp(f"after_{result.epoch}"))
        shutil.copy(whole / PARTIAL_CHECKPOINT, left[-1] / PARTIAL_CHECKPOINT)
    return left


@pytest.mark.parametrize("done", [1, 2, 3])
def test_resumed_after_any_epoch_it_ends_as_if_never_interrupted(
    done: int, folders: list[Path], dataset: Dataset, tmp_path: Path
) -> None:
    """Laws, noise, prior, states, horizon and damping, bit for bit."""
    folder = tmp_path / "run"
    shutil.copytree(folders[done - 1], folder)
    run = resume(dataset, PLACES, folder, device="cpu")
    assert [result.epoch for result in run.epochs()] == list(range(done + 1, len(folders) + 1))
    one, other = load_checkpoint(folder / PARTIAL_CHECKPOINT), load_checkpoint(folders[-1] / PARTIAL_CHECKPOINT)
    assert same(one.model.state_dict(), other.model.state_dict())
    assert one.history == other.history
    assert torch.equal(one.trainer["states"], other.trainer["states"])
    for name in ("horizon", "damping", "converged"):
        assert one.trainer[name] == other.trainer[name]


def test_a_training_that_has_converged_is_not_gone_on_with(linear: Trained) -> None:
    """Its state says so, however many epochs it has left."""
    trainer = GaussNewtonTrainer(untrained(2), free_motions(25, SAMPLES, 0), replace(CONFIG, epochs=1000))
    trainer.load_state(linear.trainer.state())
    assert list(trainer.epochs()) == []


def test_a_start_that_is_no_number_says_what_to_change() -> None:
    model = untrained(hidden=2)
    residual_modes_of(model).set_coefficients(torch.full((7,), float("nan")), torch.zeros(7))
    with pytest.raises(TrainingDivergedError, match=r"epoch 1 .*--fresh.*--first-horizon"):
        train(model, noisy(free_motions(8, 40, 0), 1e-2))


@pytest.mark.parametrize(
    "stiffness",
    [
        -1e5,
        -1e3,
    ],
)
def test_a_start_that_runs_away_says_what_to_change(stiffness: float) -> None:
    """Springs so negative that every motion but rest overflows, so that the search for states stays at rest."""
    model = untrained(hidden=2).float()
    residual_modes_of(model).set_coefficients(torch.full((7,), stiffness), torch.zeros(7))
    torch.set_default_dtype(torch.float32)
    try:
        with pytest.raises(TrainingDivergedError, match=r"--fresh.*--first-horizon"):
            train(model, noisy(free_motions(8, 40, 0), 1e-2))
    finally:
        torch.set_default_dtype(torch.float64)


def test_learned_numbers_are_one_table() -> None:
    """Springs, dashpots and nets: what is trained is what is saved."""
    assert list(learned(untrained(2))) == ["dynamics.residual.table"]
