"""Drawings of pages: what is pointed at, outlines of triangles, figures in the page's colours, shapes that move."""

import re
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

import fe_models as fe
from benchmarks.space_frame import tall_frame
from fe_models.built_in.bridge import bridge
from fe_models.files.run_folder import Prediction
from fe_models.linear import LinearModel
from fe_models.pictures.drawing import INK, LIGHT, Picture, Text, disc, stroke
from fe_models.pictures.geometry import outline
from fe_models.pictures.pointers import FOUND_SHADE, Pointer, pointer_to
from fe_models.pictures.structure_drawing import MOST_LINES, structure_picture
from fe_models.pictures.svg import svg_of
from fe_models.recordings import Sensor
from fe_models.structure import Cable
from hybrid.figures import draw_curves
from hybrid.report.drawings import drawn
from hybrid.report.field_motion import field_motion
from hybrid.report.mode_shapes import mode_shapes
from hybrid.report.motion import Stage
from tests.pages import HOSTILE, chain_dataset

SENSORS = (Sensor("A1", 12, "y", "acceleration", "m/s^2"), Sensor("A2", 40, "x", "acceleration", "m/s^2"))


@pytest.mark.parametrize(
    ("location", "nodes", "elements"),
    [
        ({"node": 4, "direction": "x"}, (4,), ()),
        ({"nodes": [4, 5], "direction": "x"}, (4, 5), ()),
        ({"element": 7}, (), (7,)),
        ({"elements": [7, 8]}, (), (7, 8)),
        ({"sensor": "A2"}, (40,), ()),
        ({"load": [19, "y"]}, (19,), ()),
    ],
)
def test_places_of_a_report_are_found_on_the_drawing(
    location: dict[str, object], nodes: tuple[int, ...], elements: tuple[int, ...]
) -> None:
    assert pointer_to(location, "it", bridge(), SENSORS) == Pointer("it", nodes, elements)


@pytest.mark.parametrize("location", [{}, {"modes": [2]}, {"load": "base"}, {"sensor": "none"}])
def test_what_is_nowhere_on_the_drawing_is_not_pointed_at(location: dict[str, object]) -> None:
    assert pointer_to(location, "it", bridge(), SENSORS) is None


def test_a_group_is_all_its_elements() -> None:
    found = pointer_to({"group": "cable"}, "it", bridge(), ())
    assert found is not None
    assert found.elements == tuple(n for n, own in enumerate(bridge().elements, 1) if isinstance(own, Cable))


def test_of_more_lines_than_stand_apart_what_is_pointed_at_lies_above() -> None:
    """A building of thousands of members would be one dark face."""
    tall = tall_frame(13, 12, 6)
    pointer = pointer_to({"group": tall.groups[0].name}, "1: stiffness change", tall, ())
    assert pointer is not None
    picture = structure_picture(tall, (), (1600,), (pointer,))
    (lines,) = (patch for patch in picture.patches if len(patch.points) == 4 * len(members_of(tall)))
    assert len(members_of(tall)) > MOST_LINES
    assert (lines.colors == LIGHT).all()
    order = [patch is lines for patch in picture.patches if patch is lines or (patch.colors == FOUND_SHADE).all()]
    assert not order[-1]


def members_of(model: LinearModel) -> NDArray[np.int64]:
    return np.vstack([group.ends for group in outline(model).groups if group.kind != "point"])


def test_what_is_pointed_at_is_named_and_shaded_on_the_drawing() -> None:
    structure = fe.four_dof()
    plain = structure_picture(structure, (), (1600,))
    pointers = (Pointer("1: cubic spring", (1,), ()), Pointer("gap stop", (), (3,), is_faint=True))
    marked = structure_picture(structure, (), (1600,), pointers)
    names = {text.text for text in marked.texts} - {text.text for text in plain.texts}
    assert names == {"1: cubic spring", "gap stop", "found", "possible instead"}
    behind = marked.patches[0]  # beneath all else, the faint one first
    grounds = [patch for patch in marked.patches if (patch.colors == behind.colors[0]).all()]
    assert len(grounds) >= 1


def area(path: str) -> float:
    """Return the area within the closed lines of a path, those turned the other way taken off."""
    total = 0.0
    for loop in path.split("Z")[:-1]:
        x, y = np.array([[float(part) for part in pair.split()] for pair in loop[1:].split("L")]).T
        total += float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2
    return total


def test_outlines_have_the_area_of_their_triangles() -> None:
    """A ribbon without caps, and a disc of many sides: that many sixtieths of a circle less than one."""
    ribbon = stroke(np.array([[[10.0, 10.0], [110.0, 10.0]]]), 6.0, INK, caps=False)
    circle = disc(np.array([[60.0, 60.0]]), 20.0, INK, sides=60)
    paths = re.findall(r' d="([^"]*)"', svg_of(Picture(200, 100, (ribbon, circle), ())))
    assert [abs(area(path)) for path in paths] == pytest.approx([600.0, np.pi * 400], rel=0.01)  # to tenths of a px
    capped = stroke(np.array([[[10.0, 10.0], [110.0, 10.0]]]), 6.0, INK)
    (path,) = re.findall(r' d="([^"]*)"', svg_of(Picture(200, 100, (capped,), ())))
    turns = {np.sign(area(loop + "Z")) for loop in path.split("Z")[:-1]}
    assert len(turns) == 1  # else caps would cut holes


