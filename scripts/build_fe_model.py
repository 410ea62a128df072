"""Build a finite element model and, with --simulate, recordings: `hybrid-modal build` and `simulate` at once."""

from typing import Annotated

import typer

from fe_models.errors import raise_faults
from fe_models.files.dataset_file import dataset_in, write_dataset
from hybrid.commands.any_recordings import recordings_of
from hybrid.commands.console import command_line, new_app
from hybrid.commands.models import model_in, open_model, write_model
from hybrid.commands.option_groups import with_option_groups
from hybrid.commands.options import Model, Modes, Out, Pictures, Refine, Seed
from hybrid.commands.recording_options import NONE_GIVEN, RecordingOptions

Simulate = Annotated[bool, typer.Option("--simulate", help="Also write simulated recordings, OUT/dataset.toml.")]
app = new_app()


@app.command()
@with_option_groups
def main(
    model: Model,
    out: Out,
    refine: Refine = None,
    modes: Modes = None,
    pictures: Pictures = True,
    simulate: Simulate = False,
    given: RecordingOptions = NONE_GIVEN,
    seed: Seed = 0,
) -> None:
    """Build a finite element model: matrices, natural modes and their pictures; with --simulate also recordings.

    The same as `hybrid-modal build`, and `hybrid-modal simulate` with all its options, which their --help explains.

    \b
    Examples:
      python scripts/build_fe_model.py bridge --out runs/bridge
      python scripts/build_fe_model.py bridge --out runs/data --simulate \\
          --pull 19:y:-9.81 --pull 9:y:-5+21:y:-5
      python scripts/build_fe_model.py frame.toml --out runs/frame --refine 4 \\
          --simulate --pull 3:x:100 --sensor 2:x
    """
    with command_line(quiet=False):
        results, simulated = model_in(out), dataset_in(out)
        subject = open_model(model, refine, [results, simulated] if simulate else [results], given.modal_model)
        if not simulate:
            raise_faults(given.useless(*vars(given), because="is for simulated recordings; add --simulate"))
        simulation = recordings_of(model, subject, given, seed) if simulate else None
        recordings = simulation() if simulation else None  # before anything is written: it may fail
        write_model(model, subject, results, modes, pictures, recordings.sensors if recordings else ())
        if recordings is not None:
            with simulated.replacing() as new:
                path = write_dataset(recordings, new)
            print(f"Recordings: {out / path.name}")


if __name__ == "__main__":
    app()
