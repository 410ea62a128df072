"""What a finished run leaves in its folder: scores, the predicted field, the model for the pictures, the curves."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch

from fe_models.arrays import FloatArray
from fe_models.files.atomic import write_json
from fe_models.files.run_folder import Prediction, save_prediction, save_run_model
from fe_models.linear import ModalModel
from fe_models.progress import nothing
from fe_models.recordings import Dataset
from fe_models.structure import TRANSLATIONS, Structure
from hybrid.estimation.experts import Experts
from hybrid.estimation.forecast import Forecast
from hybrid.estimation.linear_calibration import Observer, free_part, smooth
from hybrid.estimation.uncertainty import set_relative_error
from hybrid.estimation.windows import cut_field
from hybrid.figures import Sheet, Sheets, channel_labels, draw_channels, draw_curves, draw_latent, draw_loop
from hybrid.neural_modal_ode.driving import Driving
from hybrid.training.checkpoint import save_checkpoint
from hybrid.training.evaluation import score_table
from hybrid.training.expert_training import ExpertsTrainer
from hybrid.training.forecast_comparison import Comparison, band_scores, compare, field_scores, forecast_recordings
from hybrid.training.origin import Origin
from hybrid.training.run import CHECKPOINT, LOOP, METRICS, Run, results_in
from hybrid.training.sensing import sensed, sensing_scores
from hybrid.training.trainable import trainable
from hybrid.training.training_figure import draw_history

RESULT_STEPS = 4  # of `write_results`: forecasts, and three figures that take a while


@dataclass(frozen=True, eq=False)
class Results:
    """What a run came to: its ``metrics``, as plain data; the ``prediction`` of the first test window, None without
    any; and its ``curves``, as they are drawn.
    """

    metrics: dict[str, Any]
    prediction: Prediction | None
    curves: Sheets


def write_results(
    run: Run, dataset: Dataset, truth: FloatArray | None = None, advance: Callable[[], object] = nothing
) -> Results:
    """Score the run's model on the test recordings, write everything into its folder and return it.

    The checkpoint, its scores and its prediction replace the older results together; the curves follow.
    ``truth``: the true displacement (time, dof) of the first test recording, known where the data are simulated.
    ``advance`` is called `RESULT_STEPS` times at most, to show progress.
    """
    modal, training = run.origin.modal, run.config.training
    length = run.trainer.windows.shape[1]
    comparison, metrics = scored(run, dataset)
    advance()
    prediction = None
    if comparison is not None:
        if truth is not None:
            truth = cut_field(truth, forecast_recordings(dataset)[0], length, training.stride)
            metrics["field"] = field_scores(comparison, modal, truth)
        known = None if comparison.driving is None else comparison.driving[:1]
        initial = fe_initial_state(run.origin, comparison.windows[0], run.config.model.encoder_samples, known)
        first = None if truth is None else truth[0]
        prediction = prediction_of(comparison.hybrid.forecast, comparison.fe, run.origin, initial, first)
    results = results_in(run.folder)
    with results.replacing() as new:
        save_checkpoint(run.checkpoint(), new / CHECKPOINT)
        write_json(new / METRICS, metrics)
        save_run_model(dataset.model, modal, new)
        if prediction is not None:
            save_prediction(prediction, new)
    curves = dict[str, Sheet]()
    with results.adding() as new:
        drawn = _curves(run, dataset, comparison, prediction)
        for number, (name, sheet) in enumerate(drawn, start=2):  # the forecasts were the first step
            sheet.save(new / name)
            curves[name] = sheet
            if number <= RESULT_STEPS:
                advance()
    run.forget_state()
    return Results(metrics, prediction, curves)


def scored(run: Run, dataset: Dataset) -> tuple[Comparison | None, dict[str, Any]]:
    """Return the forecasts of the test recordings, None without any, and their scores; the model learns its error."""
    trainer, dataset = run.trainer, trainable(dataset)
    driving = None if isinstance(trainer, ExpertsTrainer) or trainer.driving is None else trainer.driving
    set_relative_error(trainer.model, trainer.windows.cpu().double().numpy(), driving)
    comparison = compare(trainer.model, dataset, trainer.windows.shape[1], run.config.training.stride)
    metrics = _metrics(run, dataset, comparison)
    ambient = [recording for recording in dataset.select("test") if recording.excitation == "ambient"]
    if ambient:
        found = [each for recording in ambient for each in sensed(trainer.model, recording)]
        metrics["virtual_sensing"] = sensing_scores(found, dataset.sensors)
    return comparison, metrics


def _metrics(run: Run, dataset: Dataset, comparison: Comparison | None) -> dict[str, Any]:
    """Return the scores of a run as plain data, but for the whole field's."""
    metrics: dict[str, Any] = {
        "schema": 1,
        "training": {
            "recordings": list(run.origin.kept),
            "left_out": list(run.origin.left_out),
            "linear_model_unexplained": run.origin.unexplained,
            "windows": len(run.trainer.windows),
            "window_samples": run.trainer.windows.shape[1],
            "epochs": len(run.history),
            "seconds": run.seconds,
        },
        "test": None,
        "scores": None,
    }
    if comparison is None:
        return metrics
    model = run.trainer.model
    forecasts = {name: forecast.channels for name, forecast in comparison.by_name.items()}
    metrics["test"] = {
        "recordings": [recording.name for recording in forecast_recordings(dataset)],
        "windows": len(comparison.windows),
        "overlapping": len(comparison.windows) > sum(len(each.data) for each in forecast_recordings(dataset)),
        "window_samples": run.trainer.windows.shape[1],
        "encoder_samples": run.config.model.encoder_samples,
    }
    if isinstance(model, Experts):
        metrics["test"]["expert_weights"] = expert_weights(model, run.origin, comparison.windows)
    metrics["scores"] = score_table(forecasts, comparison.windows, dataset.sensors)
    metrics["bands"] = band_scores(model, comparison, dataset.sensors)
    return metrics


