"""The drawing of a model: every number is there once, readable, beside what it numbers; arrows point as sensors do."""

from collections import Counter
from pathlib import Path

import imageio.v3
import numpy as np
import pytest

import fe_models as fe
from fe_models.assembly import linearise
from fe_models.built_in.bridge import bridge
from fe_models.built_in.four_dof import four_dof
from fe_models.errors import InputError
from fe_models.linear import LinearModel
from fe_models.pictures import effect_marks
from fe_models.pictures.drawing import Picture, Text
from fe_models.pictures.figure import View
from fe_models.pictures.geometry import outline
from fe_models.pictures.numbering import ELEMENT_COLOR, members
from fe_models.pictures.render import draw_structure
from fe_models.pictures.sensor_arrows import arrows_of
from fe_models.pictures.structure_drawing import structure_picture
from fe_models.recordings import Sensor
from fe_models.sections import Section
from fe_models.structure import Beam, Spring, Structure, Support
from tests.test_render import SENSED, mast, portal

STEEL = Section("steel", 2.1e11, 7850.0, 1e-4, 1e-9)


def grid(bays: int, storeys: int) -> Structure:
    """A frame whose nodes are numbered column by column."""
    high = storeys + 1
    nodes = tuple((5.0 * bay, 3.5 * level) for bay in range(bays + 1) for level in range(high))
    columns = [Beam((i, i + 1), STEEL) for i in range(1, len(nodes)) if i % high]
    floors = [Beam((i, i + high), STEEL) for i in range(1, len(nodes) - high + 1) if (i - 1) % high]
    feet = tuple(Support(1 + bay * high, ("x", "y", "rz")) for bay in range(bays + 1))
    return Structure("frame", nodes, (*columns, *floors), supports=feet)


def numbers(picture: Picture, kind: str) -> list[Text]:
    found = [
        text for text in picture.texts if text.text.isdigit() and (text.color == ELEMENT_COLOR) == (kind == "element")
    ]
    return [text for text in found if text.bold == (kind == "node")]


def box(text: Text) -> tuple[float, float, float, float]:
    left = text.x - {"left": 0.0, "center": text.width / 2, "right": text.width}[text.align]
    return left, left + text.width, text.y - text.size / 2, text.y + text.size / 2


CHAIN = fe.four_dof().with_effects(
    fe.CubicSpring((1,), "x", 0.5), fe.CoulombFriction((2, 3), "x", 0.1), fe.AddedMass(2, 0.5)
)
LOADED = portal().with_effects(
    fe.GapStop((3,), "x", 1e-3, 1e6, 1),
    fe.QuadraticDamper((2, 3), "x", 5.0),
    fe.AddedMass(2, 20.0),
    fe.StiffnessChange((1, 2), (0.7, 0.8)),
    fe.SupportSpring(1, "rz", 1e5),
    fe.DeadLoad(),
)
MODELS = {
    **SENSED,
    "chain with effects": (CHAIN, (Sensor("a1", 1, "x", "acceleration", "m/s^2"),)),
    "portal with effects": (LOADED, ()),
    "frame": (
        grid(3, 8),
        (Sensor("roof", 9, "x", "acceleration", "m/s^2"), Sensor("tilt", 5, "rz", "velocity", "rad/s")),
    ),
    "refined": (portal().refined(4), ()),
}


@pytest.mark.parametrize("name", MODELS)
def test_every_number_and_every_sensor_stands_once_on_free_ground(name: str) -> None:
    structure, sensors = MODELS[name]
    picture = structure_picture(structure, sensors)
    nodes, elements = (Counter(text.text for text in numbers(picture, kind)) for kind in ("node", "element"))
    assert nodes == Counter(str(node) for node in range(1, len(structure.nodes) + 1))
    assert elements == Counter(str(number) for number in range(1, len(structure.elements) + 1))
    assert Counter(sensor.name for sensor in sensors) <= Counter(text.text for text in picture.texts)
    boxes = [(text.text, *box(text)) for text in picture.texts]
    for i, (words, a, b, c, d) in enumerate(boxes):
        assert min(a, c) >= 10, words
        assert b <= picture.width - 10, words
        assert d <= picture.height - 10, words
        for other, e, f, g, h in boxes[:i]:
            assert b <= e or f <= a or d <= g or h <= c, f"{words!r} overlaps {other!r}"


def names(picture: Picture) -> Counter[str]:
    """Names of dashpots and effects, by their colour."""
    return Counter(text.text for text in picture.texts if text.color == effect_marks.COLOR)


def test_dashpots_and_effects_have_their_names_where_they_act() -> None:
    drawn = structure_picture(CHAIN, ())
    assert names(drawn) == {"dashpot x": 4, "cubic spring x": 1, "Coulomb friction x": 1, "added mass": 1}
    masses = {text.text: text.x for text in numbers(drawn, "node")}
    (friction,) = (text for text in drawn.texts if text.text == "Coulomb friction x")
    assert masses["2"] < friction.x + friction.width / 2 < masses["3"]
    (spring,) = (text for text in drawn.texts if text.text == "cubic spring x")
    assert spring.x < masses["1"] < spring.x + spring.width


