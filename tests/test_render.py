"""Pictures hold all they show, state their scale, tell shapes apart; files are whole; bad input is named."""

import subprocess
import sys
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import imageio.v3
import numpy as np
import pytest
from numpy.typing import NDArray

from fe_models.arrays import FloatArray
from fe_models.built_in.bridge import bridge
from fe_models.built_in.four_dof import four_dof
from fe_models.dofs import structure_dofs
from fe_models.errors import InputError
from fe_models.linear import ModalModel
from fe_models.pictures import render, symbols
from fe_models.pictures.captions import digits, exaggeration, pace, readable
from fe_models.pictures.drawing import LIGHT, RAMP, Picture, Text, ramp, stroke
from fe_models.pictures.figure import Figure, Panel, Shape
from fe_models.pictures.geometry import choose_scale, largest_displacement, nodal_motion, outline
from fe_models.pictures.layout import arranged, compose, figure_of
from fe_models.pictures.legend import nice_step
from fe_models.pictures.render import NAMED_STYLES, animate, draw_comparison, draw_modes, draw_snapshots, mp4_works
from fe_models.recordings import Sensor
from fe_models.sections import Section
from fe_models.structure import Beam, Cable, Direction, Spring, Structure, Support

ROOT = Path(__file__).parent.parent
STEEL = Section("steel", 2.1e11, 7850.0, 1e-4, 1e-9)
SENSORS = (
    Sensor("A1", 2, "x", "acceleration", "1"),
    Sensor("A2", 3, "y", "acceleration", "1", role="held_out"),
)


def portal() -> Structure:
    """Columns, a beam, a brace, a spring to ground; one clamped, one pinned foot."""
    return Structure(
        name="portal",
        nodes=((0.0, 0.0), (0.0, 3.0), (4.0, 3.0), (4.0, 0.0)),
        elements=(
            Beam((1, 2), STEEL, group="column"),
            Beam((2, 3), STEEL, group="beam"),
            Beam((4, 3), STEEL, group="column"),
            Cable((1, 3), STEEL, group="brace"),
            Spring((3,), "x", 10.0),
        ),
        supports=(Support(1, ("x", "y", "rz")), Support(4, ("x", "y"))),
    )


def random_frames(structure: Structure, count: int, size: float = 1e-3) -> FloatArray:
    dofs = structure_dofs(structure)
    return np.random.default_rng(2).normal(scale=size, size=(count, len(dofs))) * dofs.free


def shared(structure: Structure, frames: FloatArray, sensors: tuple[Sensor, ...] = ()) -> Figure:
    shape = outline(structure)
    largest = largest_displacement(shape, frames)
    scale = choose_scale(largest, shape.size)
    return figure_of(shape, list(frames), scale, largest, "Title", exaggeration(scale, largest, "m"), sensors=sensors)


def picture_of(structure: Structure, count: int, sensors: tuple[Sensor, ...] = ()) -> Picture:
    frames = random_frames(structure, count)
    panels = tuple(Panel(f"Mode {i}: 11.25 Hz, damping ratio 1.0 %", (Shape(frame),)) for i, frame in enumerate(frames))
    return compose(shared(structure, frames, sensors), panels)


def count_color(image: NDArray[np.uint8], color: tuple[int, ...], tolerance: int = 6) -> int:
    return int((np.abs(image[..., :3].astype(int) - color).max(axis=-1) <= tolerance).sum())


def check_margins(image: NDArray[np.uint8], margin: int = 12) -> None:
    """Nothing is cropped: all that is drawn keeps off the edges; and nothing is blank."""
    assert (image < 128).any(axis=-1).mean() > 0.005  # a few thin lines and texts already fill 1 %
    for edge in (image[:margin], image[-margin:], image[:, :margin], image[:, -margin:]):
        assert (edge == 255).all()


# --- layout, without graphics ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("count", [1, 2, 5, 10])
@pytest.mark.parametrize("structure", [portal(), bridge(), four_dof(), bridge().refined(3)], ids=lambda s: s.name)
def test_everything_lies_within_the_picture(structure: Structure, count: int) -> None:
    picture = picture_of(structure, count)
    points = np.vstack([patch.points for patch in picture.patches])
    assert (points.min(axis=0) >= 15).all()
    assert (points.max(axis=0) <= np.array([picture.width, picture.height]) - 15).all()
    for text in picture.texts:
        left = text.x - {"left": 0.0, "center": text.width / 2, "right": text.width}[text.align]
        assert left >= 10
        assert left + text.width <= picture.width - 10, text.text
        assert text.size / 2 <= text.y <= picture.height - text.size / 2


