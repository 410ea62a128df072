"""Draw the deformed shapes of a run: mode shapes, snapshots, initial deformation, animation."""

from pathlib import Path
from typing import Annotated

import typer

from fe_models.errors import bad_input_exits
from fe_models.files.run_folder import PREDICTION
from fe_models.pictures.run_pictures import FilmFormat, PictureOptions, draw_run

app = typer.Typer(add_completion=False, rich_markup_mode=None, pretty_exceptions_enable=False)


@app.command()
def main(
    run: Annotated[Path, typer.Argument(help="Folder that build_fe_model.py or train_hybrid.py wrote.")],
    out: Annotated[Path, typer.Option(help="Folder for the pictures; made where it is missing.")],
    snapshots: Annotated[int, typer.Option(min=1, help="Snapshots in the picture of consecutive times.")] = 6,
    interval: Annotated[
        float | None,
        typer.Option(help="Time (s) between snapshots. Left out: they span one period of the first mode."),
    ] = None,
    frames: Annotated[
        int | None,
        typer.Option(min=2, help="Most frames in the animation. [default: 250; with --speed as many as it takes]"),
    ] = None,
    film: Annotated[
        FilmFormat, typer.Option("--format", help="Animation as mp4 (small) or gif; auto: mp4 where it can be written.")
    ] = FilmFormat.AUTO,
    scale: Annotated[
        float | None,
        typer.Option(
            help="How many times as large displacements are drawn. [default: the largest a twelfth of the structure]"
        ),
    ] = None,
    speed: Annotated[
        float | None,
        typer.Option(help="Of the animation against real time, 0.1 ten times slower. [default: 10 s for the motion]"),
    ] = None,
) -> None:
    """Draw the deformed shapes of a run, without a screen.

    Of a model (build_fe_model.py): one picture a mode shape and an overview. Of a training (train_hybrid.py) also the
    displacement of the whole structure, decoded from the few sensors, over the first test window: snapshots, the
    initial deformation of the hybrid model against the FE model, and an animation.

    Displacements are exaggerated; each picture states by how much, and the animation how fast it runs. --scale is for
    displacements: mode shapes have no size of their own. Colour is the true size of the displacement, light
    grey the structure at rest.

    \b
    Examples:
      python scripts/build_fe_model.py bridge --out runs/bridge
      python scripts/render_shapes.py runs/bridge --out runs/bridge/pictures
      python scripts/render_shapes.py runs/hybrid --out pictures --format gif
      python scripts/render_shapes.py runs/hybrid --out pictures --scale 200 --speed 0.1
    """
    with bad_input_exits():
        drawn = draw_run(run, out, PictureOptions(snapshots, interval, frames, film, scale, speed))
    print("Pictures:")
    width = max(len(str(path)) for path, _ in drawn)
    for path, meaning in drawn:
        print(f"  {path!s:<{width}}  {meaning}")
    if not (run / PREDICTION).is_file():
        print("Only mode shapes: the folder holds no prediction.npz, which train_hybrid.py writes.")


if __name__ == "__main__":
    app()
