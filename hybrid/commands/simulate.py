"""The sub-command `simulate`: recordings of a structure, with what its linear model lacks."""

from hybrid.commands import options
from hybrid.commands.console import command_line


def simulate(
    model: options.Model,
    out: options.Out,
    refine: options.Refine = 1,
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
    pictures: options.Drawing = True,
    quiet: options.Quiet = False,
) -> None:
    """Simulate recordings of a structure: OUT/dataset.toml, to train on or to diagnose.

    OUT/sensors.png shows the structure with the numbers of its nodes and elements, and each sensor as an arrow.

    Simulated recordings have what the linear model lacks. Frames come to rest under gravity, prestress and the pulls,
    which then let go: large displacements, P-delta, slack cables, noise. A recording starts 0.1 s after the release,
    when its jump, smeared by the low-pass, has died down. Of several recordings the last is for testing.
    Chains start from random states; four_dof gives the data of the paper (its own numbers with seed 0, 1000 motions).

    \b
    Examples:
      hybrid-modal simulate bridge --out runs/data --pull 19:y:-9.81 --pull 9:y:-5+21:y:-5
      hybrid-modal simulate four_dof --out runs/four_dof --cubic-stiffness 1
      hybrid-modal simulate frame.toml --out runs/frame --refine 4 --pull 3:x:100 --sensor 2:x
    """
    from fe_models.files.dataset_file import DRAWING, dataset_in, save_dataset
    from hybrid.commands.models import open_model
    from hybrid.commands.recordings import Wishes, recordings_of

    wishes = Wishes(
        pull, sensor, realisations, cubic_stiffness, duration, step, sampling_rate, lowpass, noise, gravity, modal_model
    )
    with command_line(quiet) as result:
        results = dataset_in(out)
        subject = open_model(model, refine, [results], modal_model)
        recordings = recordings_of(model, subject, wishes, seed)()
        with results.replacing() as new:
            path = save_dataset(recordings, new)
        print(f"Recordings: {out / path.name}")
        if pictures:
            from fe_models.pictures.render import draw_structure  # graphics, only where they are needed

            with results.adding() as new:
                draw_structure(subject, new / DRAWING, recordings.sensors)
            print(f"Structure and sensors: {out / DRAWING}")
        result(out / path.name)
