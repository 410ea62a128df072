"""Build a finite element model and, with --simulate, recordings: `hybrid-modal build` and `simulate` at once."""

from fe_models.errors import bad_input_exits, raise_faults
from fe_models.files.dataset_file import dataset_in, save_dataset
from hybrid.commands import options
from hybrid.commands.console import new_app
from hybrid.commands.models import model_in, open_model, write_model
from hybrid.commands.recordings import Wishes, recordings_of

app = new_app()


@app.command()
def main(
    model: options.Model,
    out: options.Out,
    refine: options.Refine = 1,
    modes: options.Modes = None,
    pictures: options.Pictures = True,
    simulate: options.Simulate = False,
    pull: options.Pull = None,
    sensor: options.SensorAt = None,
    realisations: options.Realisations = None,
    cubic_stiffness: options.CubicStiffness = None,
    duration: options.Duration = None,
    step: options.Step = None,
    sampling_rate: options.SamplingRate = None,
    lowpass: options.LowPassAt = None,
    noise: options.Noise = None,
    gravity: options.Gravity = None,
    modal_model: options.ModalModelFile = None,
    seed: options.Seed = 0,
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
    wishes = Wishes(
        pull, sensor, realisations, cubic_stiffness, duration, step, sampling_rate, lowpass, noise, gravity, modal_model
    )
    with bad_input_exits():
        results, simulated = model_in(out), dataset_in(out)
        subject = open_model(model, refine, [results, simulated] if simulate else [results], modal_model)
        if not simulate:
            raise_faults(wishes.useless(*vars(wishes), because="is for simulated recordings; add --simulate"))
        simulation = recordings_of(model, subject, wishes, seed) if simulate else None
        recordings = simulation() if simulation else None  # before anything is written: it may fail
        write_model(model, subject, results, modes, pictures, recordings.sensors if recordings else ())
        if recordings is not None:
            with simulated.replacing() as new:
                path = save_dataset(recordings, new)
            print(f"Recordings: {out / path.name}")


if __name__ == "__main__":
    app()
