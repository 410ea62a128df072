"""All pictures of a run, each with what it shows in plain words."""

from enum import Enum
from pathlib import Path

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.errors import InputError
from fe_models.files.run_folder import Prediction, Run, load_run
from fe_models.pictures import render

FRAMES_PER_SECOND = 25.0


class FilmFormat(Enum):
    """File formats of the animation."""

    AUTO = "auto"
    MP4 = "mp4"
    GIF = "gif"


Drawn = tuple[Path, str]
"""A picture's path and what it shows."""


def draw_run(
    folder: Path,
    out: Path,
    snapshots: int = 6,
    interval: float | None = None,
    frames: int = 250,
    film: FilmFormat = FilmFormat.AUTO,
) -> list[Drawn]:
    """Draw what the run in ``folder`` holds: mode shapes and, after a training, the predicted displacements.

    ``snapshots`` that lie ``interval`` s apart (left out: they span one period of the first mode), and an animation of
    at most ``frames``. `InputError` carries all that is missing.
    """
    content = load_run(folder)
    drawn = draw_model(content, out)
    if content.prediction is None:
        return drawn
    step = interval or 1 / content.modes.frequencies[0] / snapshots
    drawn += draw_prediction(content, content.prediction, out, snapshots, step)
    return [*drawn, draw_film(content, content.prediction, out, frames, film)]


def draw_model(run: Run, out: Path) -> list[Drawn]:
    """Draw the mode shapes; return each path with what it shows."""
    *single, overview = render.draw_modes(run.model, run.modes, out)
    words = [
        (path, f"mode {number}, {frequency:.4g} Hz: the shape in which the structure vibrates at that frequency")
        for number, (path, frequency) in enumerate(zip(single, run.modes.frequencies, strict=True), start=1)
    ]
    return [*words, (overview, f"all {len(single)} mode shapes side by side")]


def draw_prediction(run: Run, prediction: Prediction, out: Path, snapshots: int, step: float) -> list[Drawn]:
    """Draw snapshots ``step`` s apart and the initial deformation; return each path with what it shows."""
    time, unit, sensors = prediction.time, prediction.unit, prediction.sensors
    wanted = time[0] + step * np.arange(snapshots)
    rows = np.unique(np.abs(time[:, None] - wanted[wanted <= time[-1] + 1e-9]).argmin(axis=0))
    title = "Displacement of the whole structure by the hybrid model"
    path = render.draw_snapshots(
        run.model, prediction.hybrid[rows], time[rows], out / "snapshots.png", unit, title, sensors
    )
    drawn = [(path, "hybrid model: the whole structure at consecutive times")]
    shapes: dict[str, FloatArray] = {"hybrid": prediction.hybrid[0], "FE": prediction.fe_initial}
    title, words = (
        "Initial deformation, as each model reads it from the same first samples",
        "as the hybrid model and as the FE model alone read it from the same first samples",
    )
    if prediction.truth is not None:
        shapes["truth"] = prediction.truth[0]
        words += ", and the simulated truth beneath"
    path = render.draw_comparison(run.model, shapes, out / "initial_deformation.png", unit, title, sensors)
    return [*drawn, (path, f"shape at the start of the window: {words}")]


def draw_film(run: Run, prediction: Prediction, out: Path, frames: int, film: FilmFormat) -> Drawn:
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
        "Motion of the whole structure by the hybrid model",
        prediction.sensors,
    )
    return path, "hybrid model: the motion, exaggerated"
