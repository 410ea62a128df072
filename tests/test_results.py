"""What a run leaves in its folder: scores of the whole field, the FE model's own start, the loop, and stale files."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch

from fe_models.arrays import FloatArray
from fe_models.built_in.four_dof import four_dof
from fe_models.dof_map import DofMap
from fe_models.dofs import structure_dofs
from fe_models.errors import InputError
from fe_models.files.result_list import LIST_FILE
from fe_models.files.run_folder import load_run
from fe_models.linear import ModalModel
from fe_models.recordings import Dataset, Recording, Sensor
from hybrid.config import Config
from hybrid.estimation.forecast import Forecast
from hybrid.estimation.uncertainty import BandedForecast
from hybrid.training import results
from hybrid.training.forecast_comparison import Comparison, compare, field_scores
from hybrid.training.gradient_training import TrainingDivergedError
from hybrid.training.origin import Origin
from hybrid.training.results import fe_initial_state, prediction_of, write_results
from hybrid.training.run import CHECKPOINT, PARTIAL_CHECKPOINT, Run, begin, resume
from tests.blank_sheets import blank_sheets
from tests.hybrid_problems import (
    SENSORS,
    STEP,
    STIFFNESS,
    TINY,
    chain_dataset,
    chain_modes,
    channels,
    decay,
    starting_model,
)
from tests.test_render_shapes import portal

ONE_EPOCH = Config(TINY.model, replace(TINY.training, epochs=1))
CURVES = {"channels.png", "latent.png", "displacement.png", "force_displacement.png"}


@pytest.fixture(scope="module")
def dataset() -> Dataset:
    return chain_dataset()


def finished(dataset: Dataset, folder: Path, truth: FloatArray | None = None) -> Run:
    run = begin(dataset, ONE_EPOCH, folder)
    list(run.epochs())
    write_results(run, dataset, truth)
    return run


def origin_of(modal: ModalModel, sensors: tuple[Sensor, ...] = SENSORS) -> Origin:
    return Origin(None, modal, sensors, 1 / STEP, (), (), None, "")


def forecast_of(q: FloatArray) -> Forecast:
    """A forecast of one window with the modal coordinates (time, mode) and nothing else."""
    return Forecast(q[None], 0 * q[None], 0 * q[None], np.zeros((1, len(q), 1)))


def banded(forecast: Forecast) -> BandedForecast:
    return BandedForecast(forecast, np.zeros_like(forecast.channels))


def test_field_scores_are_relative_errors_of_the_translations() -> None:
    """Three times the right field is off by 2, half of it by 0.5; rotations, in rad, do not count."""
    dofs = structure_dofs(portal())
    rng = np.random.default_rng(0)
    shapes = rng.standard_normal((len(dofs), 2))
    q = rng.standard_normal((30, 2))
    truth = q @ shapes.T
    truth[:, dofs.direction == "rz"] *= 1e6
    modal = ModalModel(np.array([1.0, 2.0]), np.zeros(2), shapes, dofs)
    comparison = Comparison(np.zeros((1, 30, 1)), forecast_of(0.5 * q), banded(forecast_of(3 * q)))
    assert field_scores(comparison, modal, truth[None]) == pytest.approx({"hybrid": 2.0, "fe": 0.5}, rel=1e-12)


def test_a_floor_that_moves_up_and_down_is_shown_and_scored() -> None:
    """Node 1 hardly moves, in x; node 2 does, in z, and turns far more about y."""
    directions = np.array(["x", "y", "z", "ry"] * 2)
    dofs = DofMap(np.repeat([1, 2], 4), directions, np.ones(8, dtype=bool))
    shapes = np.array([[1e-3, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 50.0]]).T
    modal = ModalModel(np.array([1.0]), np.zeros(1), shapes, dofs)
    q = np.random.default_rng(0).standard_normal((30, 1))
    assert results._most_moved_translation(modal, q @ shapes.T) == 6
    truth = q @ shapes.T
    truth[:, 6] *= 2.0
    comparison = Comparison(np.zeros((1, 30, 1)), forecast_of(q), banded(forecast_of(2 * q)))
    found = field_scores(comparison, modal, truth[None])
    assert found == pytest.approx({"hybrid": 0.0, "fe": 0.5}, abs=1e-3)  # the share of x, which is not doubled


def test_all_windows_whose_truth_is_known_count_for_the_field() -> None:
    """The first of two known windows is right, the second twice what it should be; the third has no known truth."""
    modal = chain_modes()
    q = np.random.default_rng(0).standard_normal((3, 30, 4))
    forecast = Forecast(q * np.array([1.0, 2.0, 9.0])[:, None, None], 0 * q, 0 * q, np.zeros((3, 30, 1)))
    truth = q[:2] @ modal.shapes.T
    scores = field_scores(Comparison(np.zeros((3, 30, 1)), forecast, banded(forecast)), modal, truth)
    expected = np.sqrt(np.sum(truth[1] ** 2) / np.sum(truth**2))
    assert scores == pytest.approx({"hybrid": expected, "fe": expected}, rel=1e-12)


def test_the_fe_model_alone_finds_the_start_of_its_own_motion() -> None:
    """From 20 clean samples of four channels; 1e-2 of the largest is what the ridge of 1e-4 leaves of mode 1.

    The held-out channel is spoilt on purpose, and so is all that comes after those samples: neither is looked at.
    """
    modal = chain_modes()
    q, q_dot = np.random.default_rng(3).standard_normal((2, 1, 4))
    window = channels(modal, decay(modal, q, q_dot, STEP, 40), SENSORS)[0]
    window[:, 2] = 1e3
    window[20:] = -1e3
    found = fe_initial_state(origin_of(modal), window, 20)
    np.testing.assert_allclose(found, q[0], rtol=0, atol=1e-2 * np.abs(q).max())


def test_the_start_of_the_fe_model_is_that_of_least_squares() -> None:
    """On noise, by a dense solve of the same ridge regression in z = [omega q, q'], from closed-form columns."""
    modal, samples = chain_modes(), 10
    window = np.random.default_rng(1).standard_normal((samples, 5))
    unit = np.eye(8)
    starts = decay(modal, unit[:, :4] / modal.omega, unit[:, 4:], STEP, samples)
    X = np.delete(channels(modal, starts, SENSORS), 2, axis=2).reshape(8, -1).T  # (time * sensor, state)
    normal = X.T @ X
    normal += 1e-4 * np.trace(normal) / 8 * np.eye(8)
    z = np.linalg.solve(normal, X.T @ np.delete(window, 2, axis=1).ravel())
    found = fe_initial_state(origin_of(modal), window, samples)
    np.testing.assert_allclose(found, z[:4] / modal.omega, rtol=1e-8)


def test_a_prediction_is_the_first_window_at_all_nodes() -> None:
    """Named in metres, unless a normalised channel leaves its size unknown."""
    modal, q = chain_modes(), np.random.default_rng(0).standard_normal((7, 4))
    prediction = prediction_of(forecast_of(q), forecast_of(2 * q), origin_of(modal), np.arange(4.0))
    np.testing.assert_array_equal(prediction.time, STEP * np.arange(7))
    np.testing.assert_allclose(prediction.hybrid, q @ modal.shapes.T, rtol=1e-12)
    np.testing.assert_allclose(prediction.fe, 2 * prediction.hybrid, rtol=1e-12)
    np.testing.assert_allclose(prediction.fe_initial, modal.shapes @ np.arange(4.0), rtol=1e-12)
    assert prediction.truth is None
    assert prediction.unit == "m"
    normalised = (*SENSORS[:4], replace(SENSORS[4], unit="1"))
    relative = prediction_of(forecast_of(q), forecast_of(q), origin_of(modal, normalised), np.zeros(4))
    assert relative.unit == "1"


@pytest.mark.slow
@blank_sheets()
def test_a_known_truth_is_scored_and_kept(dataset: Dataset, tmp_path: Path) -> None:
    """In all windows of the first realisation, the only one whose truth is known; the first window is kept."""
    run = finished(dataset, tmp_path)
    assert "field" not in json.loads((tmp_path / "metrics.json").read_text())
    truth = np.random.default_rng(5).standard_normal((dataset.select("test")[0].data.shape[1], 4))
    write_results(run, dataset, truth)
    length, stride = run.trainer.windows.shape[1], ONE_EPOCH.training.stride
    kept = load_run(tmp_path).prediction
    assert kept is not None
    np.testing.assert_array_equal(kept.truth, truth[:length])
    comparison = compare(run.trainer.model, dataset, length, stride)
    assert comparison is not None
    starts = range(0, len(truth) - length + 1, stride)
    assert len(starts) > 1
    known = np.array([truth[start : start + length] for start in starts])
    errors = comparison.hybrid.forecast.q[: len(starts)] @ run.origin.modal.shapes.T - known
    field = json.loads((tmp_path / "metrics.json").read_text())["field"]
    assert field["hybrid"] == pytest.approx(np.sqrt(np.mean(errors**2) / np.mean(known**2)), rel=1e-12)


@blank_sheets()
def test_without_test_recordings_nothing_is_scored(dataset: Dataset, tmp_path: Path) -> None:
    finished(replace(dataset, recordings=dataset.select("train")), tmp_path)
    metrics = json.loads((tmp_path / "metrics.json").read_text())
    assert metrics["scores"] is None
    assert metrics["test"] is None
    assert metrics["training"]["epochs"] == 1
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {CHECKPOINT, "metrics.json", "model.npz", "training.png", LIST_FILE}
    assert load_run(tmp_path).prediction is None


@pytest.mark.slow
@blank_sheets()
def test_no_older_prediction_is_left_beside_a_model_without_one(dataset: Dataset, tmp_path: Path) -> None:
    """It would be drawn, and belongs to another model."""
    finished(dataset, tmp_path)
    assert {path.name for path in tmp_path.iterdir()} >= {"prediction.npz", *CURVES}
    finished(replace(dataset, recordings=dataset.select("train")), tmp_path)
    assert not {path.name for path in tmp_path.iterdir()} & {"prediction.npz", *CURVES}


def another(dataset: Dataset, folder: Path) -> Run:
    """A trained run with another seed than `finished`, its results not yet written."""
    run = begin(dataset, Config(ONE_EPOCH.model, replace(ONE_EPOCH.training, seed=7)), folder)
    list(run.epochs())
    return run


def files(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir() if path.name != PARTIAL_CHECKPOINT}


@blank_sheets()
def test_a_disk_that_fills_leaves_all_older_results(
    dataset: Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No new scores beside an older prediction; and what was trained is gone on with."""

    def full(prediction: object, folder: Path) -> None:
        raise OSError(28, "No space left on device")

    finished(dataset, tmp_path)
    before = files(tmp_path)
    run = another(dataset, tmp_path)
    with monkeypatch.context() as patch, pytest.raises(InputError, match="No space left on device"):
        patch.setattr(results, "save_prediction", full)
        write_results(run, dataset)
    assert files(tmp_path) == before
    curves = write_results(resume(dataset, run.config, tmp_path), dataset).curves
    assert curves.keys() == {path.name for path in tmp_path.glob("*.png")} == {"training.png", *CURVES}
    assert files(tmp_path).keys() == before.keys()
    assert files(tmp_path)[CHECKPOINT] != before[CHECKPOINT]


@pytest.mark.slow
@blank_sheets()
def test_a_curve_that_fails_loses_neither_model_nor_scores(
    dataset: Dataset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They are the new run's, no curve of the older one stands beside them, and the next run draws them."""

    def failing(*arguments: object) -> None:
        raise ZeroDivisionError

    finished(dataset, tmp_path)
    before = files(tmp_path)
    run = another(dataset, tmp_path)
    with monkeypatch.context() as patch, pytest.raises(ZeroDivisionError) as caught:
        patch.setattr(results, "draw_latent", failing)
        write_results(run, dataset)
    assert "those written before are whole (checkpoint.pt, metrics.json, model.npz, prediction.npz)" in str(
        caught.value.__notes__
    )
    left = files(tmp_path)
    assert left.keys() == {CHECKPOINT, "metrics.json", "model.npz", "prediction.npz", LIST_FILE}
    assert all(left[name] != before[name] for name in (CHECKPOINT, "metrics.json", "prediction.npz"))
    write_results(resume(dataset, run.config, tmp_path), dataset)
    assert files(tmp_path).keys() == before.keys()
    assert files(tmp_path)["prediction.npz"] == left["prediction.npz"]


def test_comparison_starts_both_models_at_the_same_state(dataset: Dataset) -> None:
    """From where the FE model decays as the nominal chain, though the hybrid is calibrated; 1e-4: float32, of three."""
    comparison = compare(starting_model(dataset), dataset, 80, 20)
    assert comparison is not None
    hybrid = comparison.hybrid.forecast
    assert comparison.windows.shape == hybrid.channels.shape == comparison.fe.channels.shape == (6, 80, 5)
    np.testing.assert_array_equal(hybrid.q[:, 0], comparison.fe.q[:, 0])
    np.testing.assert_array_equal(hybrid.q_dot[:, 0], comparison.fe.q_dot[:, 0])
    motion = decay(chain_modes(), comparison.fe.q[:, 0], comparison.fe.q_dot[:, 0], STEP, 80)
    np.testing.assert_allclose(comparison.fe.q, motion.q, rtol=0, atol=1e-4)
    np.testing.assert_allclose(comparison.fe.channels, channels(chain_modes(), motion, SENSORS), rtol=0, atol=1e-4)
    assert np.abs(hybrid.q - comparison.fe.q).max() > 0.5


def test_forecasts_that_grow_beyond_bounds_are_not_scored(dataset: Dataset) -> None:
    model = starting_model(dataset)
    with torch.no_grad():
        for parameter in model.dynamics.residual.parameters():
            parameter.fill_(1e3)
    with pytest.raises(TrainingDivergedError, match="beyond all bounds"):
        compare(model, dataset, 80, 20)


def test_the_loop_of_the_fe_model_is_the_force_of_its_springs_and_dampers(
    dataset: Dataset, monkeypatch: pytest.MonkeyPatch
) -> None:
    """-m1 a1 = (K u + C v)_1, C = M Phi diag(2 xi omega) Phi^T M, by the chain's own matrices; the measured one beside.

    1e-5 of a force near three: float32.
    """
    sensors = (Sensor("x1", 1, "x", "displacement", "m"), *SENSORS[1:])
    own = replace(dataset, sensors=sensors, recordings=(Recording("r", dataset.recordings[0].data, "test"),))
    modal = chain_modes()
    motion = decay(modal, np.ones((1, 4)) / modal.omega, np.ones((1, 4)), STEP, 50)
    forecast = Forecast(motion.q, motion.q_dot, motion.q_ddot, channels(modal, motion, sensors))
    window = own.recordings[0].data[:1, :50]
    drawn: dict[str, dict[str, FloatArray]] = {}

    def kept(displacement: dict[str, FloatArray], force: dict[str, FloatArray], node: int) -> None:
        drawn.update(displacement=displacement, force=force)
        assert node == 1

    monkeypatch.setattr(results, "draw_loop", kept)
    results._draw_loop(own, four_dof(), modal, Comparison(window, forecast, banded(forecast)))
    mass = np.diag([1.0, 2.0, 3.0, 4.0])
    damping = mass @ modal.shapes @ np.diag(0.02 * modal.omega) @ modal.shapes.T @ mass
    u, v = motion.q[0] @ modal.shapes.T, motion.q_dot[0] @ modal.shapes.T
    np.testing.assert_allclose(drawn["force"]["FE model"], u @ STIFFNESS[0] + v @ damping[0], rtol=0, atol=1e-11)
    np.testing.assert_allclose(drawn["displacement"]["hybrid"], u[:, 0], rtol=0, atol=1e-12)
    np.testing.assert_array_equal(drawn["displacement"]["measured"], window[0, :, 0])
    np.testing.assert_array_equal(drawn["force"]["measured"], -window[0, :, 1])
