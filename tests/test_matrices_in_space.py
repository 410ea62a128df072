"""Training, prediction and pictures of a model in space, whose corner follows its floor by a rigid link."""

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import fe_models as fe
from fe_models.files.atomic import write_npz
from fe_models.files.matrices_file import load_linear_model
from fe_models.files.run_folder import load_run
from fe_models.linear import LinearModel
from fe_models.pictures.geometry import deformed_lines, largest_displacement, nodal_motion, nodal_size, outline
from fe_models.pictures.projection import SHEET, on_sheet
from hybrid.commands.app import app
from tests.space_frames import FOLLOWED, two_storeys

OPTIONS = ("--window", "80", "--batch", "8", "--first-horizon", "20", "--threads", "1", "--epochs", "1")


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("space") / "floors.npz"
    write_npz(path, two_storeys())
    return path


def called(*words: object) -> str:
    answer = CliRunner().invoke(app, [str(word) for word in words])
    assert answer.exit_code == 0, answer.output
    return answer.output


@pytest.mark.slow
def test_simulated_trained_on_and_drawn(file: Path, tmp_path: Path) -> None:
    """The learned model's field has the corner's motion, u + theta x r of its floor's, at every instant."""
    pulls = ("--pull", "3:x:1000+4:y:-200", "--pull", "2:y:500", "--pull", "3:rz:800")
    sensors = ("--sensor", "3:x", "--sensor", "4:y", "--sensor", "2:y", "--sensor", "2:rz")
    called("simulate", file, "--out", tmp_path / "data", *pulls, *sensors, "--duration", "6", "--no-pictures")
    called("train", tmp_path / "data" / "dataset.toml", "--out", tmp_path / "run", *OPTIONS)
    run = load_run(tmp_path / "run")
    assert isinstance(run.model, LinearModel)
    assert run.prediction is not None
    dofs = run.model.dofs
    corner, floor, turn = (run.prediction.hybrid[:, dofs.row(*at)] for at in ((FOLLOWED, "y"), (2, "y"), (2, "rz")))
    np.testing.assert_allclose(corner, floor + 2.0 * turn, atol=1e-5 * np.abs(corner).max())  # float32
    called("render", tmp_path / "run", "--out", tmp_path / "pictures")
    assert (tmp_path / "pictures" / "modes.png").stat().st_size > 10_000


def test_what_is_drawn_lies_on_the_sheet_and_is_coloured_by_its_true_size(file: Path) -> None:
    model = load_linear_model(file)
    shape = outline(model)
    assert shape.in_space
    np.testing.assert_allclose(shape.coordinates, model.coordinates @ SHEET.T)
    np.testing.assert_allclose(SHEET @ SHEET.T, np.eye(2), atol=1e-15)  # seen from straight ahead
    u = np.zeros(len(model.dofs))
    u[model.dofs.row(3, "x")], u[model.dofs.row(3, "y")] = 3.0, 4.0
    assert nodal_size(shape, u)[2] == 5.0
    np.testing.assert_allclose(nodal_motion(shape, u)[2, :2], on_sheet(np.array([3.0, 4.0, 0.0])))
    lines = {group.kind: group for group in deformed_lines(shape, u, 2.0)}
    upper = lines["beam"].points[1]
    np.testing.assert_allclose(upper[1], on_sheet(model.coordinates[2] + 2.0 * np.array([3.0, 4.0, 0.0])))
    assert lines["beam"].magnitude[1].tolist() == [0.0, 5.0]
    assert largest_displacement(shape, [u]) == 5.0


def test_sensors_point_along_their_axes_on_the_sheet(file: Path) -> None:
    shape = outline(load_linear_model(file))
    np.testing.assert_allclose(shape.along("z"), [0.0, 1.0])
    across, up = shape.along("y")
    assert across < 0 < up  # y leads to the left and back


def test_modes_of_a_plane_model_are_drawn_as_before() -> None:
    shape = outline(fe.bridge())
    assert not shape.in_space
    assert shape.bends
    np.testing.assert_allclose(shape.along("y"), [0.0, 1.0])
