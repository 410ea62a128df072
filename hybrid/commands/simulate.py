"""The sub-command `simulate`: recordings of a structure, with what its linear model lacks."""

from hybrid.commands.console import command_line
from hybrid.commands.option_groups import with_option_groups
from hybrid.commands.options import Drawing, Model, Out, Quiet, Refine, Seed
from hybrid.commands.recording_options import NONE_GIVEN, RecordingOptions


@with_option_groups
def simulate(
    model: Model,
    out: Out,
    refine: Refine = None,
    given: RecordingOptions = NONE_GIVEN,
    seed: Seed = 0,
    pictures: Drawing = True,
    quiet: Quiet = False,
) -> None:
    """Simulate recordings of a structure: OUT/dataset.toml, to train on or to diagnose.

    OUT/sensors.png shows the structure with the numbers of its nodes and elements, and each sensor as an arrow.

    Simulated recordings have what the linear model lacks. Frames come to rest under gravity, prestress and the pulls,
    which then let go: large displacements, P-delta, slack cables, noise. A recording starts 0.1 s after the release,
    when its jump, smeared by the low-pass, has died down. Matrices, plane or in space, move linearly, by their lowest
    modes, after pulls are let go or with their base. Of several recordings the last is for testing.
    Chains start from random states, and the last fifth of their motions is for testing; four_dof gives the data of the
    paper (its own numbers with seed 0, 1000 motions).

    \b
    Options that go with some structures only:
      four_dof          --realisations, --cubic-stiffness, --modal-model; none of those below
      other chains      --realisations, --step
      frames            --pull, --step, --gravity
      matrices          --pull
      all but four_dof  --sensor, --duration, --sampling-rate, --lowpass, --noise, --base (with which no --pull,
                        --duration, --step, --gravity or --realisations go)

    \b
    Examples:
      hybrid-modal simulate bridge --out runs/data --pull 19:y:-9.81 --pull 9:y:-5+21:y:-5
      hybrid-modal simulate four_dof --out runs/four_dof --cubic-stiffness 1
      hybrid-modal simulate frame.toml --out runs/frame --refine 4 --pull 3:x:100 --sensor 2:x
    """
    from fe_models.files.dataset_file import DRAWING, dataset_in, write_dataset
    from hybrid.commands.any_recordings import recordings_of
    from hybrid.commands.models import open_model

    with command_line(quiet) as result:
        results = dataset_in(out)
        subject = open_model(model, refine, [results], given.modal_model)
        recordings = recordings_of(model, subject, given, seed)()
        with results.replacing() as new:
            path = write_dataset(recordings, new)
        print(f"Recordings: {out / path.name}")
        if pictures:
            from fe_models.pictures.render import draw_structure  # graphics, only where they are needed

            with results.adding() as new:
                draw_structure(subject, new / DRAWING, recordings.sensors)
            print(f"Structure and sensors: {out / DRAWING}")
        result(out / path.name)
