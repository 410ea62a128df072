"""The curves: right panels with the data that were given, legible labels, and files that are written whole."""

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import imageio.v3
import matplotlib.figure
import numpy as np
import pytest
from matplotlib.layout_engine import ConstrainedLayoutEngine

from fe_models.arrays import FloatArray
from hybrid.figures import (
    MOST_POINTS,
    STYLES,
    Sheet,
    channel_labels,
    clearest_span,
    draw_channels,
    draw_curves,
    draw_latent,
    draw_loop,
    figure,
)
from hybrid.training.gradient_training import EpochResult
from hybrid.training.training_figure import draw_history
from tests.hybrid_problems import SENSORS

TIME: FloatArray = np.asarray(0.1 * np.arange(50), dtype=float)


def curves(panels: int, *names: str) -> dict[str, FloatArray]:
    rng = np.random.default_rng(0)
    return {name: rng.standard_normal((50, panels)) for name in names}


def lines_drawn(axis: Any) -> dict[str, Any]:
    return {line.get_label(): line for line in axis.lines}


def assert_is_picture(path: Path) -> None:
    """A readable picture that is not blank."""
    image = imageio.v3.imread(path)
    assert image.shape[0] > 200
    assert image.shape[1] > 600
    assert np.mean(image[..., :3] < 250) > 0.005
    assert [other.name for other in path.parent.iterdir()] == [path.name]  # no temporary file is left


@pytest.mark.parametrize("panels", [1, 2, 5])
def test_each_panel_has_its_curves(panels: int, tmp_path: Path) -> None:
    given = curves(panels, "measured", "FE model", "hybrid")
    labels = [f"A{i} (m)" for i in range(panels)]
    sheet = draw_curves(TIME, given, labels, "Channels")
    assert_is_picture(sheet.save(tmp_path / "channels.png"))
    assert sheet.figure.get_suptitle() == "Channels"
    assert len(sheet.figure.axes) == panels
    for panel, axis in enumerate(sheet.figure.axes):
        assert axis.get_ylabel() == labels[panel]
        lines = lines_drawn(axis)
        assert list(lines) == list(given)
        for name, values in given.items():
            np.testing.assert_array_equal(lines[name].get_xdata(), TIME)
            np.testing.assert_array_equal(lines[name].get_ydata(), values[:, panel])
            assert lines[name].get_color() == STYLES[name]["color"]
    assert all(axis.get_xlabel() == "time (s)" for axis in sheet.figure.axes[-2:])  # the lowest of each column
    (legend,) = sheet.figure.legends
    assert [text.get_text() for text in legend.get_texts()] == list(given)


def long_decays(seconds: float) -> tuple[FloatArray, dict[str, FloatArray]]:
    """A measured vibration of 2 Hz for ``seconds``, and a forecast that is wrong from 10 to 12 s alone."""
    time = np.linspace(0.0, seconds, round(100 * seconds) + 1)
    measured = np.stack([np.cos(4 * np.pi * time), np.sin(4 * np.pi * time)], axis=1)
    wrong = np.where((time > 10) & (time < 12), -1.0, 1.0)
    return time, {"measured": measured, "hybrid": measured * wrong[:, None]}


def test_the_part_shown_larger_is_where_curves_differ_and_a_few_periods_long() -> None:
    time, drawn = long_decays(20.0)
    span = clearest_span(time, drawn)
    assert span is not None
    assert span[1] - span[0] == pytest.approx(3.0, abs=0.1)  # six periods of 2 Hz, of whole samples and lines
    assert span[0] <= 10.05
    assert span[1] >= 11.95
    drawn["hybrid"][100:130] = 1e6  # a forecast that runs away for a moment does not draw all attention to itself
    assert clearest_span(time, drawn) == span
    assert clearest_span(*long_decays(5.0)) is None


