"""Train the hybrid model on a dataset, score it on recordings that it never saw, draw the curves."""

from dataclasses import replace
from enum import Enum
from pathlib import Path
from typing import Annotated, Any

import typer

from fe_models.errors import bad_input_exits, noting, raise_faults
from fe_models.files.atomic import check_folder
from fe_models.files.dataset_file import load_dataset
from fe_models.recordings import Dataset
from fe_models.structure import Structure
from hybrid.config import Config, experts_preset, paper_preset, places_preset
from hybrid.training.session import check_device, open_run, score, train
from hybrid.training.summary import describe


class Preset(Enum):
    """Named configurations."""

    DEFAULT = "default"
    PAPER = "paper"
    PLACES = "places"
    EXPERTS = "experts"


class Integrator(Enum):
    """How the latent ODE is solved."""

    PROPAGATOR = "propagator"
    RK4 = "rk4"
    DOPRI5 = "dopri5"


app = typer.Typer(add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)


@app.command()
def main(
    dataset: Annotated[Path, typer.Argument(help="The dataset's TOML file.")],
    out: Annotated[Path, typer.Option(help="Folder for the results; made where it is missing.")],
    preset: Annotated[
        Preset, typer.Option(help="'paper': Lai et al. 2022. 'places': for chains. 'experts': a model a recording.")
    ] = Preset.DEFAULT,
    epochs: Annotated[
        int | None, typer.Option(min=1, help="Passes over the training windows. [default: 20; places 30; paper 1600]")
    ] = None,
    learning_rate: Annotated[
        float | None, typer.Option(min=1e-8, help="Of Adam, at the start. [default: 0.001]")
    ] = None,
    batch: Annotated[int | None, typer.Option(min=1, help="Windows a step. [default: 16; places 100]")] = None,
    window: Annotated[
        int | None, typer.Option(min=40, help="Samples a window, at most a recording's. [default: 500]")
    ] = None,
    first_horizon: Annotated[
        int | None, typer.Option(min=10, help="Samples forecast in the first epoch. [default: 100; places 20]")
    ] = None,
    modes: Annotated[
        int | None, typer.Option(min=1, help="Most modes kept, where the dataset does not say. [default: 10]")
    ] = None,
    encoder_samples: Annotated[
        int | None, typer.Option(min=2, help="First samples, from which the state is told. [default: 10]")
    ] = None,
    integrator: Annotated[
        Integrator | None, typer.Option(help="rk4 and dopri5 (adjoint gradients) are those of torchdiffeq.")
    ] = None,
    seed: Annotated[int | None, typer.Option(min=0, max=2**32 - 1, help="Of everything random. [default: 0]")] = None,
    threads: Annotated[
        int | None, typer.Option(min=1, max=256, help="Processor threads of PyTorch. [default: 1]")
    ] = None,
    device: Annotated[str, typer.Option(help="cpu, cuda or cuda:N.")] = "cpu",
    fresh: Annotated[bool, typer.Option("--fresh", help="Throw an interrupted training away.")] = False,
) -> None:
    """Train the hybrid model on a dataset and score it on the recordings marked "test".

    An encoder reads a window's first samples and gives the initial modal state; a modal ODE carries it on, with the FE
    model's frequencies and damping fixed and a rest that is learned; the FE model's mode shapes turn it back into
    sensors, and into the displacement of every node.

    --preset places ties what is learned to the places of a chain, a spring, a dashpot and a small net at each mass and
    along each spring, and solves for the initial state instead of encoding it: slower, and far more accurate.

    --preset experts trains one model a training recording and weighs their forecasts by how well each recording
    explains a window's first samples: for recordings that are not quite of one structure, as of a real one on
    different days.

    An interrupted training goes on where it stood when the same command is given again.

    \b
    OUT/metrics.json     NRMSE and R2 of the FE model and the hybrid, from the same start
    OUT/checkpoint.pt    the model, to load from Python with hybrid.training.checkpoint.load_checkpoint
    OUT/prediction.npz   displacement of all nodes over the first test window, for render_shapes.py
    OUT/*.png            channels, modal coordinates, displacement, force-displacement loop of a chain, training

    \b
    Examples:
      python scripts/build_fe_model.py four_dof --out runs/chain --simulate --cubic-stiffness 1
      python scripts/train_hybrid.py runs/chain/dataset.toml --out runs/chain/hybrid
      python scripts/train_hybrid.py my_bridge/dataset.toml --out runs/mine --epochs 40 --modes 6
    """
    with bad_input_exits():
        faults = list[str]()
        noting(faults, "", check_device, device)
        noting(faults, "--out", check_folder, out)
        data = noting(faults, "", load_dataset, dataset)
        raise_faults(faults)
        assert data is not None  # else there were faults
        if data.assumptions.integrator != "exact":
            print("Note: the FE model is integrated exactly here; [simulation] integrator and step are not used.")
        model_options = {
            "modes": modes,
            "encoder_samples": encoder_samples,
            "integrator": integrator.value if integrator else None,
        }
        training_options = {
            "epochs": epochs,
            "learning_rate": learning_rate,
            "batch": batch,
            "window": window,
            "first_horizon": first_horizon,
            "seed": seed,
            "threads": threads,
        }
        presets = {
            Preset.DEFAULT: Config(),
            Preset.PAPER: paper_preset(name_of(data)),
            Preset.PLACES: places_preset(),
            Preset.EXPERTS: experts_preset(),
        }
        config = presets[preset]
        config = Config(
            replace(config.model, **given(model_options)), replace(config.training, **given(training_options))
        )
        run = open_run(data, config, out, device, fresh)
        train(run)
        print(describe(score(run, data)))
        print(f"Results: {out}")


def name_of(data: Dataset) -> str:
    """Return the name of the dataset's structure; empty for a model of matrices."""
    return data.model.name if isinstance(data.model, Structure) else ""


def given(options: dict[str, Any]) -> dict[str, Any]:
    """Return the options that the user gave."""
    return {name: value for name, value in options.items() if value is not None}


if __name__ == "__main__":
    app()
