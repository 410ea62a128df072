"""The main job from end to end, on the built-in bridge or on the authors' recordings of the real one."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from fe_models.arrays import FloatArray
from fe_models.built_in.bridge import bridge
from fe_models.errors import InputError, noting, raise_faults
from fe_models.files.bridge_recordings import bridge_sensors, write_bridge_dataset
from fe_models.files.dataset_file import dataset_in, load_dataset, write_dataset
from fe_models.files.inputs import files_read
from fe_models.pictures.run_pictures import PictureOptions, draw_run
from fe_models.recordings import Dataset
from fe_models.simulation import ReleaseConfig
from fe_models.statics import PointLoad
from fe_models.synthetic import Acquisition, release_dataset
from hybrid.commands.console import command_line, new_app
from hybrid.config import Config, TrainingConfig
from hybrid.training.run import results_in
from hybrid.training.session import check_device, open_run, score, train
from hybrid.training.summary import describe

# What is hung on the deck and cut loose, N; the last release is the one to forecast.
PULLS = (
    (PointLoad(19, "y", -9.81),),
    (PointLoad(9, "y", -9.81),),
    (PointLoad(15, "y", -19.62),),
    (PointLoad(12, "y", -9.81), PointLoad(20, "y", -4.905)),
)
SEED = 0
STEP = 1e-3  # s; the demo is to take a minute or two, and nothing in it turns on frequencies to a part in ten thousand
FRAMES = 125  # of the animation, at most

app = new_app()


@app.command()
def main(
    out: Annotated[Path, typer.Option(help="Folder for everything the demo makes.")] = Path("runs/demo"),
    data: Annotated[
        Path | None, typer.Option(help="Folder of real recordings: dataset.toml, or the authors' acc_measured1..4.mat.")
    ] = None,
    test: Annotated[int, typer.Option(min=1, max=4, help="Which of the authors' recordings to forecast.")] = 4,
    epochs: Annotated[int, typer.Option(min=1, help="Passes over the training windows.")] = TrainingConfig.epochs,
    device: Annotated[str, typer.Option(help="cpu, cuda or cuda:N, for the training.")] = "cpu",
    duration: Annotated[float, typer.Option(min=1.0, max=600.0, help="Length of each simulated recording, s.")] = 20.0,
) -> None:
    """Run the main job: FE model, recordings, hybrid model, forecast of an unseen recording, pictures.

    Without --data, a "measured" bridge is simulated in Exudyn with what the linear FE model lacks: gravity, prestress,
    large displacements, cables that can go slack, and sensor noise. Seven accelerometers are used; the eighth, and the
    displacement of all nodes, are reconstructed and compared with the simulated truth.
    """
    with command_line(quiet=False):
        faults = list[str]()
        noting(faults, "", check_device, device)
        noting(faults, "--out", results_in(out / "hybrid").check, files_read(data / "dataset.toml") if data else ())
        if data is None:
            noting(faults, "--out", dataset_in(out / "data").check)
        raise_faults(faults)
        truth = None
        if data is None:
            print(f"1/4  Simulating a nonlinear bridge in Exudyn: four releases of {duration:g} s ...", flush=True)
            dataset, truth = simulated_bridge(out, duration)
        else:
            print(f"1/4  Reading the recordings in {data} ...", flush=True)
            dataset = load_dataset(find_dataset(data, out, test))
        print("2/4  Training the hybrid model on top of the linear FE model ...", flush=True)
        config = Config(training=replace(Config().training, epochs=epochs))
        run = open_run(dataset, config, out / "hybrid", device)
        train(run)
        print("3/4  Forecasting the recording that was not trained on ...", flush=True)
        metrics = score(run, dataset, truth).metrics
        print("4/4  Drawing ...", flush=True)
        pictures = draw_run(out / "hybrid", out / "pictures", PictureOptions(frames=FRAMES))
        print(f"\n{describe(metrics)}\n\nPictures of the structure:")
        for path, meaning in pictures[-4:]:
            print(f"  {path}  {meaning}")
        print(f"Curves: {out / 'hybrid'}/channels.png, latent.png, displacement.png, training.png")


def simulated_bridge(out: Path, duration: float) -> tuple[Dataset, FloatArray]:
    """Write the simulated recordings to ``out``; return them and the true displacement (time, dof), m, of the last."""
    sensors = bridge_sensors(unit="m/s^2")
    synthetic = release_dataset(
        bridge(), PULLS, sensors, Acquisition(), np.random.default_rng(SEED), ReleaseConfig(duration, step=STEP)
    )
    with dataset_in(out / "data").replacing() as new:
        write_dataset(synthetic.dataset, new, "bridge")
    return synthetic.dataset, synthetic.fields[-1]


def find_dataset(folder: Path, out: Path, test: int) -> Path:
    """Return the folder's own dataset.toml, or one made for the authors' files in it."""
    if not folder.is_dir():
        raise InputError(f"{folder}: no such folder; give one with a dataset.toml or the authors' acc_measured1..4.mat")
    own = folder / "dataset.toml"
    return own if own.is_file() else write_bridge_dataset(folder, out / "data", test)


if __name__ == "__main__":
    app()
