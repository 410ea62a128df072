"""Draw the deformed shapes of a run: mode shapes, snapshots, initial deformation, animation."""

from enum import Enum
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from fe_models import render
from fe_models.dofs import FloatArray
from fe_models.errors import InputError, bad_input_exits
from fe_models.run_folder import Prediction, Run, load_run

FRAMES_PER_SECOND = 25.0


class FilmFormat(Enum):
    """File formats of the animation."""

    AUTO = "auto"
    MP4 = "mp4"
    GIF = "gif"


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
        content = load_run(run)
        drawn = draw_model(content, out)
        if content.prediction is not None:
            first = 1 / content.modes.frequencies[0]
            step = interval or first / snapshots
            drawn += draw_prediction(content, content.prediction, out, snapshots, step)
            drawn.append(draw_film(content, content.prediction, out, frames, film))
    print("Pictures:")
    width = max(len(str(path)) for path, _ in drawn)
    for path, meaning in drawn:
        print(f"  {path!s:<{width}}  {meaning}")
    if content.prediction is None:
        print("Only mode shapes: the folder holds no prediction.npz, which train_hybrid.py writes.")


def draw_model(run: Run, out: Path) -> list[tuple[Path, str]]:
    """Draw the mode shapes; return each path with what it shows."""
    *single, overview = render.draw_modes(run.model, run.modes, out)
    words = [
        (path, f"mode {number}, {frequency:.4g} Hz: the shape in which the structure vibrates at that frequency")
        for number, (path, frequency) in enumerate(zip(single, run.modes.frequencies, strict=True), start=1)
    ]
    return [*words, (overview, f"all {len(single)} mode shapes side by side")]


def draw_prediction(run: Run, prediction: Prediction, out: Path, snapshots: int, step: float) -> list[tuple[Path, str]]:
    """Draw snapshots ``step`` s apart and the initial deformation; return each path with what it shows."""
    time, unit, sensors = prediction.time, prediction.unit, prediction.sensors
    wanted = time[0] + step * np.arange(snapshots)
    rows = np.unique(np.abs(time[:, None] - wanted[wanted <= time[-1] + 1e-9]).argmin(axis=0))
    title = "Displacement of the whole structure by the hybrid model, first test window"
    path = render.draw_snapshots(
        run.model, prediction.hybrid[rows], time[rows], out / "snapshots.png", unit, title, sensors
    )
    drawn = [(path, "hybrid model: the whole structure at consecutive times of the first test window")]
    shapes: dict[str, FloatArray] = {"hybrid": prediction.hybrid[0], "FE": prediction.fe_initial}
    title, words = (
        "Initial deformation: hybrid model against FE model",
        "where the hybrid model departs from the FE model",
    )
    if prediction.truth is not None:
        shapes["truth"] = prediction.truth[0]
        words += ", and the simulated truth beneath"
    path = render.draw_comparison(run.model, shapes, out / "initial_deformation.png", unit, title, sensors)
    return [*drawn, (path, f"shape at the start of the window: {words}")]


def draw_film(run: Run, prediction: Prediction, out: Path, frames: int, film: FilmFormat) -> tuple[Path, str]:
    """Write the animation, at most ``frames`` long; return its path with what it shows."""
    if film is FilmFormat.MP4 and not render.mp4_works():
        raise InputError("--format mp4: ffmpeg does not run here; use --format gif, or reinstall imageio-ffmpeg")
    mp4 = film is FilmFormat.MP4 or (film is FilmFormat.AUTO and render.mp4_works())
    stride = -(-len(prediction.time) // frames)
    path = render.animate(
        run.model,
        prediction.hybrid[::stride],
        prediction.time[::stride],
        out / f"animation.{'mp4' if mp4 else 'gif'}",
        FRAMES_PER_SECOND,
        prediction.unit,
        "Motion by the hybrid model, first test window",
        prediction.sensors,
    )
    return path, "hybrid model: the motion over the first test window, exaggerated"


if __name__ == "__main__":
    app()
