"""The sub-command `predict`: the motion of the whole structure by a trained hybrid model."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from hybrid.commands.console import command_line
from hybrid.commands.options import Device, Quiet

if TYPE_CHECKING:
    from fe_models.recordings import Dataset
    from hybrid.training.checkpoint import Checkpoint
    from hybrid.training.prediction import PredictedMotion

Run = Annotated[Path, typer.Argument(help="Folder that 'hybrid-modal train' wrote.", show_default=False)]
Out = Annotated[Path, typer.Option(help="Folder for the prediction; made where it is missing.", show_default=False)]
Recording = Annotated[str | None, typer.Option(help="Name of the recording. [default: the first]")]
Record = Annotated[str | None, typer.Option(hidden=True)]  # the older name of --recording
Start = Annotated[float, typer.Option(min=0.0, max=1e6, help="Time (s) in the recording at which to start.")]
Whole = Annotated[
    bool, typer.Option("--whole", help="Use all samples of the recording over the duration, not the first alone.")
]
Initial = Annotated[
    Path | None,
    typer.Option(
        help="CSV file with node,direction,displacement,velocity: the state to start from. Other nodes are where "
        "static forces at the given ones would move them."
    ),
]
Duration = Annotated[float, typer.Option(min=0.0, max=1e4, help="Length of the prediction, s.")]


def predict(
    run: Run,
    out: Out,
    dataset: Annotated[Path | None, typer.Option(help="Dataset with the recording to start from.")] = None,
    recording: Recording = None,
    record: Record = None,
    start: Start = 0.0,
    whole: Whole = False,
    initial: Initial = None,
    device: Device = "cpu",
    duration: Duration = 5.0,
    quiet: Quiet = False,
) -> None:
    """Predict the motion of the whole structure with a trained hybrid model.

    Start either from a recording, of which the first samples are read, or from a state of your own, given at as many
    nodes as you like. OUT then holds prediction.npz (displacement of all nodes over time, hybrid and FE model from the
    same start), and channels.csv (what the sensors would read and, from a recording, its standard deviation);
    'hybrid-modal render OUT' draws it. metrics.json of RUN says how often tests stayed within 1.645 standard
    deviations, which should be nine times in ten.

    Known loads and base motion of the recording drive the forecast, as far as they are known. Of a recording with
    excitation = "ambient", or of which nothing is said and that does not die away, the motion is estimated from all its
    samples, under unknown forces, with its standard deviation, and scored on the held-out sensors.

    With --whole the motion is reconstructed instead, from all samples of the recording: virtual sensing. That takes a
    model which solves for its states (hybrid-modal train --preset places).

    \b
    Examples:
      hybrid-modal predict runs/demo/hybrid --out runs/pull --initial pull.csv --duration 10
      hybrid-modal predict runs/demo/hybrid --out runs/later --dataset runs/demo/data/dataset.toml --start 8
    """
    from fe_models.files.run_folder import PREDICTION, load_run, save_prediction, save_run_model
    from hybrid.training.checkpoint import load_checkpoint, require_together
    from hybrid.training.prediction import CHANNELS, from_record, from_state, prediction_in, write_channels
    from hybrid.training.results import prediction_of
    from hybrid.training.run import CHECKPOINT, metrics_in

    with command_line(quiet) as result:
        data = _checked(run, out, dataset, initial, device)
        checkpoint = load_checkpoint(run / CHECKPOINT)
        checkpoint.model.to(device)
        whole_run = load_run(run)
        require_together(checkpoint, whole_run, run)
        samples = _samples(duration, checkpoint)
        if data is None:
            found = from_state(checkpoint, Path(str(initial)), samples)
        else:
            found = from_record(checkpoint, data, recording or record, start, samples, whole)
        with prediction_in(out).replacing() as new:
            save_run_model(whole_run.model, checkpoint.origin.modal, new)
            save_prediction(prediction_of(found.hybrid, found.fe, checkpoint.origin, found.fe_initial), new)
            write_channels(found, checkpoint, new / CHANNELS)
        print("".join(f"Note: {note}.\n" for note in found.notes), end="")
        for line in _beside(found, metrics_in(run)):
            print(line)
        print(f"{samples} samples predicted: {out / PREDICTION}, {out / CHANNELS}")
        result(out / PREDICTION)


def _checked(run: Path, out: Path, dataset: Path | None, initial: Path | None, device: str) -> "Dataset | None":
    """Return the dataset to start from, None where a state is given; `InputError` with all that cannot be used."""
    from fe_models.errors import InputError, noting, raise_faults
    from fe_models.files.dataset_file import load_dataset
    from fe_models.files.inputs import files_read
    from fe_models.files.run_folder import run_files
    from hybrid.training.prediction import prediction_in
    from hybrid.training.run import CHECKPOINT
    from hybrid.training.session import check_device

    if (dataset is None) == (initial is None):
        raise InputError("give either --dataset, to start from a recording, or --initial, to start from a state")
    read, faults = [path for path in (run / CHECKPOINT, dataset, initial) if path is not None], list[str]()
    noting(faults, "--out", prediction_in(out).check, [*run_files(run), *files_read(*read)])
    noting(faults, "", check_device, device)
    data = None if dataset is None else noting(faults, "", load_dataset, dataset)
    raise_faults(faults)
    return data


def _samples(duration: float, checkpoint: "Checkpoint") -> int:
    """Return how many samples a prediction of ``duration`` s has; `InputError` where they are too many."""
    from fe_models.errors import raise_faults
    from fe_models.simulation_size import length_faults

    rate = checkpoint.origin.sampling_rate
    too_long = length_faults(duration or 1 / rate, rate, columns=len(checkpoint.origin.modal.dofs))
    raise_faults(f"--duration: {fault}" for fault in too_long)
    return round(duration * rate) + 1


def _beside(found: "PredictedMotion", metrics: dict[str, Any]) -> list[str]:
    """Return what is known of how good a prediction from a recording is, in lines."""
    from hybrid.training.sensing import beside_forecasts, describe_sensing
    from hybrid.training.summary import band_warning

    if found.scores is not None:
        return [*describe_sensing(found.scores), *beside_forecasts(metrics)]
    return [] if found.std is None else [f"Warning: {line}." for line in band_warning(metrics)]
