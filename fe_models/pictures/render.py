"""Paints pictures and films of deformed shapes with PyVista, off screen; the only module that needs graphics.

Every function takes displacements over all degrees of freedom of the model, (dof,) or (frame, dof), in m or relative,
which it draws ``scale`` times as large (None: so that the largest is plain to see), writes whole files, closes what it
opened and returns the paths. `InputError` names a displacement that does not fit.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.errors import InputError, raise_faults
from fe_models.files.atomic import writing
from fe_models.linear import LinearModel, ModalModel
from fe_models.pictures.captions import digits, exaggeration, pace, readable
from fe_models.pictures.drawing import Bytes, Color, Picture, Text, merge
from fe_models.pictures.figure import Figure, Panel, Shape
from fe_models.pictures.geometry import Outline, choose_scale, largest_displacement, outline
from fe_models.pictures.layout import arranged, compose, figure_of
from fe_models.pictures.panels import BEAM_WIDTH
from fe_models.pictures.structure_drawing import structure_picture
from fe_models.progress import progress_bar
from fe_models.recordings import Sensor
from fe_models.structure import Structure

Model = Structure | LinearModel

# Colour and relative width of each shape of a comparison. The widths are nested, so that shapes which coincide are all
# seen; dark blue, orange and light green are distinguished by the colour-blind and in grey.
NAMED_STYLES: dict[str, tuple[Color, float]] = {
    "truth": ((150, 205, 150), 1.6),
    "FE": ((235, 140, 20), 0.85),
    "hybrid": ((0, 70, 160), 0.35),
}
OTHER_STYLES: tuple[tuple[Color, float], ...] = (((170, 60, 140), 0.7), ((90, 90, 90), 0.3))
FILM_WIDTH = 1280  # px
GIF_TICK = 0.01  # s: in whole ones .gif files keep how long a picture stands


def draw_structure(model: Model, path: Path, sensors: Sequence[Sensor] = ()) -> Path:
    """Write the drawing of a model before any analysis: numbered nodes and elements, supports, masses, sensors."""
    _on(outline(model), sensors)
    return _write(structure_picture(model, tuple(sensors)), path)


def draw_modes(model: Model, modes: ModalModel, folder: Path, sensors: Sequence[Sensor] = ()) -> list[Path]:
    """Write ``mode_01.png``, ... and the overview ``modes.png``; each mode relative to its largest displacement."""
    shape = outline(model)
    panels = []
    for number, (frequency, ratio, column) in enumerate(
        zip(modes.frequencies, modes.damping_ratio, modes.shapes.T, strict=True), start=1
    ):
        largest = largest_displacement(shape, [column])
        label = f"Mode {number}: {digits(frequency, 4)} Hz, damping ratio {100 * ratio:.1f} %"
        panels.append(Panel(label, (Shape(column / largest if largest > 0 else column),)))
    if not panels:
        raise InputError("There is no mode to draw: give a modal model with at least one mode.")
    written = []
    with progress_bar("drawing modes", len(panels), "mode") as bar:
        for number, panel in enumerate(panels, start=1):
            figure = _mode_figure(shape, [panel], panel.label, sensors)
            written.append(_write(compose(figure, (Panel("", panel.shapes),)), folder / f"mode_{number:02d}.png"))
            bar.update()
    title = f"The first {len(panels)} natural modes" if len(panels) > 1 else "The first natural mode"
    overview = _mode_figure(shape, panels, title, sensors)
    written.append(_write(compose(overview, tuple(panels)), folder / "modes.png"))
    return written


def draw_snapshots(
    model: Model,
    displacements: FloatArray,
    times: FloatArray,
    path: Path,
    unit: str = "m",
    title: str = "Deformed shape at consecutive times",
    sensors: Sequence[Sensor] = (),
    scale: float | None = None,
) -> Path:
    """Write one picture of ``displacements`` (frame, dof) at ``times`` (frame,) s, at one scale and colour range."""
    panels = _timed_panels(displacements, times)
    figure = _figure(model, panels, title, unit, sensors, scale)
    if len(panels) > 1:
        figure = replace(figure, note=f"{figure.note}; the same scale and colours at all times")
    return _write(compose(figure, panels), path)


def draw_comparison(
    model: Model,
    shapes: Mapping[str, FloatArray],
    path: Path,
    unit: str = "m",
    title: str = "Initial deformation: hybrid model against FE model",
    sensors: Sequence[Sensor] = (),
    scale: float | None = None,
) -> Path:
    """Write the named ``shapes`` (dof,) over each other, at one scale, each in its colour with its largest value."""
    if not shapes:
        raise InputError("There is no shape to compare: give at least one, by name.")
    others = iter(OTHER_STYLES * len(shapes))
    styles = {name: NAMED_STYLES.get(name) or next(others) for name in shapes}
    widest_first = sorted(shapes, key=lambda name: -styles[name][1])
    panels: tuple[Panel, ...] = (Panel("", tuple(Shape(shapes[name], *styles[name]) for name in widest_first)),)
    figure = _figure(model, panels, title, unit, sensors, scale)
    if figure.outline.masses:  # masses would hide each other: one row a shape
        panels = tuple(Panel(name, (Shape(shapes[name], styles[name][0]),)) for name in shapes)
    factor, unit_name = readable(figure.largest, unit)
    named = []
    for name, (color, width) in styles.items():
        largest = digits(factor * largest_displacement(figure.outline, [shapes[name]]), 3)
        named.append((f"{name} (largest {largest} {unit_name})", color, BEAM_WIDTH * width))
    return _write(compose(replace(figure, named=tuple(named)), panels), path)


def animate(
    model: Model,
    displacements: FloatArray,
    times: FloatArray,
    path: Path,
    fps: float = 25.0,
    unit: str = "m",
    title: str = "Motion of the structure",
    sensors: Sequence[Sensor] = (),
    scale: float | None = None,
) -> Path:
    """Write a film (.mp4, or .gif) of ``displacements`` (frame, dof), one picture a frame, ``fps`` of them a second."""
    panels = _timed_panels(displacements, times)
    figure = _figure(model, panels, title, unit, sensors, scale)
    if path.suffix == ".gif":
        fps = 1 / (GIF_TICK * max(2, round(1 / (GIF_TICK * fps))))  # shorter than two ticks many programs slow down
    note = f"{figure.note}; {pace(len(times), fps, float(times[-1] - times[0]))}"
    figure = replace(figure, note=note, width=FILM_WIDTH)
    plan = arranged(figure, panels[:1])
    size = compose(figure, panels[:1], plan)
    bar = progress_bar(f"drawing {path.name}", len(panels), "frame")
    with bar, writing(path) as temporary, _film(temporary, fps) as film, _painter(size, "msaa") as paint:
        for panel in panels:
            film.append_data(paint(compose(figure, (panel,), plan)))
            bar.update()
    return path


def mp4_works() -> bool:
    """Whether films can be written as .mp4 here, which takes the program ffmpeg; .gif always works."""
    import imageio.plugins.ffmpeg

    try:
        imageio.plugins.ffmpeg.get_version()
    except (RuntimeError, OSError):
        return False
    return True


def _timed_panels(displacements: FloatArray, times: FloatArray) -> tuple[Panel, ...]:
    """Return a panel for each of the ``displacements`` (frame, dof); `InputError` unless there is one for each time."""
    frames = np.asarray(displacements, dtype=float)
    if frames.ndim != 2 or len(frames) == 0 or len(frames) != len(times):
        raise InputError(
            f"Displacements of shape {frames.shape} do not fit {len(times)} times: give (frame, dof), one frame a time."
        )
    return tuple(Panel(f"t = {time:.3f} s", (Shape(frame),)) for frame, time in zip(frames, times, strict=True))


def _figure(
    model: Model, panels: Sequence[Panel], title: str, unit: str, sensors: Sequence[Sensor], wanted: float | None
) -> Figure:
    """Return what ``panels`` share: the scale ``wanted``, or one that fits the largest displacement, and colours."""
    shape = outline(model)
    frames = _frames(panels)
    largest = largest_displacement(shape, frames)
    scale = choose_scale(largest, shape.size) if wanted is None else wanted
    note = exaggeration(scale, largest, unit)
    return figure_of(shape, frames, scale, largest, title, note, unit, _on(shape, sensors))


def _mode_figure(shape: Outline, panels: Sequence[Panel], title: str, sensors: Sequence[Sensor]) -> Figure:
    """Return what pictures of modes share; each is scaled to a largest displacement of 1 already."""
    scale = choose_scale(1.0, shape.size)
    note = f"relative to the largest displacement of the mode, which is drawn as {scale:g} m"
    return figure_of(shape, _frames(panels), scale, 1.0, title, note, "1", _on(shape, sensors))


def _on(shape: Outline, sensors: Sequence[Sensor]) -> tuple[Sensor, ...]:
    """Return ``sensors``; `InputError` where one sits at a node that the model lacks."""
    raise_faults(
        f"Sensor {sensor.name!r} cannot be drawn at node {sensor.node}: the model has {len(shape.coordinates)} nodes."
        for sensor in sensors
        if not 1 <= sensor.node <= len(shape.coordinates)
    )
    return tuple(sensors)


def _frames(panels: Sequence[Panel]) -> list[FloatArray]:
    return [drawn.displacement for panel in panels for drawn in panel.shapes]


def _write(picture: Picture, path: Path) -> Path:
    """Paint ``picture`` into the .png file ``path``."""
    import imageio.v3

    with _painter(picture) as paint, writing(path) as temporary:
        imageio.v3.imwrite(temporary, paint(picture))
    return path


@contextmanager
def _film(path: Path, fps: float) -> Iterator[Any]:
    """Give a writer of frames for .mp4 or .gif."""
    import imageio.v2

    if path.suffix == ".gif":
        options: dict[str, Any] = {"duration": 1000 / fps, "loop": 0}
    else:
        options = {"fps": fps, "codec": "libx264", "macro_block_size": 2, "quality": 7}
    writer = imageio.v2.get_writer(path, **options)
    try:
        yield writer
    finally:
        writer.close()


@contextmanager
def _painter(size: Picture, smoothing: Literal["ssaa", "msaa"] = "ssaa") -> Iterator[Any]:
    """Give a function that paints a `Picture` of this size as (height, width, 3) bytes; one window serves many.

    ``smoothing`` of edges: "ssaa" is the finest, "msaa" three times faster.
    """
    import pyvista

    with pyvista.vtk_verbosity("error"):  # else VTK reports on every machine without a screen that it has none
        plotter = pyvista.Plotter(off_screen=True, window_size=(size.width, size.height))
    plotter.set_background("white")
    plotter.enable_anti_aliasing(smoothing)
    camera = plotter.camera
    middle = (size.width / 2, size.height / 2)
    camera.parallel_projection, camera.up = True, (0, 1, 0)
    camera.focal_point, camera.position = (*middle, 0.0), (*middle, 1000.0)
    camera.parallel_scale = size.height / 2  # so that one unit is one pixel

    def paint(picture: Picture) -> Bytes:
        plotter.clear_actors()
        plotter.add_mesh(_mesh(picture), scalars="color", rgb=True, lighting=False, reset_camera=False, render=False)
        for text in picture.texts:
            plotter.add_actor(_text(text), reset_camera=False, render=False)
        camera.clipping_range = (1.0, 2000.0)
        plotter.render()
        image: Bytes = plotter.screenshot(return_img=True)
        return image

    try:
        yield paint
    finally:
        plotter.close()


def _mesh(picture: Picture) -> Any:
    """Return all patches as one mesh; each lies a little nearer to the viewer than those before it."""
    import pyvista

    whole = merge(picture.patches)
    depth = np.repeat(np.linspace(0.0, 100.0, len(picture.patches)), [len(part.points) for part in picture.patches])
    faces = np.insert(whole.triangles, 0, 3, axis=1).ravel()
    mesh = pyvista.PolyData(np.column_stack([whole.points, depth]), faces=faces)
    mesh["color"] = whole.colors
    return mesh


def _text(text: Text) -> Any:
    """Return ``text`` as VTK draws it, in a font that comes with matplotlib and knows all signs and letters."""
    import pyvista
    from matplotlib import get_data_path

    literal = text.text.replace("$", r"\$")  # else VTK reads a formula between two of them
    actor = pyvista.Text(literal, position=(text.x, text.y))
    look = actor.prop
    look.set_font_file(str(Path(get_data_path(), "fonts/ttf", f"DejaVuSans{'-Bold' * text.bold}.ttf")))
    look.font_size = text.size
    look.color = tuple(channel / 255 for channel in text.color)
    if text.boxed:
        look.background_color, look.background_opacity = "white", 0.75
    look.justification_horizontal, look.justification_vertical = text.align, "center"
    return actor
