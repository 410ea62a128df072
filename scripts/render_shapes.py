"""Draw the deformed shapes of a run: mode shapes, snapshots, initial deformation, animation."""

from pathlib import Path
from typing import Annotated

import typer

from fe_models.errors import InputError, bad_input_exits
from fe_models.files.run_folder import PREDICTION
from fe_models.pictures.run_pictures import FilmFormat, draw_run

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
    frames: Annotated[int, typer.Option(min=2, help="Most frames in the animation.")] = 250,
    film: Annotated[
        FilmFormat, typer.Option("--format", help="Animation as mp4 (small) or gif; auto: mp4 where it can be written.")
    ] = FilmFormat.AUTO,
) -> None:
    """Draw the deformed shapes of a run, without a screen.

    Of a model (build_fe_model.py): one picture a mode shape and an overview. Of a training (train_hybrid.py) also the
    displacement of the whole structure, decoded from the few sensors, over the first test window: snapshots, the
    initial deformation of the hybrid model against the FE model, and an animation.

    Displacements are exaggerated; each picture states by how much. Colour is the true size of the displacement, light
    grey the structure at rest.

    \b
    Examples:
      python scripts/build_fe_model.py bridge --out runs/bridge
      python scripts/render_shapes.py runs/bridge --out runs/bridge/pictures
      python scripts/render_shapes.py runs/hybrid --out pictures --format gif
    """
    with bad_input_exits():
        if interval is not None and not interval > 0:
            raise InputError(f"--interval {interval:g}: must be a time above 0 s")
        drawn = draw_run(run, out, snapshots, interval, frames, film)
    print("Pictures:")
    width = max(len(str(path)) for path, _ in drawn)
    for path, meaning in drawn:
        print(f"  {path!s:<{width}}  {meaning}")
    if not (run / PREDICTION).is_file():
        print("Only mode shapes: the folder holds no prediction.npz, which train_hybrid.py writes.")


if __name__ == "__main__":
    app()