def mast() -> Structure:
    """Twenty times as high as it is wide, as its feet are."""
    nodes = (*((0.0, 5.0 * level) for level in range(13)), (-1.5, 0.0), (1.5, 0.0))
    beams = tuple(Beam((level, level + 1), STEEL) for level in range(1, 13))
    held = tuple(Support(node, ("x", "y", "rz")) for node in (1, 14, 15))
    return Structure("mast", nodes, (*beams, Cable((7, 14), STEEL), Cable((7, 15), STEEL)), supports=held)


def girder() -> Structure:
    nodes = tuple((5.0 * place, 0.0) for place in range(21))
    beams = tuple(Beam((place, place + 1), STEEL) for place in range(1, 21))
    return Structure("girder", nodes, beams, supports=(Support(1, ("x", "y")), Support(21, ("y",))))


def accelerometers(*places: tuple[int, Direction], name: str = "A") -> tuple[Sensor, ...]:
    return tuple(Sensor(f"{name}{i}", node, way, "acceleration", "1") for i, (node, way) in enumerate(places, start=1))


SENSED = {  # structures of all proportions, with sensors at the ends, several at a node, side by side, and long names
    "portal": (portal(), accelerometers((2, "x"), (2, "y"), (2, "x"), (3, "x"), (3, "y"))),
    "mast": (mast(), accelerometers((13, "x"), (13, "y"), (12, "x"), (7, "x"), name="accelerometer ")),
    "girder": (girder(), accelerometers(*((node, "y") for node in range(2, 21, 2)), name="accelerometer ")),
    "bridge": (bridge(), accelerometers(*((node, "y") for node in (5, 9, 12, 13, 15, 18)), (40, "x"), (53, "x"))),
    "four_dof": (four_dof(), accelerometers(*((node, "x") for node in (1, 2, 3, 4, 4)))),
}


def box(text: Text) -> tuple[float, float, float, float]:
    left = text.x - {"left": 0.0, "center": text.width / 2, "right": text.width}[text.align]
    return left, left + text.width, text.y - text.size / 2, text.y + text.size / 2


@pytest.mark.parametrize("count", [1, 6, 10])
@pytest.mark.parametrize("name", SENSED)
def test_texts_do_not_overlap_nor_leave_the_picture(name: str, count: int) -> None:
    """In one panel and between neighbouring ones, whatever the proportions of the structure."""
    picture = picture_of(SENSED[name][0], count, SENSED[name][1])
    boxes = [(text.text, *box(text)) for text in picture.texts]
    for i, (words, a, b, c, d) in enumerate(boxes):
        assert a >= 10, words
        assert b <= picture.width - 10, words
        assert d <= picture.height - 10, words
        for other, e, f, g, h in boxes[:i]:
            assert b <= e or f <= a or d <= g or h <= c, f"{words!r} overlaps {other!r}"


def test_names_of_sensors_move_with_their_nodes_through_a_film() -> None:
    structure, sensors = SENSED["bridge"]
    frames = random_frames(structure, 4)
    figure = shared(structure, frames, sensors)
    panels = [Panel("t = 0.1 s", (Shape(frame),)) for frame in frames]
    plan = arranged(figure, panels[:1])
    pictures = [compose(figure, (panel,), plan) for panel in panels]
    assert len({(picture.width, picture.height) for picture in pictures}) == 1
    for sensor in sensors:
        motion = [nodal_motion(figure.outline, frame)[sensor.node - 1, :2] for frame in frames]
        names = [np.array([t.x, t.y]) for picture in pictures for t in picture.texts if t.text == sensor.name]
        off = np.array(names) - plan.factor * figure.scale * np.array(motion)
        np.testing.assert_allclose(off, np.broadcast_to(off[0], off.shape), atol=1e-6)  # px: rounding only


@pytest.mark.parametrize("count", [2, 9])
@pytest.mark.parametrize("structure", [portal(), four_dof()], ids=lambda s: s.name)
def test_labels_stand_free_of_the_structure(structure: Structure, count: int) -> None:
    picture = picture_of(structure, count)
    points = np.vstack([patch.points for patch in picture.patches])
    for text in picture.texts:
        if text.text.startswith("Mode"):
            x, y = points.T
            inside = (x > text.x) & (x < text.x + text.width) & (np.abs(y - text.y) < text.size / 2)
            assert not inside.any(), text.text


def test_shapes_are_drawn_where_the_stated_exaggeration_puts_them() -> None:
    structure = Structure("bar", ((0.0, 0.0), (2.0, 0.0)), (Beam((1, 2), STEEL),))
    tip = np.array([0.0, 0.0, 0.0, 0.0, 0.003, 0.0])
    figure = shared(structure, tip[None])
    assert figure.scale == 50.0
    picture = compose(figure, (Panel("", (Shape(tip, (255, 0, 0)),)),))
    color = np.vstack([patch.colors for patch in picture.patches])
    points = np.vstack([patch.points for patch in picture.patches])
    rest, moved = points[(color == LIGHT).all(axis=1)], points[(color == (255, 0, 0)).all(axis=1)]
    rest = rest[rest[:, 1] > 160]  # not the sample in the legend
    pixels_per_metre = (np.ptp(rest[:, 0]) - 8) / 2.0  # the line, 8 px wide, has round ends
    rise = moved[:, 1].max() - rest[:, 1].max()
    assert rise / pixels_per_metre == pytest.approx(50 * 0.003, abs=1.5 / pixels_per_metre)  # slanted ends: 1 px


