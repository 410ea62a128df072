"""The sub-command `train`: the hybrid model on a dataset, scored on recordings that it never saw."""

from dataclasses import dataclass
from typing import Annotated

import typer

from hybrid.commands.console import command_line, print_notes, say, words_of
from hybrid.commands.option_groups import options_in_words, with_option_groups
from hybrid.commands.options import DatasetFile, Device, Out, Quiet
from hybrid.config import IntegratorKind, PresetName, configuration

Preset = Annotated[
    PresetName, typer.Option(help="'paper': Lai et al. 2022. 'places': for chains. 'experts': one model per recording.")
]
Fresh = Annotated[bool, typer.Option("--fresh", help="Begin anew, and discard an interrupted training.")]


@dataclass(frozen=True)
class TrainingOptions:
    """Options in place of the preset's; None leaves it as it is."""

    epochs: Annotated[
        int | None, typer.Option(min=1, help="Passes over the training windows. [default: 20; places 30; paper 1600]")
    ] = None
    learning_rate: Annotated[float | None, typer.Option(min=1e-8, help="Of Adam, at the start. [default: 0.001]")] = (
        None
    )
    batch: Annotated[int | None, typer.Option(min=1, help="Windows per step. [default: 16; places 100]")] = None
    window: Annotated[
        int | None,
        typer.Option(
            min=40, help="Samples per window, at most those of a recording. [default: 500; fewer of short recordings]"
        ),
    ] = None
    first_horizon: Annotated[
        int | None, typer.Option(min=10, help="Samples forecast in the first epoch. [default: 100; places 20]")
    ] = None
    modes: Annotated[
        int | None, typer.Option(min=1, help="Most modes kept, where the dataset does not say. [default: 10]")
    ] = None
    encoder_samples: Annotated[
        int | None, typer.Option(min=2, help="First samples, from which the initial state is estimated. [default: 10]")
    ] = None
    integrator: Annotated[
        IntegratorKind | None, typer.Option(help="rk4 and dopri5 (adjoint gradients) are those of torchdiffeq.")
    ] = None
    seed: Annotated[int | None, typer.Option(min=0, max=2**32 - 1, help="Of everything random. [default: 0]")] = None
    threads: Annotated[int | None, typer.Option(min=1, max=256, help="Processor threads of PyTorch. [default: 1]")] = (
        None
    )


NONE_GIVEN = TrainingOptions()


@with_option_groups
def train(
    dataset: DatasetFile,
    out: Out,
    preset: Preset = "default",
    given: TrainingOptions = NONE_GIVEN,
    device: Device = "cpu",
    fresh: Fresh = False,
    quiet: Quiet = False,
) -> None:
    """Train the hybrid model on a dataset and score it on the recordings marked "test".

    An encoder reads a window's first samples and gives the initial modal state; a modal ODE carries it on, with the FE
    model's frequencies and damping fixed and a further term that is learned; the FE model's mode shapes turn it back
    into sensor signals, and into the displacement of every node.

    --preset places ties what is learned to the places of a chain, a spring, a dashpot and a small neural network at
    each mass and along each spring, and solves for the initial state instead of encoding it: slower, and far more
    accurate.

    --preset experts trains one model for each training recording and weighs their forecasts by how well each of them
    explains a window's first samples: for recordings that are not quite of one structure, as of a real one on
    different days.

    An interrupted training goes on where it stood when the same command is given again. Results of an earlier training
    in OUT are replaced, all together; a file of yours, or of another command, never is.

    \b
    OUT/report.html      all of it on a page for a browser, whole in one file: read this first
    OUT/metrics.json     NRMSE and R2 of the FE model and the hybrid, from the same start
    OUT/checkpoint.pt    the model, to load from Python with hybrid.training.checkpoint.load_checkpoint
    OUT/prediction.npz   displacement of all nodes over the first test window, for hybrid-modal render
    OUT/*.png            channels, modal coordinates, displacement, force-displacement loop of a chain, training

    \b
    Examples:
      hybrid-modal simulate four_dof --out runs/chain --cubic-stiffness 1
      hybrid-modal train runs/chain/dataset.toml --out runs/chain/hybrid
      hybrid-modal train my_bridge/dataset.toml --out runs/mine --epochs 40 --modes 6
    """
    from fe_models.errors import noting, raise_faults
    from fe_models.files.dataset_file import load_dataset
    from fe_models.files.inputs import files_read
    from hybrid.report.page_files import save_page
    from hybrid.report.training_page import page_from_files
    from hybrid.training import session
    from hybrid.training.run import results_in
    from hybrid.training.summary import describe
    from hybrid.training.trainable import trainable

    with command_line(quiet) as result:
        faults = list[str]()
        noting(faults, "", session.check_device, device)
        noting(faults, "--out", results_in(out).check, files_read(dataset))
        data = noting(faults, "", load_dataset, dataset)
        raise_faults(faults)
        assert data is not None  # else there were faults
        data = trainable(data)
        print_notes(data)
        if data.assumptions.integrator != "exact":
            print("Note: the FE model is integrated exactly here; [simulation] integrator and step are not used.")
        config = configuration(preset, getattr(data.model, "name", ""), vars(given))  # matrices have no name
        run = session.open_run(data, config, out, device, fresh)
        session.train(run)
        found = session.score(run, data)
        words = [*words_of("train", dataset, out), *([] if preset == "default" else ["--preset", preset])]
        words += options_in_words(given)
        say(save_page(results_in(out), lambda: page_from_files(run, data, found, words, dataset)))
        print(describe(found.metrics))
        print(f"Results: {out}")
        result(out / "metrics.json")
