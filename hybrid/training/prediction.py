"""The motion of the whole structure by a trained model, from a record's first samples or from any initial state."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.errors import InputError, raise_faults
from fe_models.files.atomic import writing
from fe_models.files.result_set import ResultSet
from fe_models.files.run_folder import MODEL, PREDICTION
from fe_models.recordings import Dataset, Recording
from hybrid.estimation.experts import fe_counterpart
from hybrid.estimation.forecast import Forecast, forecast_windows, generate
from hybrid.estimation.given_state import modal_state, read_nodal_state
from hybrid.estimation.uncertainty import banded_forecast
from hybrid.estimation.windows import driving_of
from hybrid.known_loads.modal_input import modal_input
from hybrid.training.checkpoint import Checkpoint
from hybrid.training.results import fe_initial_state
from hybrid.training.sensing import sensed, sensing_scores
from hybrid.training.trainable import as_moved, at_one_rate

CHANNELS = "channels.csv"


def prediction_in(folder: Path) -> ResultSet:
    """Return what a prediction leaves in ``folder``."""
    return ResultSet(folder, "predict", (MODEL, PREDICTION, CHANNELS))


@dataclass(frozen=True)
class PredictedMotion:
    """What the ``hybrid`` and the FE model predict, and the FE model's own initial q (mode,).

    From a record ``std`` (window, time, sensor) of the hybrid's channels, sensor noise left out; of an ambient one its
    ``scores`` (`sensing_scores`). ``notes``: how the record was taken.
    """

    hybrid: Forecast
    fe: Forecast
    fe_initial: FloatArray
    std: FloatArray | None = None
    scores: dict[str, Any] | None = None
    notes: tuple[str, ...] = ()


def from_record(
    checkpoint: Checkpoint, data: Dataset, name: str | None, start: float, samples: int, whole: bool
) -> PredictedMotion:
    """Return what is predicted from a place in a record on, for so many ``samples``.

    Where known forces act, they have to be known over all of these. Of an ambient record, the motion is estimated from
    all its samples, before the place and after.
    """
    data.require_recordings("a prediction")
    data = at_one_rate(data)
    origin, seen = checkpoint.origin, checkpoint.config.model.encoder_samples
    faults = []
    if data.sensors != origin.sensors or data.sampling_rate != origin.sampling_rate:
        faults.append("--dataset: its sensors or sampling rate are not those that the model was trained with")
    records = {recording.name: recording for recording in data.recordings}
    if name is not None and name not in records:
        raise InputError([*faults, f"--recording {name}: the dataset has {', '.join(records)}"])
    data = as_moved(
        replace(data, recordings=(records[name or data.recordings[0].name],)), float(origin.modal.frequencies.min())
    )
    (chosen,) = data.recordings
    first, end = round(start * origin.sampling_rate), chosen.data.shape[1]
    ambient = chosen.excitation == "ambient"
    if (whole or ambient) and first + samples > end:
        available = (end - first - 1) / data.sampling_rate
        what = "--duration" if ambient else "--whole"
        taken = ", which is taken as ambient vibration," if ambient else ""
        faults.append(
            f"{what}: recording {chosen.name}{taken} has {available:g} s left; give --duration {available:g} or less"
        )
    if chosen.is_driven and first + samples > end:
        available = (end - first - 1) / data.sampling_rate
        faults.append(
            f"--duration: the forces on recording {chosen.name} are known for {available:g} s more, a forecast needs"
            f" them: give --duration {available:g} or less"
        )
    if first + seen > end:
        faults.append(f"--start {start:g}: recording {chosen.name} ends after {end / data.sampling_rate:g} s")
    raise_faults(faults)
    if ambient:
        return replace(_from_ambient(checkpoint, chosen, first, first + samples), notes=data.notes)
    window = chosen.data[:1, first : first + (samples if whole else seen)]
    model = checkpoint.model
    driving = driving_of(modal_input(data, origin.modal, [chosen]), chosen)
    known = None if driving is None else driving[:1].part(first, first + samples)
    fe = forecast_windows(model, window, fe_counterpart(model), samples, whole, known)
    hybrid = banded_forecast(model, window, samples, whole, known)
    fe_initial = fe_initial_state(origin, window[0], seen, known)
    return PredictedMotion(hybrid.forecast, fe, fe_initial, hybrid.std, notes=data.notes)


def _from_ambient(checkpoint: Checkpoint, record: Recording, first: int, end: int) -> PredictedMotion:
    """Return the motion of a whole record under unknown forces, from ``first`` to before ``end``, and its scores."""
    found = sensed(checkpoint.model, replace(record, data=record.data[:1]))
    hybrid, fe = (each.part(first, end) for each in (found[0].hybrid, found[0].fe))
    scores = sensing_scores(found, checkpoint.origin.sensors)
    return PredictedMotion(hybrid.motion, fe.motion, fe.motion.q[0, 0], hybrid.channels_std[None], scores)


def from_state(checkpoint: Checkpoint, path: Path, samples: int) -> PredictedMotion:
    """Return the motion from the state in a file."""
    modal = checkpoint.origin.modal
    q, q_dot = modal_state(read_nodal_state(path, modal), modal)
    model = checkpoint.model
    fe = generate(fe_counterpart(model), q, q_dot, samples)
    return PredictedMotion(generate(model, q, q_dot, samples), fe, q)


def write_channels(found: PredictedMotion, checkpoint: Checkpoint, path: Path) -> None:
    """Write time (s), all channels of both forecasts and the standard deviation of the hybrid's as CSV."""
    names = [sensor.name for sensor in checkpoint.origin.sensors]
    header = ["time", *(f"{name} hybrid" for name in names), *(f"{name} FE" for name in names)]
    columns = [found.hybrid.channels[0], found.fe.channels[0]]
    if found.std is not None:
        header += [f"{name} std" for name in names]
        columns.append(found.std[0])
    time = np.arange(found.hybrid.channels.shape[1]) / checkpoint.origin.sampling_rate
    with writing(path) as temporary:
        table = np.column_stack([time, *columns])
        np.savetxt(temporary, table, fmt="%.9g", delimiter=",", header=",".join(header), comments="")