def test_long_channels_have_a_part_beside_them(tmp_path: Path) -> None:
    time, drawn = long_decays(20.0)
    sheet = draw_channels(time, drawn, ["A1 (m)", "A2 (m)"], "Channels")
    assert_is_picture(sheet.save(tmp_path / "channels.png"))
    assert [axis.get_ylabel() for axis in sheet.figure.axes] == ["A1 (m)", "", "A2 (m)", ""]
    for whole, part in (sheet.figure.axes[:2], sheet.figure.axes[2:]):
        assert part.get_xlim() == clearest_span(time, drawn)
        assert whole.get_xlim() == (0.0, 20.0)
        assert part.get_ylim() == whole.get_ylim()
        for name, line in lines_drawn(whole).items():
            np.testing.assert_array_equal(lines_drawn(part)[name].get_ydata(), line.get_ydata())


def test_latent_states_have_a_row_a_mode(tmp_path: Path) -> None:
    """Coordinates left, velocities right."""
    q, q_dot = curves(3, "FE model", "hybrid"), curves(3, "hybrid", "FE model")
    sheet = draw_latent(TIME, q, q_dot, "Modes")
    assert_is_picture(sheet.save(tmp_path / "latent.png"))
    assert [axis.get_ylabel() for axis in sheet.figure.axes] == ["q1", "q1'", "q2", "q2'", "q3", "q3'"]
    for mode in range(3):
        for name in q:
            left, right = (lines_drawn(axis)[name].get_ydata() for axis in sheet.figure.axes[2 * mode : 2 * mode + 2])
            np.testing.assert_array_equal(left, q[name][:, mode])
            np.testing.assert_array_equal(right, q_dot[name][:, mode])


def test_the_loop_is_force_over_displacement(tmp_path: Path) -> None:
    u = {name: values[:, 0] for name, values in curves(1, "measured", "FE model", "hybrid").items()}
    f = {name: -3 * values for name, values in u.items()}
    sheet = draw_loop(u, f, node=7)
    assert_is_picture(sheet.save(tmp_path / "loop.png"))
    (axis,) = sheet.figure.axes
    for name, line in lines_drawn(axis).items():
        np.testing.assert_array_equal(line.get_xdata(), u[name])
        np.testing.assert_array_equal(line.get_ydata(), f[name])
    assert "node 7" in axis.get_xlabel()
    assert "(m)" in axis.get_xlabel()
    assert "(N)" in axis.get_ylabel()


def test_the_loss_is_drawn_a_sample(tmp_path: Path) -> None:
    """Over a longer horizon the loss of a window grows without getting worse."""
    history = [EpochResult(1, 40.0, 20), EpochResult(2, 30.0, 40), EpochResult(3, 16.0, 80)]
    sheet = draw_history(history)
    assert_is_picture(sheet.save(tmp_path / "training.png"))
    loss, horizon = sheet.figure.axes
    for axis, values in ((loss, [2.0, 0.75, 0.2]), (horizon, [20, 40, 80])):
        (line,) = axis.lines
        np.testing.assert_array_equal(line.get_xdata(), [1, 2, 3])
        np.testing.assert_array_equal(line.get_ydata(), values)


def test_labels_name_unit_and_role() -> None:
    labels = channel_labels((*SENSORS, replace(SENSORS[0], name="n", unit="1")))
    assert labels == ["x4 (m)", "a1 (m/s^2)", "v2 (m/s), held out", "a3 (m/s^2)", "a4 (m/s^2)", "n (-)"]


def sheet_of_curves(title: str = "Channels") -> Sheet:
    return draw_curves(TIME, curves(3, "measured", "hybrid"), ["A1 (m)", "A2 (m)", "A3 (m)"], title)