def test_texts_of_a_drawing_are_escaped() -> None:
    svg = svg_of(Picture(100, 50, (), (Text(HOSTILE, 10, 20),)))
    assert "<script" not in svg
    assert "&lt;script&gt;" in svg


def test_a_figure_takes_the_colours_of_its_page_and_has_names_of_its_own() -> None:
    time = np.linspace(0, 1, 50)
    curves = {"measured": 0.004 * np.sin(time)[:, None], "hybrid": 0.004 * np.cos(time)[:, None]}
    figure = drawn(draw_curves(time, curves, [HOSTILE], "title"), "first", "caption", "words")
    assert "var(--c-0072b2,#0072b2)" in figure.svg
    assert "title" not in figure.svg.replace("<title", "")  # the caption says it
    assert "<script" not in figure.svg
    assert "&lt;script&gt;" in figure.svg
    assert "0.001" in re.findall(r"<text[^>]*>([^<]*)</text>", figure.svg)  # numbers are not cut short
    assert set(re.findall(r'id="([a-z]*)-', figure.svg)) == {"first"}
    assert not re.search(r"https?:|<metadata|<\?xml|<!DOCTYPE", figure.svg)
    again = drawn(draw_curves(time, curves, [HOSTILE], "title"), "first", "caption", "words")
    assert again.svg == figure.svg


def test_long_lines_are_images_on_a_page() -> None:
    time = np.linspace(0, 1, 5000)
    curves = {"measured": np.sin(900 * time)[:, None]}
    figure = drawn(draw_curves(time, curves, ["x"], "title"), "long", "caption", "words")
    assert "data:image/png;base64," in figure.svg
    assert len(figure.svg) < 100_000


def test_modes_move_as_their_shapes_do() -> None:
    """Of the drawn chain and of one whose third spring is softer: the largest displacement is as large in both."""
    dataset = chain_dataset()
    assert isinstance(dataset.model, fe.Structure)
    softer = dataset.model.with_effects(fe.StiffnessChange((3,), 0.5))
    figure = mode_shapes(dataset, softer, None)
    assert figure is not None
    first = figure.motion.choices[0]
    drawn_shape, found = (layer.shapes[0] for layer in first.layers)
    nominal, other = (fe.natural_modes(own, 5) for own in (dataset.model, softer))
    assert f"{nominal.frequencies[0]:.4g} Hz as drawn, {other.frequencies[0]:.4g} Hz with what was found" in first.label
    assert np.abs(drawn_shape).max() == pytest.approx(np.abs(found).max())
    assert not drawn_shape[:, 0].any()  # a chain moves across its own line on a page
    nodes = drawn_shape[-len(dataset.sensors) :, 1]
    wanted = nominal.shapes[:, 0] / np.abs(nominal.shapes[:, 0]).max()
    assert nodes / nodes[-1] == pytest.approx(wanted / wanted[-1])
    assert "upwards" in figure.caption


def test_storeys_move_sideways_as_they_are_drawn() -> None:
    """A chain that stands upright moves across its own line already."""
    upright = replace(fe.four_dof(), nodes=((0.0, 1.0), (0.0, 2.0), (0.0, 3.0), (0.0, 4.0)))
    stage = Stage.of(outline(upright))
    lying = Stage.of(outline(fe.four_dof()))
    assert stage is not None
    assert lying is not None
    shape = fe.natural_modes(upright, 1).shapes[:, 0]
    assert not stage.points(shape)[:, 1].any()
    assert not lying.points(shape)[:, 0].any()


def test_a_field_moves_as_it_was_forecast() -> None:
    """A few shapes and their histories give the motion back, at any time, to a ten-thousandth of the largest."""
    structure, rng = bridge(), np.random.default_rng(1)
    modal = fe.natural_modes(structure, 6)
    time = np.arange(300) / 100
    q = rng.standard_normal(6) * np.cos(np.outer(time, modal.omega))
    field = 1e-3 * q @ modal.shapes.T
    figure = field_motion(structure, Prediction(time, field, 0.5 * field, field[0], None, "m", SENSORS))
    assert figure is not None
    (choice,) = figure.motion.choices
    layer = next(own for own in choice.layers if own.name == "hybrid")
    assert layer.history is not None
    stage = Stage.of(outline(structure), SENSORS)
    assert stage is not None
    found = re.search(r"displacements (\S+) times", figure.caption)
    assert found is not None
    for instant in (0, 137, 299):
        wanted = stage.points(float(found[1]) * field[instant])
        moved = np.einsum("k,kpc->pc", layer.history[instant], layer.shapes)
        assert moved == pytest.approx(wanted, abs=1e-3 * np.abs(layer.shapes).max())
    assert choice.seconds == pytest.approx(0.01)


def test_what_does_not_move_is_left_out() -> None:
    still = np.zeros((20, len(outline(bridge()).dofs)))
    assert field_motion(bridge(), Prediction(np.arange(20.0), still, still, still[0], None, "m", ())) is None