def test_exaggeration_stands_in_the_picture() -> None:
    sway = np.zeros(12)
    sway[[3, 6]] = 1.6e-3  # of the beam, in x; 8 % of 4 m is 200 times as much
    figure = shared(portal(), sway[None])
    texts = " ".join(text.text for text in compose(figure, (Panel("", (Shape(sway),)),)).texts)
    assert "displacements drawn 200 times as large" in texts
    assert "displacement (mm)" in texts


def test_legend_names_members_and_supports() -> None:
    names = {text.text for text in picture_of(bridge(), 1, SENSORS).texts}
    assert {"deck", "tower", "cable", "undeformed", "roller", "clamped", "sensor", "sensor held out"} <= names


@pytest.mark.parametrize(
    ("held", "carried", "name"),
    [
        (("x", "y", "rz"), ("x", "y", "rz"), "clamped"),
        (("x", "y"), ("x", "y", "rz"), "pinned"),
        (("y",), ("x", "y", "rz"), "roller"),
        (("x",), ("x", "y", "rz"), "roller"),
        (("y", "rz"), ("x", "y", "rz"), "guided"),
        (("rz",), ("x", "y", "rz"), "rotation held"),
        (("x",), ("x",), "held"),
        (("x", "y"), ("x", "y"), "held"),
    ],
)
def test_supports_are_named_by_what_they_hold(held: tuple[str, ...], carried: tuple[str, ...], name: str) -> None:
    assert symbols.support_name(held, carried) == name
    patches = symbols.support(name, np.array([100.0, 100.0]), 30.0)
    assert np.vstack([patch.points for patch in patches])[:, 1].min() < 100  # the ground lies below the node


def test_spring_joins_its_ends() -> None:
    start, end = np.array([1.0, 2.0]), np.array([40.0, -7.0])
    line = symbols.zigzag(start, end, 5.0)[0]
    np.testing.assert_array_equal(line[[0, -1]], [start, end])
    across = (line - start) @ np.array([9.0, 39.0]) / np.hypot(9, 39)
    assert np.isclose(np.abs(across).max(), 5.0)
    assert np.isclose(across.sum(), 5.0 * (across > 1).sum() - 5.0 * (across < -1).sum())


def test_stroke_has_the_area_of_its_length_times_width() -> None:
    points = np.array([[[10.0, 10.0], [40.0, 50.0], [70.0, 90.0]], [[0.0, 0.0], [0.0, 5.0], [0.0, 20.0]]])
    patch = stroke(points, 4.0, (0, 0, 0), caps=False)
    a, b, c = (patch.points[patch.triangles[:, corner]] for corner in range(3))
    area = 0.5 * np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]).sum()
    assert area == pytest.approx(4.0 * (100 + 20), rel=1e-12)  # lengths 50 + 50 and 5 + 15; exact but for rounding


def test_colours_grow_lighter_with_displacement_so_that_they_read_in_grey() -> None:
    luminance = ramp(np.linspace(0, 1, 60)) @ np.array([0.2126, 0.7152, 0.0722])  # ITU-R BT.709
    assert (np.diff(luminance) > -1).all()  # bytes are rounded down
    assert luminance[-1] < 200  # still seen on white


def test_units_and_numbers_read_well() -> None:
    assert readable(2.0, "m") == (1.0, "m")
    assert readable(3e-3, "m") == (1e3, "mm")
    assert readable(3e-5, "m") == (1e6, "µm")
    assert readable(3e-5, "1") == (1.0, "relative")
    assert [digits(value, 4) for value in (1.6387, 3.45, 11.2515, 1234.5)] == ["1.639", "3.450", "11.25", "1234"]
    assert exaggeration(5000.0, 1e-4, "m") == "displacements drawn 5,000 times as large"
    assert exaggeration(0.5, 1.0, "1") == "relative displacements; the largest, 1, is drawn as 0.5 m"
    assert pace(101, 25.0, 1.0) == "shown 4 times slower"
    assert pace(26, 25.0, 1.0) == "shown in real time"
    assert pace(51, 25.0, 20.0) == "shown 10 times faster"
    assert nice_step(3.53, 5) == 1.0
    assert nice_step(1.0, 5) == pytest.approx(0.2)


# --- painted ---------------------------------------------------------------------------------------------------------