def test_an_older_picture_stays_whole_where_the_writing_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sheet = sheet_of_curves()
    path = sheet.save(tmp_path / "picture.png")
    before = path.read_bytes()

    def half(drawing: Any, target: Path) -> None:
        Path(target).write_bytes(before[:100])
        raise KeyboardInterrupt

    monkeypatch.setattr(matplotlib.figure.Figure, "savefig", half)
    with pytest.raises(KeyboardInterrupt):
        sheet.save(path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_a_file_and_a_page_have_one_layout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whichever is made first, and however often."""
    layouts = list[object]()
    execute = ConstrainedLayoutEngine.execute

    def counted(engine: ConstrainedLayoutEngine, drawing: matplotlib.figure.Figure) -> None:
        layouts.append(drawing)
        execute(engine, drawing)

    monkeypatch.setattr(ConstrainedLayoutEngine, "execute", counted)
    sheet = sheet_of_curves()
    places = [axis.get_position().bounds for axis in sheet.figure.axes]
    svg = sheet.svg()
    png = sheet.save(tmp_path / "a.png").read_bytes()
    assert sheet.svg() == svg
    assert sheet.save(tmp_path / "a.png").read_bytes() == png
    assert layouts == [sheet.figure]
    assert [axis.get_position().bounds for axis in sheet.figure.axes] == places
    again = sheet_of_curves()
    assert again.save(tmp_path / "b.png").read_bytes() == png
    assert again.svg() == svg


@pytest.mark.parametrize("title", ["Channels", "Channels\nof the first recording", ""])
def test_a_page_shows_all_but_the_title(title: str, tmp_path: Path) -> None:
    """Cut off is what the title takes, and nothing at the sides; a file has it."""
    with figure(2, 2, title) as (sheet, (first, second)):
        first.plot(TIME)
        first.set_title("first panel")
        drawing = second.imshow([[0.0, 1.0]])
        sheet.figure.colorbar(drawing, ax=second, label="values")
    assert sheet.title.get_text() == title
    with_title = imageio.v3.imread(sheet.save(tmp_path / "a.png"))
    svg = sheet.svg()
    assert {"Channels", "of the first recording"}.isdisjoint(texts_of(svg))
    assert {"first panel", "values"} <= set(texts_of(svg))
    width, height = seen_of(svg)
    whole_width, whole_height = 72 * sheet.figure.get_size_inches()
    assert width == pytest.approx(whole_width)
    highest = max(axis.get_tightbbox().y1 for axis in sheet.figure.axes)
    assert height >= 72 / sheet.figure.dpi * highest
    assert height == pytest.approx(72 / sheet.figure.dpi * highest, abs=10)  # no more room than between panels
    rows = round(sheet.figure.dpi * (whole_height - height) / 72)  # pixels of the title
    assert (with_title[:rows, :, :3].min() < 128) == bool(title)
    assert (imageio.v3.imread(sheet.save(tmp_path / "b.png")) == with_title).all()


def texts_of(svg: str) -> list[str]:
    return re.findall(r"<text[^>]*>([^<]*)</text>", svg)


def seen_of(svg: str) -> tuple[float, float]:
    """Return width and height of what is seen of a drawing, points."""
    box = re.search(r'viewBox="0 0 (\S+) (\S+)"', svg)
    assert box is not None
    return float(box[1]), float(box[2])


def test_a_page_that_fails_takes_no_title_from_the_file(monkeypatch: pytest.MonkeyPatch) -> None:
    def failing(drawing: Any, *arguments: Any, **options: Any) -> None:
        raise KeyboardInterrupt

    sheet = sheet_of_curves()
    monkeypatch.setattr(matplotlib.figure.Figure, "savefig", failing)
    with pytest.raises(KeyboardInterrupt):
        sheet.svg()
    assert sheet.title.get_visible()


def test_long_lines_are_images_in_their_place_on_a_page() -> None:
    """To two pixels, beside half of the line's width (points)."""
    time = np.linspace(0.0, 1.0, 2 * MOST_POINTS)
    sheet = draw_curves(time, {"measured": np.sin(900 * time)[:, None]}, ["x"], "A title\nof two lines")
    svg = sheet.svg()
    (image,) = re.findall(r"<image ([^>]*)>", svg)
    place = {name: float(value) for name, value in re.findall(r'\b(x|y|width|height)="([^"]*)"', image)}
    assert f"scale(1 -1) translate(0 -{place['height']})" in image  # upside down: its upper edge is at -y
    points = 72 / sheet.figure.dpi * sheet.figure.axes[0].transData.transform([[0.0, -1.0], [1.0, 1.0]])
    (left, low), (right, high) = points
    _, height = seen_of(svg)
    near = {"abs": 2 * 72 / sheet.figure.dpi + STYLES["measured"]["linewidth"] / 2}
    assert place["x"] == pytest.approx(left, **near)
    assert place["x"] + place["width"] == pytest.approx(right, **near)
    assert -place["y"] == pytest.approx(height - high, **near)
    assert -place["y"] + place["height"] == pytest.approx(height - low, **near)


def test_a_drawing_leaves_matplotlib_as_it_was(tmp_path: Path) -> None:
    """Users have settings of their own."""
    before = {**matplotlib.rcParams, "backend": None}  # which is looked for at the first drawing
    sheet = sheet_of_curves()
    assert {**matplotlib.rcParams, "backend": None} == before
    sheet.save(tmp_path / "a.png")
    assert {**matplotlib.rcParams, "backend": None} == before
    sheet.svg()
    assert {**matplotlib.rcParams, "backend": None} == before


def test_a_users_settings_change_no_picture(tmp_path: Path) -> None:
    """Neither while it is drawn nor while it is saved: LaTeX would read commands in names, and is seldom there."""
    sheet = sheet_of_curves()
    png, svg = sheet.save(tmp_path / "a.png").read_bytes(), sheet.svg()
    own: dict[Any, Any] = {  # of names of settings
        "text.usetex": True,
        "font.size": 40,
        "figure.constrained_layout.use": True,
        "savefig.bbox": "tight",
        "savefig.dpi": 20,
        "svg.fonttype": "path",
    }
    with matplotlib.rc_context(own):
        again = sheet_of_curves()
        for each in (sheet, again):
            assert each.save(tmp_path / "a.png").read_bytes() == png
            assert each.svg() == svg


def test_any_name_is_drawn_as_it_is(tmp_path: Path) -> None:
    names = [r"$\frac{", "a_$b$_c", "100 %", r"C:\temp\new", "日本"]
    sheet = draw_curves(TIME, curves(5, "measured"), names, "$x_")
    assert_is_picture(sheet.save(tmp_path / "names.png"))
    assert [axis.get_ylabel() for axis in sheet.figure.axes] == names
    assert set(names) <= set(texts_of(sheet.svg()))
    texts = [text for axis in sheet.figure.axes for text in (axis.yaxis.label, axis.xaxis.label)]
    assert not any(text.get_parse_math() for text in (sheet.title, *texts, *sheet.figure.legends[0].get_texts()))


def test_names_at_ticks_are_drawn_as_they_are() -> None:
    names = ["$x$", r"\$", "a_$b$_c"]
    with figure(1, 1, "") as (sheet, (axis,)):
        axis.plot([0, 1, 2])
        axis.set_xticks([0, 1, 2], names)
    assert set(names) <= set(texts_of(sheet.svg()))


def test_powers_at_axes_stay_formulas() -> None:
    with figure(1, 1, "") as (sheet, (axis,)):
        axis.semilogy([1.0, 1e6])
        axis.set_ylabel("$y$")
    labels = [label for label in axis.yaxis.get_ticklabels() if "mathdefault" in label.get_text()]
    assert labels
    assert all(label.get_parse_math() for label in labels)
    svg = sheet.svg()
    assert "$y$" in texts_of(svg)
    assert "mathdefault" not in "".join(texts_of(svg))
