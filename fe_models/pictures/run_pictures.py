"""All pictures of a run, each with what it shows in plain words."""

from dataclasses import dataclass
from enum import Enum
from math import inf
from pathlib import Path

import numpy as np

from fe_models.arrays import FloatArray, IntArray
from fe_models.errors import noting, raise_faults
from fe_models.files.result_set import ResultSet
from fe_models.files.run_folder import Prediction, Run, load_run, run_files
from fe_models.pictures import render
from fe_models.spectra import line_frequencies, power_spectrum

FRAMES_PER_SECOND = 25.0
FRAMES_A_PERIOD = 8  # of the fastest motion, at least: fewer do not show which way it goes
FILM_ENERGY_SHARE = 0.95  # of a motion, which a film is to show as it is
MAX_FRAMES = 250  # of a film, at most, where nothing else is asked for: ten seconds


class FilmFormat(Enum):
    """File formats of the animation."""

    AUTO = "auto"
    MP4 = "mp4"
    GIF = "gif"


Drawn = tuple[Path, str]
"""A picture's path and what it shows."""


@dataclass(frozen=True)
class PictureOptions:
    """How the motion of a run is drawn; None where the choice is left to the program.

    ``snapshots`` lie ``interval`` s apart [they span one period of the first mode]. Displacements are drawn ``scale``
    times as large [the largest at about a twelfth of the structure]. The film has at most ``frames`` [250, in which it
    shows the whole motion; with ``speed`` as many as that takes] and runs at ``speed`` times real time.
    """

    snapshots: int = 6
    interval: float | None = None
    frames: int | None = None
    film: FilmFormat = FilmFormat.AUTO
    scale: float | None = None
    speed: float | None = None

    def faults(self) -> list[str]:
        """Return a line for each value that cannot be drawn."""
        wishes = (
            ("interval", self.interval, "a time above 0 s"),
            ("scale", self.scale, "a factor above 0; 1 draws displacements to the scale of the structure"),
            ("speed", self.speed, "a factor above 0; 1 is real time, 0.1 ten times slower"),
        )
        faults = [
            f"--{name} {value:g}: must be {words}"
            for name, value, words in wishes
            if value is not None and not 0 < value < inf
        ]
        if self.film is FilmFormat.MP4 and not render.mp4_works():
            faults.append("--format mp4: ffmpeg does not run here; use --format gif, or reinstall imageio-ffmpeg")
        return faults


def draw_run(folder: Path, out: Path, options: PictureOptions = PictureOptions()) -> list[Drawn]:
    """Draw what the run in ``folder`` holds: structure, mode shapes and, after a training, the predicted displacements.

    Older pictures in ``out`` are replaced together; the film, which takes long, comes after the others. `InputError`
    carries all that is missing, and what is wrong with the options or with ``out``.
    """
    results, faults = pictures_in(out), options.faults()
    noting(faults, "--out", results.check, run_files(folder))
    content = noting(faults, "", load_run, folder)
    raise_faults(faults)
    assert content is not None  # else there were faults
    with results.replacing() as new:
        drawn = draw_model(content, new)
        if content.prediction is not None:
            drawn += draw_prediction(content, content.prediction, new, options)
    if content.prediction is not None:
        with results.adding() as new:
            drawn.append(draw_film(content, content.prediction, new, options))
    return [(out / path.name, meaning) for path, meaning in drawn]


def pictures_in(folder: Path) -> ResultSet:
    """Return what `draw_run` leaves in ``folder``."""
    stills = ("structure.png", "mode_[0-9]*.png", "modes.png", "snapshots.png", "initial_deformation.png")
    return ResultSet(folder, "render", (*stills, "animation.mp4", "animation.gif"))