def expert_weights(model: Experts, origin: Origin, windows: FloatArray) -> dict[str, float]:
    """Return the mean weight of each training recording's expert over windows (window, time, sensor)."""
    with torch.no_grad():
        weights = model.weights(torch.tensor(windows).to(model.channel_scale))
    return dict(zip(origin.kept, weights.mean(dim=0).tolist(), strict=True))


def fe_initial_state(origin: Origin, window: FloatArray, samples: int, driving: Driving | None = None) -> FloatArray:
    """Return q0 (mode,) that the FE model alone infers from the first samples of a window (time, sensor).

    ``driving``: what is known to drive this one window.
    """
    measured = [i for i, sensor in enumerate(origin.sensors) if sensor.role == "measured"]
    modal = origin.modal
    observer = Observer(modal, [origin.sensors[i] for i in measured], 1 / origin.sampling_rate)
    modes = len(modal.omega)
    rest = torch.zeros(2, modes, modes, dtype=torch.float64)
    known = None if driving is None else driving.to(rest).of_sensors(measured)
    free = free_part(observer, rest, torch.tensor(window[None, :samples, measured]), known)
    states, _ = smooth(observer.matrix(rest, samples), free)
    return (states[0, :modes] / observer.omega).numpy()


def prediction_of(
    hybrid: Forecast, fe: Forecast, origin: Origin, fe_initial: FloatArray, truth: FloatArray | None = None
) -> Prediction:
    """Return the displacement fields of the first window of two forecasts; ``fe_initial`` (mode,) see above."""
    shapes = origin.modal.shapes
    return Prediction(
        time=np.arange(hybrid.q.shape[1]) / origin.sampling_rate,
        hybrid=hybrid.q[0] @ shapes.T,
        fe=fe.q[0] @ shapes.T,
        fe_initial=shapes @ fe_initial,
        truth=truth,
        unit="1" if any(sensor.unit == "1" for sensor in origin.sensors) else "m",
        sensors=origin.sensors,
    )


def _curves(
    run: Run, dataset: Dataset, comparison: Comparison | None, prediction: Prediction | None
) -> Iterator[tuple[str, Sheet]]:
    """Draw the training, and the forecasts of the first test window where there is one, by the names of their files."""
    yield "training.png", draw_history(run.history)
    if comparison is None or prediction is None:
        return
    modal = run.origin.modal
    time, hybrid, fe = prediction.time, comparison.hybrid.forecast, comparison.fe
    first = "first test window, forecast from its first samples"
    channels = {"measured": comparison.windows[0], "FE model": fe.channels[0], "hybrid": hybrid.channels[0]}
    q, q_dot = {"FE model": fe.q[0], "hybrid": hybrid.q[0]}, {"FE model": fe.q_dot[0], "hybrid": hybrid.q_dot[0]}
    fields = {"FE model": prediction.fe, "hybrid": prediction.hybrid}
    if prediction.truth is not None:
        fields = {"truth": prediction.truth, **fields}
    numbered = len(dataset.model.nodes) if isinstance(dataset.model, Structure) else None
    row = _most_moved_translation(modal, prediction.hybrid, numbered)
    labels = channel_labels(dataset.sensors)
    yield "channels.png", draw_channels(time, channels, labels, f"Channels, {first}")
    yield "latent.png", draw_latent(time, q, q_dot, f"Modal coordinates and velocities, {first}")
    yield (
        "displacement.png",
        draw_curves(
            time,
            {name: field[:, [row]] for name, field in fields.items()},
            [f"displacement ({'m' if prediction.unit == 'm' else 'relative'})"],
            f"Displacement of node {modal.dofs.node[row]} in {modal.dofs.direction[row]}, the largest\n{first}",
        ),
    )
    chain = dataset.model
    if isinstance(chain, Structure) and chain.directions == ("x",):
        yield LOOP, _draw_loop(dataset, chain, modal, comparison)


def _most_moved_translation(modal: ModalModel, field: FloatArray, nodes: int | None = None) -> int:
    """Return the row of the translation (not a rotation) that moves most in a field (time, dof).

    ``nodes``: how many the structure has; those that dividing its beams adds have no number in a drawing.
    """
    motion = np.abs(field).max(axis=0) * np.isin(modal.dofs.direction, TRANSLATIONS)
    if nodes is not None:
        motion = motion * (modal.dofs.node <= nodes)
    return int(np.argmax(motion))


def _draw_loop(dataset: Dataset, chain: Structure, modal: ModalModel, comparison: Comparison) -> Sheet:
    """Draw the inertia force at node 1 over its displacement: the loop that a nonlinear spring there bends."""
    mass = sum(point.mass for point in chain.point_masses if point.node == 1)
    row = modal.dofs.row(1, "x")
    forecasts = {"FE model": comparison.fe, "hybrid": comparison.hybrid.forecast}
    displacement = {name: forecast.q[0] @ modal.shapes[row] for name, forecast in forecasts.items()}
    force = {name: -mass * (forecast.q_ddot[0] @ modal.shapes[row]) for name, forecast in forecasts.items()}
    quantities = {sensor.quantity: i for i, sensor in enumerate(dataset.sensors) if sensor.node == 1}
    if {"displacement", "acceleration"} <= quantities.keys():
        window = comparison.windows[0]
        displacement = {"measured": window[:, quantities["displacement"]], **displacement}
        force = {"measured": -mass * window[:, quantities["acceleration"]], **force}
    return draw_loop(displacement, force, node=1)
