"""Predict a structure's motion with a trained hybrid model, from a record's first samples or from any initial state."""

from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from fe_models.arrays import FloatArray
from fe_models.errors import InputError, bad_input_exits, raise_faults
from fe_models.files.atomic import writing
from fe_models.files.dataset_file import load_dataset
from fe_models.files.run_folder import load_run, save_prediction, save_run_model
from hybrid.estimation.experts import fe_counterpart
from hybrid.estimation.forecast import Forecast, forecast_windows, generate
from hybrid.estimation.given_state import modal_state, read_nodal_state
from hybrid.estimation.uncertainty import BandedForecast, banded_forecast
from hybrid.training.checkpoint import Checkpoint, load_checkpoint
from hybrid.training.results import fe_initial_state, prediction_of
from hybrid.training.run import DONE
from hybrid.training.session import check_device

app = typer.Typer(add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)


@app.command()
def main(
    run: Annotated[Path, typer.Argument(help="Folder that train_hybrid.py wrote.")],
    out: Annotated[Path, typer.Option(help="Folder for the prediction; made where it is missing.")],
    dataset: Annotated[Path | None, typer.Option(help="Dataset with the record to start from.")] = None,
    record: Annotated[str | None, typer.Option(help="Name of the record. [default: the first]")] = None,
    start: Annotated[float, typer.Option(min=0.0, max=1e6, help="Time (s) in the record at which to start.")] = 0.0,
    whole: Annotated[
        bool, typer.Option("--whole", help="Use all samples of the record over the duration, not the first alone.")
    ] = False,
    initial: Annotated[
        Path | None, typer.Option(help="CSV file with node,direction,displacement,velocity: the state to start from.")
    ] = None,
    device: Annotated[str, typer.Option(help="cpu, cuda or cuda:N.")] = "cpu",
    duration: Annotated[float, typer.Option(min=0.0, max=1e4, help="Length of the prediction, s.")] = 5.0,
) -> None:
    """Predict the motion of the whole structure with a trained hybrid model.

    Start either from a record, of which the first samples are read, or from a state of your own, given at as many nodes
    as you like. OUT then holds prediction.npz (displacement of all nodes over time, hybrid and FE model from the same
    start), and channels.csv (what the sensors would read, and from a record the standard deviation of that: nine times
    in ten the truth lies within 1.645 of it); scripts/render_shapes.py OUT draws it.

    With --whole the motion is reconstructed instead, from all samples of the record: virtual sensing. That takes a
    model which solves for its states (train_hybrid.py --preset places).

    \b
    Examples:
      python scripts/predict_motion.py runs/demo/hybrid --out runs/pull --initial pull.csv --duration 10
      python scripts/predict_motion.py runs/demo/hybrid --out runs/later --dataset runs/demo/data/dataset.toml --start 8
    """
    with bad_input_exits():
        if (dataset is None) == (initial is None):
            raise InputError("give either --dataset, to start from a record, or --initial, to start from a state")
        check_device(device)
        checkpoint = load_checkpoint(run / DONE)
        checkpoint.model.to(device)
        model = load_run(run).model
        samples = round(duration * checkpoint.origin.sampling_rate) + 1
        if dataset is not None:
            banded, fe, fe_initial = from_record(checkpoint, dataset, record, start, samples, whole)
            hybrid, std = banded.forecast, banded.std
        else:
            hybrid, fe, fe_initial = from_state(checkpoint, Path(str(initial)), samples)
            std = None
        save_run_model(model, checkpoint.origin.modal, out)
        save_prediction(prediction_of(hybrid, fe, checkpoint.origin, fe_initial), out)
        write_channels(hybrid, fe, std, checkpoint, out / "channels.csv")
        print(f"{samples} samples predicted: {out / 'prediction.npz'}, {out / 'channels.csv'}")


def from_record(
    checkpoint: Checkpoint, dataset: Path, name: str | None, start: float, samples: int, whole: bool
) -> tuple[BandedForecast, Forecast, FloatArray]:
    """Return the hybrid and the FE forecast from a place in a record, and the FE model's own initial q (mode,)."""
    data = load_dataset(dataset)
    origin, seen = checkpoint.origin, checkpoint.config.model.encoder_samples
    faults = []
    if data.sensors != origin.sensors or data.sampling_rate != origin.sampling_rate:
        faults.append(f"{dataset}: its sensors or sampling rate are not those that the model was trained with")
    records = {recording.name: recording for recording in data.recordings}
    if name is not None and name not in records:
        raise InputError([*faults, f"--record {name}: {dataset} has {', '.join(records)}"])
    chosen = records[name or data.recordings[0].name]
    first, end = round(start * origin.sampling_rate), chosen.data.shape[1]
    if whole and first + samples > end:
        available = (end - first - 1) / data.sampling_rate
        faults.append(f"--whole: record {chosen.name} has {available:g} s left; give --duration {available:g} or less")
    if first + seen > end:
        faults.append(f"--start {start:g}: record {chosen.name} ends after {end / data.sampling_rate:g} s")
    raise_faults(faults)
    window = chosen.data[:1, first : first + (samples if whole else seen)]
    model = checkpoint.model
    fe = forecast_windows(model, window, fe_counterpart(model), samples, whole)
    return banded_forecast(model, window, samples, whole), fe, fe_initial_state(origin, window[0], seen)


def from_state(checkpoint: Checkpoint, path: Path, samples: int) -> tuple[Forecast, Forecast, FloatArray]:
    """Return the hybrid and the FE motion from the state in a file, and its modal coordinates (mode,)."""
    modal = checkpoint.origin.modal
    q, q_dot = modal_state(read_nodal_state(path, modal), modal)
    model = checkpoint.model
    return generate(model, q, q_dot, samples), generate(fe_counterpart(model), q, q_dot, samples), q


def write_channels(hybrid: Forecast, fe: Forecast, std: FloatArray | None, checkpoint: Checkpoint, path: Path) -> None:
    """Write time (s), all channels of both forecasts and the standard deviation of the hybrid's as CSV."""
    names = [sensor.name for sensor in checkpoint.origin.sensors]
    header = ["time", *(f"{name} hybrid" for name in names), *(f"{name} FE" for name in names)]
    columns = [hybrid.channels[0], fe.channels[0]]
    if std is not None:
        header += [f"{name} std" for name in names]
        columns.append(std[0])
    time = np.arange(hybrid.channels.shape[1]) / checkpoint.origin.sampling_rate
    with writing(path) as temporary:
        table = np.column_stack([time, *columns])
        np.savetxt(temporary, table, fmt="%.9g", delimiter=",", header=",".join(header), comments="")


if __name__ == "__main__":
    app()