def draw_model(run: Run, out: Path) -> list[Drawn]:
    """Draw the structure, with its sensors where they are known, and the mode shapes; return what each path shows."""
    sensors = run.prediction.sensors if run.prediction else ()
    structure = render.draw_structure(run.model, out / "structure.png", sensors)
    *single, overview = render.draw_modes(run.model, run.modes, out)
    words = [
        (path, f"mode {number}, {frequency:.4g} Hz: the shape in which the structure vibrates at that frequency")
        for number, (path, frequency) in enumerate(zip(single, run.modes.frequencies, strict=True), start=1)
    ]
    words.append((structure, f"nodes and elements with their numbers{', sensors with arrows' if sensors else ''}"))
    return [*words, (overview, f"all {len(single)} mode shapes side by side")]


def draw_prediction(run: Run, prediction: Prediction, out: Path, options: PictureOptions) -> list[Drawn]:
    """Draw snapshots and the initial deformation; return each path with what it shows."""
    time, unit, sensors = prediction.time, prediction.unit, prediction.sensors
    step = options.interval or 1 / run.modes.frequencies[0] / options.snapshots
    wanted = time[0] + step * np.arange(options.snapshots)
    rows = np.unique(np.abs(time[:, None] - wanted[wanted <= time[-1] + 1e-9]).argmin(axis=0))
    title = "Displacement of the whole structure by the hybrid model"
    path = render.draw_snapshots(
        run.model, prediction.hybrid[rows], time[rows], out / "snapshots.png", unit, title, sensors, options.scale
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
    path = render.draw_comparison(
        run.model, shapes, out / "initial_deformation.png", unit, title, sensors, options.scale
    )
    return [*drawn, (path, f"shape at the start of the window: {words}")]


def draw_film(run: Run, prediction: Prediction, out: Path, options: PictureOptions) -> Drawn:
    """Write the animation; return its path with what it shows."""
    mp4 = options.film is FilmFormat.MP4 or (options.film is FilmFormat.AUTO and render.mp4_works())
    time = prediction.time
    rows, fps = film_rows(time, options.frames, options.speed, fastest_motion(prediction.hybrid, time))
    path = render.animate(
        run.model,
        prediction.hybrid[rows],
        time[rows],
        out / f"animation.{'mp4' if mp4 else 'gif'}",
        fps,
        prediction.unit,
        "Motion of the whole structure by the hybrid model",
        prediction.sensors,
        options.scale,
    )
    cut = len(rows) > 1 and len(time) - rows[-1] > rows[1]
    length = f", its first {time[rows[-1]] - time[0]:.3g} s" if cut else ""
    return path, f"hybrid model: the motion{length}, exaggerated"


def fastest_motion(field: FloatArray, time: FloatArray) -> float:
    """Return the frequency (Hz) up to which a motion (time, dof) has nearly all of its energy."""
    if len(time) < 2:
        return 0.0
    power = np.cumsum(power_spectrum(field).sum(axis=1))
    line = int(np.searchsorted(power, FILM_ENERGY_SHARE * power[-1]))
    return float(line_frequencies(len(time), (len(time) - 1) / float(time[-1] - time[0]))[line])


def film_rows(
    time: FloatArray, frames: int | None, speed: float | None, fastest: float = 0.0
) -> tuple[IntArray, float]:
    """Return the samples of ``time`` (time,) that a film shows, and how many of them a second.

    At a given ``speed`` every stride-th sample stands for stride step / speed seconds, as near to 1/25 s as samples
    allow; the film ends where ``frames`` are used up. Without one it shows all of the time in so many frames; where
    these are too few for the ``fastest`` motion (Hz), which would seem to stand still or go backwards, the beginning.
    """
    if len(time) < 2:
        return np.arange(len(time)), FRAMES_PER_SECOND
    step = float(time[-1] - time[0]) / (len(time) - 1)
    if speed is None:
        most = frames or MAX_FRAMES
        longest = max(1, int(1 / (FRAMES_A_PERIOD * fastest * step))) if fastest > 0 else len(time)
        return np.arange(0, len(time), min(-(-len(time) // most), longest))[:most], FRAMES_PER_SECOND
    stride = max(1, round(speed / (step * FRAMES_PER_SECOND)))
    return np.arange(0, len(time), stride)[:frames], speed / (step * stride)