def test_what_acts_in_many_elements_is_named_once_and_what_acts_everywhere_in_the_note() -> None:
    drawn = structure_picture(LOADED, ())
    assert names(drawn) == {"gap stop x": 1, "quadratic damper x": 1, "added mass": 1, "stiffness change": 1}
    assert any(text.text.endswith("with dead load") for text in drawn.texts)
    assert any(text.text == "spring to ground" for text in drawn.texts)  # the support's: drawn as what it is


def test_the_number_of_a_node_is_kept_off_the_spring_that_turns_there() -> None:
    drawn = structure_picture(portal().with_effects(fe.SupportSpring(1, "rz", 1e5)), ())
    (number,) = (text for text in numbers(drawn, "node") if text.text == "1")
    left, right, low, high = box(number)
    spirals = [patch.points for patch in drawn.patches if len(patch.points) == 2 * 60 + 2 * 12]
    assert len(spirals) == 1  # of its sixty points, two corners each, and round ends
    x, y = spirals[0].T
    assert not ((x > left) & (x < right) & (y > low) & (y < high)).any()


def test_numbers_stand_beside_what_they_number() -> None:
    """Of a girder: each node's number nearest to its own node, each element's to its own middle."""
    structure, sensors = SENSED["girder"]
    picture = structure_picture(structure, sensors)
    x = np.array([node[0] for node in structure.nodes])
    for kind, places in (("node", x), ("element", (x[1:] + x[:-1]) / 2)):
        stands = np.array([text.x for text in sorted(numbers(picture, kind), key=lambda text: int(text.text))])
        slope, start = np.polyfit(places, stands, 1)
        off = np.abs(stands - (slope * places + start))
        assert off.max() < 0.5 * slope * 5.0, kind  # half a bay of 5 m


def test_sensors_point_where_they_measure() -> None:
    shape = outline(portal())
    view = View(np.zeros(2), np.zeros(2), 200.0, 20.0, 1.0)
    sensors = tuple(
        Sensor(f"{node}{way}", node, way, "acceleration", "m/s^2") for node in (2, 3) for way in ("x", "y", "rz")
    )
    arrows = arrows_of(sensors, shape, view, np.zeros((0, 2)))
    assert len(arrows) == 6
    for arrow, sensor in zip(arrows, sensors, strict=True):
        assert arrow.sensors == (sensor,)
        way = arrow.tip - arrow.tail
        if sensor.direction != "rz":
            along = way / np.linalg.norm(way)
            np.testing.assert_allclose(along, (1, 0) if sensor.direction == "x" else (0, 1), atol=1e-12)  # rounding
        assert np.linalg.norm(arrow.tail - view(shape.coordinates[sensor.node - 1])) < 100  # px: at its node


def test_sensors_at_a_node_in_one_direction_share_an_arrow() -> None:
    both = (Sensor("a4", 4, "x", "acceleration", "m/s^2"), Sensor("x4", 4, "x", "displacement", "m"))
    (arrow,) = arrows_of(both, outline(four_dof()), View(np.zeros(2), np.zeros(2), 400.0, 20.0, 1.0), np.zeros((0, 2)))
    assert arrow.sensors == both


@pytest.mark.slow
def test_what_has_no_room_is_left_out_and_said() -> None:
    picture = structure_picture(grid(12, 12), (), widths=(500,))
    left_out = 169 + 300 - len(numbers(picture, "node")) - len(numbers(picture, "element"))
    assert left_out > 50
    (note,) = (text.text for text in picture.texts if "no room for the numbers of" in text.text)
    assert sum(int(word) for word in note.split("no room")[1].split() if word.isdigit()) == left_out


def test_springs_to_ground_are_numbered() -> None:
    sprung = Structure(
        "sprung",
        ((0.0, 0.0), (3.0, 0.0)),
        (Beam((1, 2), STEEL), Spring((2,), "y", 1e5)),
        supports=(Support(1, ("x", "y", "rz")),),
    )
    ends = {member.number: member.ends.tolist() for member in members(sprung, outline(sprung))}
    assert ends[1] == [[0.0, 0.0], [3.0, 0.0]]
    assert ends[2][0] == [3.0, 0.0]
    assert ends[2][1][1] < 0  # the ground is below


def test_imported_matrices_have_numbered_nodes() -> None:
    model: LinearModel = linearise(bridge())
    picture = structure_picture(model, ())
    assert {text.text for text in numbers(picture, "node")} == {str(node) for node in range(1, 56)}
    assert not numbers(picture, "element")
    assert any("153 free degrees of freedom" in text.text for text in picture.texts)


def test_the_picture_is_written(tmp_path: Path) -> None:
    image = imageio.v3.imread(draw_structure(mast(), tmp_path / "structure.png"))
    assert 0.005 < (image < 128).any(axis=-1).mean() < 0.2
    for edge in (image[:12], image[-12:], image[:, :12], image[:, -12:]):
        assert (edge == 255).all()
    with pytest.raises(InputError, match="'A9' cannot be drawn at node 99"):
        draw_structure(mast(), tmp_path / "other.png", (Sensor("A9", 99, "x", "acceleration", "1"),))
    assert [path.name for path in tmp_path.iterdir()] == ["structure.png"]
