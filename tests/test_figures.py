"""The curves: right panels with the data that were given, legible labels, and files that are written whole."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import imageio.v3
import matplotlib.figure
import numpy as np
import pytest

from fe_models.arrays import FloatArray
from hybrid.figures import (
    STYLES,
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


@pytest.fixture
def sheets(monkeypatch: pytest.MonkeyPatch) -> list[matplotlib.figure.Figure]:
    """The figures that are drawn, to look into after they are written."""
    drawn: list[matplotlib.figure.Figure] = []
    figure = matplotlib.figure.Figure

    def new(*arguments: Any, **options: Any) -> matplotlib.figure.Figure:
        drawn.append(figure(*arguments, **options))
        return drawn[-1]

    monkeypatch.setattr(matplotlib.figure, "Figure", new)
    return drawn


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
def test_each_panel_has_its_curves(panels: int, sheets: list[matplotlib.figure.Figure], tmp_path: Path) -> None:
    given = curves(panels, "measured", "FE model", "hybrid")
    labels = [f"A{i} (m)" for i in range(panels)]
    path = draw_curves(tmp_path / "channels.png", TIME, given, labels, "Channels")
    assert_is_picture(path)
    (sheet,) = sheets
    assert sheet.get_suptitle() == "Channels"
    assert len(sheet.axes) == panels
    for panel, axis in enumerate(sheet.axes):
        assert axis.get_ylabel() == labels[panel]
        lines = lines_drawn(axis)
        assert list(lines) == list(given)
        for name, values in given.items():
            np.testing.assert_array_equal(lines[name].get_xdata(), TIME)
            np.testing.assert_array_equal(lines[name].get_ydata(), values[:, panel])
            assert lines[name].get_color() == STYLES[name]["color"]
    assert all(axis.get_xlabel() == "time (s)" for axis in sheet.axes[-2:])  # the lowest of each column
    (legend,) = sheet.legends
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


def test_long_channels_have_a_part_beside_them(sheets: list[matplotlib.figure.Figure], tmp_path: Path) -> None:
    time, drawn = long_decays(20.0)
    assert_is_picture(draw_channels(tmp_path / "channels.png", time, drawn, ["A1 (m)", "A2 (m)"], "Channels"))
    (sheet,) = sheets
    assert [axis.get_ylabel() for axis in sheet.axes] == ["A1 (m)", "", "A2 (m)", ""]
    for whole, part in (sheet.axes[:2], sheet.axes[2:]):
        assert part.get_xlim() == clearest_span(time, drawn)
        assert whole.get_xlim() == (0.0, 20.0)
        assert part.get_ylim() == whole.get_ylim()
        for name, line in lines_drawn(whole).items():
            np.testing.assert_array_equal(lines_drawn(part)[name].get_ydata(), line.get_ydata())


def test_latent_states_have_a_row_a_mode(sheets: list[matplotlib.figure.Figure], tmp_path: Path) -> None:
    """Coordinates left, velocities right."""
    q, q_dot = curves(3, "FE model", "hybrid"), curves(3, "hybrid", "FE model")
    assert_is_picture(draw_latent(tmp_path / "latent.png", TIME, q, q_dot, "Modes"))
    (sheet,) = sheets
    assert [axis.get_ylabel() for axis in sheet.axes] == ["q1", "q1'", "q2", "q2'", "q3", "q3'"]
    for mode in range(3):
        for name in q:
            left, right = (lines_drawn(axis)[name].get_ydata() for axis in sheet.axes[2 * mode : 2 * mode + 2])
            np.testing.assert_array_equal(left, q[name][:, mode])
            np.testing.assert_array_equal(right, q_dot[name][:, mode])


def test_the_loop_is_force_over_displacement(sheets: list[matplotlib.figure.Figure], tmp_path: Path) -> None:
    u = {name: values[:, 0] for name, values in curves(1, "measured", "FE model", "hybrid").items()}
    f = {name: -3 * values for name, values in u.items()}
    assert_is_picture(draw_loop(tmp_path / "loop.png", u, f, node=7))
    (axis,) = sheets[0].axes
    for name, line in lines_drawn(axis).items():
        np.testing.assert_array_equal(line.get_xdata(), u[name])
        np.testing.assert_array_equal(line.get_ydata(), f[name])
    assert "node 7" in axis.get_xlabel()
    assert "(m)" in axis.get_xlabel()
    assert "(N)" in axis.get_ylabel()


def test_the_loss_is_drawn_a_sample(sheets: list[matplotlib.figure.Figure], tmp_path: Path) -> None:
    """Over a longer horizon the loss of a window grows without getting worse."""
    history = [EpochResult(1, 40.0, 20), EpochResult(2, 30.0, 40), EpochResult(3, 16.0, 80)]
    assert_is_picture(draw_history(tmp_path / "training.png", history))
    loss, horizon = sheets[0].axes
    for axis, values in ((loss, [2.0, 0.75, 0.2]), (horizon, [20, 40, 80])):
        (line,) = axis.lines
        np.testing.assert_array_equal(line.get_xdata(), [1, 2, 3])
        np.testing.assert_array_equal(line.get_ydata(), values)


def test_labels_name_unit_and_role() -> None:
    labels = channel_labels((*SENSORS, replace(SENSORS[0], name="n", unit="1")))
    assert labels == ["x4 (m)", "a1 (m/s^2)", "v2 (m/s), held out", "a3 (m/s^2)", "a4 (m/s^2)", "n (-)"]


@pytest.mark.parametrize(
    "draw",
    [
        lambda path: draw_curves(path, TIME, curves(1, "hybrid"), ["A1"], "t"),
        lambda path: draw_loop(path, {"hybrid": TIME}, {"hybrid": TIME}, 1),
        lambda path: draw_history(path, [EpochResult(1, 1.0, 20)]),
    ],
)
def test_an_older_picture_stays_whole_where_the_writing_fails(
    draw: Callable[[Path], Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "picture.png"
    draw(path)
    before = path.read_bytes()

    def half(sheet: Any, target: Path) -> None:
        Path(target).write_bytes(before[:100])
        raise KeyboardInterrupt

    monkeypatch.setattr(matplotlib.figure.Figure, "savefig", half)
    with pytest.raises(KeyboardInterrupt):
        draw(path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_a_drawing_leaves_matplotlib_as_it_was(tmp_path: Path) -> None:
    """Users have settings of their own."""
    before = {**matplotlib.rcParams, "backend": None}  # which is looked for at the first drawing
    draw_curves(tmp_path / "a.png", TIME, curves(2, "hybrid"), ["A1", "A2"], "t")
    assert {**matplotlib.rcParams, "backend": None} == before


@pytest.mark.parametrize("suffix", ["png", "svg"])
def test_any_name_is_drawn_as_it_is(suffix: str, sheets: list[matplotlib.figure.Figure], tmp_path: Path) -> None:
    """Whatever a user's matplotlibrc asks for: LaTeX would read commands in names, and is seldom there."""
    names = [r"$\frac{", "a_$b$_c", "100 %", r"C:\temp\new", "日本"]
    with matplotlib.rc_context({"text.usetex": True, "font.size": 40}):
        path = draw_curves(tmp_path / f"names.{suffix}", TIME, curves(5, "measured"), names, "$x_")
    (sheet,) = sheets
    assert [axis.get_ylabel() for axis in sheet.axes] == names
    assert not any(text.get_parse_math() for axis in sheet.axes for text in (axis.yaxis.label, axis.xaxis.label))
    if suffix == "svg":
        assert all(name in path.read_text(encoding="utf-8") for name in (r"$\frac{", "a_$b$_c"))


def test_powers_at_axes_stay_formulas(sheets: list[matplotlib.figure.Figure], tmp_path: Path) -> None:
    with figure(tmp_path / "log.png", 1, 1, "") as (_, (axis,)):
        axis.semilogy([1.0, 1e6])
    (sheet,) = sheets
    labels = [label for label in sheet.axes[0].yaxis.get_ticklabels() if "mathdefault" in label.get_text()]
    assert labels
    assert all(label.get_parse_math() for label in labels)
