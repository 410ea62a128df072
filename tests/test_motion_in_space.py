"""Modes of a structure in space on a page: three numbers a point, and another side of it where it is turned."""

from pathlib import Path

import numpy as np
import pytest

from fe_models.files.atomic import write_npz
from fe_models.files.matrices_file import load_linear_model
from fe_models.linear import LinearModel
from fe_models.modes import natural_modes
from fe_models.pictures.geometry import outline
from fe_models.pictures.projection import VIEW, in_view, on_sheet
from fe_models.recordings import Dataset, Recording, Sensor
from hybrid.report.mode_shapes import mode_shapes
from hybrid.report.motion import Stage
from hybrid.report.page import Page, Section, Tone
from hybrid.report.rendering import rendered
from tests.browser import needs_browser, opened
from tests.space_frames import two_storeys

PROBE = """
<script>
const wrong = [];
addEventListener("error", (event) => wrong.push(event.message));
addEventListener("load", () => {
  const figure = document.querySelector(".motion");
  const labels = [...figure.querySelectorAll("label")];
  const range = (name) => labels.find((one) => one.textContent === name).firstElementChild;
  const still = () => figure.querySelector("path.still").getAttribute("d");
  const set = (name, value) => {
    range(name).value = value;
    range(name).dispatchEvent(new Event("input"));
    return still();
  };
  const before = still();
  const same = set("Turn", 0);
  const aside = set("Turn", 90);
  set("Turn", 0);
  const above = set("Height", 90);
  parent.postMessage(JSON.stringify({ wrong, before, same, aside, above }), "*");
});
</script>"""


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> LinearModel:
    path = tmp_path_factory.mktemp("space") / "floors.npz"
    write_npz(path, two_storeys())
    return load_linear_model(path)


@pytest.fixture(scope="module")
def data(model: LinearModel) -> Dataset:
    sensors = (Sensor("a", 3, "x", "acceleration", "m/s^2"), Sensor("b", 2, "y", "acceleration", "m/s^2"))
    return Dataset(model, 50.0, sensors, (Recording("r", np.zeros((1, 100, 2))),))


def test_what_is_seen_lies_on_the_sheet_and_turns_without_a_stretch(model: LinearModel) -> None:
    np.testing.assert_allclose(VIEW @ VIEW.T, np.eye(3), atol=1e-15)
    np.testing.assert_allclose(in_view(model.coordinates)[:, :2], on_sheet(model.coordinates))
    assert np.linalg.det(VIEW) == pytest.approx(1.0)  # what is in front is towards the eye, not behind the sheet


def test_a_point_moves_by_as_much_as_its_node_whatever_is_seen_of_it(data: Dataset, model: LinearModel) -> None:
    stage = Stage.of(outline(model), data.sensors)
    assert stage is not None
    shape = natural_modes(model, 3).shapes[:, 2]
    moved = stage.points(shape)
    rows = [[model.dofs.row(node, axis) for axis in ("x", "y")] for node in (3, 2)]
    assert moved.shape[1] == 3
    lengths = np.linalg.norm(moved[-2:], axis=1) / stage.factor
    np.testing.assert_allclose(lengths, [np.linalg.norm(shape[own]) for own in rows])  # floors do not move up or down
    np.testing.assert_allclose(np.linalg.norm(stage.ways, axis=1), 1.0)
    drawn = stage.motion([]).still
    assert drawn.shape == moved.shape
    heights = drawn @ np.array([0.0, -1.0, 0.0]) / stage.factor
    at = outline(model).coordinates[[2, 1], 1]
    assert heights[-2] - heights[-1] == pytest.approx(at[0] - at[1])


@pytest.mark.slow
@needs_browser
def test_it_turns_in_a_browser(data: Dataset, tmp_path: Path) -> None:
    figure = mode_shapes(data, None, None)
    assert figure is not None
    page = Page("Space", "", Tone.GOOD, "A frame.", "", (), (), (Section("why", "Why", (figure,)),), "")
    seen, console = opened(tmp_path, rendered(page), 1440, PROBE)
    assert (seen["wrong"], console) == ([], "")
    numbers = {name: np.array(_numbers(seen[name])) for name in ("before", "same", "aside", "above")}
    np.testing.assert_allclose(numbers["same"], numbers["before"], atol=0.11)  # numbers of a tenth of a pixel
    assert np.abs(numbers["aside"] - numbers["before"]).max() > 10
    tall = [np.ptp(numbers[name].reshape(-1, 2)[:, 1]) for name in ("before", "above")]
    assert tall[1] < tall[0]  # from above a frame shows its plan


def _numbers(path: str) -> list[float]:
    return [float(word) for word in path.replace("M", " ").replace("L", " ").split()]
