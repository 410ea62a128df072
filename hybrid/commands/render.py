"""The sub-command `render`: the deformed shapes of a run, drawn without a screen."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from hybrid.commands.console import command_line
from hybrid.commands.options import Quiet

Run = Annotated[
    Path, typer.Argument(help="Folder that 'hybrid-modal build', 'train' or 'predict' wrote.", show_default=False)
]
Out = Annotated[Path, typer.Option(help="Folder for the pictures; made where it is missing.", show_default=False)]
Snapshots = Annotated[int, typer.Option(min=1, help="Snapshots in the picture of consecutive times.")]
Interval = Annotated[
    float | None, typer.Option(help="Time (s) between snapshots. Left out: they span one period of the first mode.")
]
Frames = Annotated[
    int | None,
    typer.Option(min=2, help="Most frames in the animation. [default: 250; with --speed as many as it takes]"),
]
Film = Annotated[
    Literal["auto", "mp4", "gif"],
    typer.Option("--format", help="Animation as mp4 (small) or gif; auto: mp4 where it can be written."),
]
Scale = Annotated[
    float | None,
    typer.Option(
        help="How many times as large displacements are drawn. [default: the largest a twelfth of the structure]"
    ),
]
Speed = Annotated[
    float | None,
    typer.Option(
        help="Of the animation against real time, 0.1 ten times slower. [default: 10 s for the motion, or as much of "
        "its beginning as frames can show]"
    ),
]


def render(
    run: Run,
    out: Out,
    snapshots: Snapshots = 6,
    interval: Interval = None,
    frames: Frames = None,
    film: Film = "auto",
    scale: Scale = None,
    speed: Speed = None,
    quiet: Quiet = False,
) -> None:
    """Draw the deformed shapes of a run, without a screen.

    Of a model (hybrid-modal build): the structure with the numbers of its nodes and elements, one picture a mode shape
    and an overview. Of a training (hybrid-modal train) also the sensors on the structure, and its whole displacement,
    decoded from these few, over the first test window: snapshots, the initial deformation of the hybrid model against
    the FE model, and an animation.

    Displacements are exaggerated; each picture states by how much, and the animation how fast it runs. --scale is for
    displacements: mode shapes have no size of their own. Colour is the true size of the displacement, light grey the
    structure at rest.

    \b
    Examples:
      hybrid-modal render runs/bridge --out runs/bridge/pictures
      hybrid-modal render runs/hybrid --out pictures --format gif
      hybrid-modal render runs/hybrid --out pictures --scale 200 --speed 0.1
    """
    from fe_models.files.run_folder import PREDICTION
    from fe_models.pictures.run_pictures import FilmFormat, PictureOptions, draw_run

    with command_line(quiet) as result:
        drawn = draw_run(run, out, PictureOptions(snapshots, interval, frames, FilmFormat(film), scale, speed))
        print("Pictures:")
        width = max(len(str(path)) for path, _ in drawn)
        for path, meaning in drawn:
            print(f"  {path!s:<{width}}  {meaning}")
        if not (run / PREDICTION).is_file():
            print("Only mode shapes: the folder holds no prediction.npz, which hybrid-modal train writes.")
        result(out)