def test_modes_one_picture_each_and_an_overview(tmp_path: Path) -> None:
    structure = portal()
    dofs = structure_dofs(structure)
    modes = ModalModel(np.array([10.0, 20.0]), np.array([0.01, 0.02]), random_frames(structure, 2).T * 1e4, dofs)
    paths = draw_modes(structure, modes, tmp_path / "new")
    assert [path.name for path in paths] == ["mode_01.png", "mode_02.png", "modes.png"]
    assert sorted((tmp_path / "new").iterdir()) == sorted(paths)  # no temporary file is left
    for path in paths:
        image = imageio.v3.imread(path)
        assert image.shape[1] == 1600
        check_margins(image)
        assert count_color(image, LIGHT) > 500  # the undeformed structure
        assert count_color(image, tuple(RAMP[-1].astype(int))) > 20  # the largest displacement, and the colour bar


def test_largest_displacement_has_the_last_colour_also_off_the_colour_bar(tmp_path: Path) -> None:
    frames = random_frames(bridge(), 1)
    image = imageio.v3.imread(draw_snapshots(bridge(), frames, np.zeros(1), tmp_path / "a.png"))
    bar_and_legend = 220  # px from the bottom
    assert count_color(image[:-bar_and_legend], tuple(RAMP[-1].astype(int)), 20) > 10


def test_snapshots_of_a_chain_show_masses_and_ground(tmp_path: Path) -> None:
    frames = random_frames(four_dof(), 3, 0.1)
    image = imageio.v3.imread(draw_snapshots(four_dof(), frames, np.arange(3.0), tmp_path / "a.png"))
    check_margins(image)


def test_structure_at_rest_is_drawn(tmp_path: Path) -> None:
    image = imageio.v3.imread(draw_snapshots(portal(), np.zeros((1, 12)), np.zeros(1), tmp_path / "a.png"))
    check_margins(image)


def test_comparison_shows_every_shape_even_where_they_coincide(tmp_path: Path) -> None:
    shape = random_frames(portal(), 1)[0]
    path = draw_comparison(
        portal(), {"hybrid": shape, "FE": shape, "truth": shape}, tmp_path / "a.png", sensors=SENSORS
    )
    image = imageio.v3.imread(path)
    check_margins(image)
    above_legend = image[:-220]
    for name, (color, _) in NAMED_STYLES.items():
        assert count_color(above_legend, color) > 300, name


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:unclosed file:ResourceWarning")  # imageio's reader of films; its writer is clean
@pytest.mark.parametrize("suffix", [".gif", ".mp4"])
def test_animation_moves(tmp_path: Path, suffix: str) -> None:
    if suffix == ".mp4" and not mp4_works():
        pytest.skip("ffmpeg does not run here, so no .mp4 can be written")
    times = np.linspace(0, 0.2, 6)
    frames = np.sin(2 * np.pi * 2 * times)[:, None] * random_frames(portal(), 1)
    film = imageio.v3.imread(animate(portal(), frames, times, tmp_path / f"a{suffix}"))
    assert len(film) == 6
    for image in film:
        edges = image[:10], image[-10:], image[:, :10], image[:, -10:]
        assert all((edge > 245).all() for edge in edges)  # white but for the compression
    moved = [np.abs(a.astype(int) - b).max() for a, b in pairwise(film)]
    assert min(moved) > 100


def test_bad_input_is_named_and_leaves_the_older_picture(tmp_path: Path) -> None:
    path, frames = tmp_path / "a.png", random_frames(portal(), 2)
    path.write_text("older")
    with pytest.raises(InputError, match="12 degrees of freedom"):
        draw_snapshots(portal(), frames[:, :5], np.arange(2.0), path)
    with pytest.raises(InputError, match="do not fit 3 times"):
        draw_snapshots(portal(), frames, np.arange(3.0), path)
    with pytest.raises(InputError, match="'A9' cannot be drawn at node 99"):
        draw_snapshots(portal(), frames, np.arange(2.0), path, sensors=(replace(SENSORS[0], name="A9", node=99),))
    with pytest.raises(InputError, match="at least one"):
        draw_comparison(portal(), {}, path)
    assert path.read_text() == "older"
    assert list(tmp_path.iterdir()) == [path]


def test_import_needs_no_graphics() -> None:
    heavy = "'pyvista', 'vtk', 'torch', 'exudyn'"
    code = f"import sys, fe_models.pictures.render; sys.exit(any(name in sys.modules for name in ({heavy})))"
    subprocess.run([sys.executable, "-c", code], cwd=ROOT, check=True)


def test_names_with_signs_of_formulas_are_drawn_as_they_are() -> None:
    """VTK reads a formula between two dollar signs, and draws nothing where there is none."""
    for name in ("$x$", r"$\frac{$", "a$b$c"):
        drawn = render._text(Text(name, 0.0, 0.0, 20))
        assert drawn.input == name.replace("$", r"\$")
