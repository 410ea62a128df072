"""The script that draws the pictures of a run: what it draws, and what it says about a folder it cannot use."""

import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import imageio.v3
import numpy as np
import pytest

from fe_models.arrays import FloatArray
from fe_models.dofs import structure_dofs
from fe_models.errors import InputError
from fe_models.files.atomic import write_npz
from fe_models.files.result_list import LIST_FILE
from fe_models.files.run_folder import load_run
from fe_models.files.structure_file import save_structure
from fe_models.pictures import render
from fe_models.pictures.captions import pace
from fe_models.pictures.drawing import Picture
from fe_models.pictures.run_pictures import PictureOptions, draw_prediction, draw_run, film_rows
from fe_models.sections import Section
from fe_models.structure import Beam, Cable, Structure, Support

ROOT = Path(__file__).parent.parent
STEEL = Section("steel", 2.1e11, 7850.0, 1e-4, 1e-9)


def portal() -> Structure:
    return Structure(
        name="portal",
        nodes=((0.0, 0.0), (0.0, 3.0), (4.0, 3.0), (4.0, 0.0)),
        elements=(Beam((1, 2), STEEL), Beam((2, 3), STEEL), Beam((4, 3), STEEL), Cable((1, 3), STEEL)),
        supports=(Support(1, ("x", "y", "rz")), Support(4, ("x", "y"))),
    )


def random_frames(structure: Structure, count: int, size: float = 1e-3) -> FloatArray:
    dofs = structure_dofs(structure)
    return np.random.default_rng(2).normal(scale=size, size=(count, len(dofs))) * dofs.free


def render_shapes(*arguments: str | Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-W", "error", "scripts/render_shapes.py", *map(str, arguments)]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)


def write_run(folder: Path) -> None:
    shapes = random_frames(portal(), 2).T
    save_structure(portal(), folder / "structure.toml")
    ratio = np.array([0.01, 0.02])
    write_npz(
        folder / "model.npz", {"frequencies": np.array([2.0, 5.0]), "mode_shapes": shapes, "damping_ratio": ratio}
    )


def write_prediction(folder: Path, **changes: object) -> None:
    hybrid = random_frames(portal(), 5)
    content = {"time": np.arange(5) * 0.1, "hybrid": hybrid, "fe": 1.1 * hybrid, "truth": hybrid, "unit": "1"}
    content |= {"sensor_name": ["A1"], "sensor_node": [2], "sensor_direction": ["x"], "sensor_role": ["measured"]}
    np.savez(folder / "prediction.npz", **(content | changes))  # type: ignore[arg-type]  # savez types its flags too


@pytest.mark.slow
def test_script_draws_the_modes_of_a_model(tmp_path: Path) -> None:
    write_run(tmp_path)
    done = render_shapes(tmp_path, "--out", tmp_path / "pictures")
    said = [line for line in re.split(r"[\r\n]+", done.stderr) if line.strip() and not line.startswith("drawing modes")]
    assert (done.returncode, said) == (0, [])  # nor does VTK complain about a missing screen
    assert "mode 2, 5 Hz" in done.stdout
    assert "hybrid-modal train" in done.stdout
    names = {path.name for path in (tmp_path / "pictures").glob("*.png")}
    assert names == {"structure.png", "mode_01.png", "mode_02.png", "modes.png"}


@pytest.mark.slow
def test_script_draws_a_training(tmp_path: Path) -> None:
    write_run(tmp_path)
    write_prediction(tmp_path)
    done = render_shapes(tmp_path, "--out", tmp_path / "pictures", "--format", "gif", "--frames", "3")
    assert done.returncode == 0, done.stderr
    drawn = {path.name for path in (tmp_path / "pictures").iterdir()} - {LIST_FILE}
    assert {"snapshots.png", "initial_deformation.png", "animation.gif", "modes.png"} <= drawn
    assert all(name in done.stdout for name in drawn)
    assert len(imageio.v3.imread(tmp_path / "pictures" / "animation.gif")) == 3


def test_script_names_every_fault_and_exits_with_2(tmp_path: Path) -> None:
    write_run(tmp_path)
    write_prediction(tmp_path, fe=np.zeros((4, 12)), time=np.full(5, np.nan), unit="mm", sensor_node=[77])
    done = render_shapes(tmp_path, "--out", tmp_path / "pictures")
    assert done.returncode == 2
    assert not (tmp_path / "pictures").exists()
    for part in ("'fe' is float64 of shape (4, 12)", "'time' holds values", "unit is 'mm'", "sits at node 77"):
        assert part in done.stderr
    assert all(line.startswith("error: ") for line in done.stderr.splitlines())
    missing = render_shapes(tmp_path / "nowhere", "--out", tmp_path / "pictures")
    assert missing.returncode == 2
    assert "no such folder" in missing.stderr


def texts_of(write: Callable[[], object], monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """The texts of the pictures that ``write`` paints, without painting them."""
    texts: list[str] = []

    def keep(picture: Picture, path: Path) -> Path:
        texts.extend(text.text for text in picture.texts)
        return path

    monkeypatch.setattr(render, "_write", keep)
    write()
    return texts


@pytest.mark.parametrize("scale", [0.5, 1.0, 25.0, 1500.0])
def test_the_scale_that_is_asked_for_is_drawn_and_said(
    scale: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_run(tmp_path)
    write_prediction(tmp_path, unit="m")
    run = load_run(tmp_path)
    prediction = run.prediction
    assert prediction is not None
    texts = texts_of(lambda: draw_prediction(run, prediction, tmp_path, PictureOptions(scale=scale)), monkeypatch)
    said = f"displacements drawn {scale:,g} times as large" if scale != 1 else "drawn to the scale of the structure"
    assert sum(said in text for text in texts) == 2, texts  # snapshots, initial deformation


def test_a_film_runs_at_the_speed_that_is_asked_for() -> None:
    """As smoothly as 25 frames a second where samples are dense enough; a sample a frame where they are not."""
    time = np.linspace(0.0, 20.0, 2001)
    for speed, rate in ((1.0, 25.0), (0.25, 25.0), (0.1, 10.0), (10.0, 25.0)):
        rows, fps = film_rows(time, None, speed)
        assert fps == pytest.approx(rate)
        assert time[rows[-1]] == pytest.approx(20.0)
        assert (len(rows) - 1) / fps == pytest.approx(20.0 / speed)
        slower = pace(len(rows), fps, float(time[rows[-1]]))
        assert slower == {1.0: "shown in real time", 10.0: "shown 10 times faster"}.get(
            speed, f"shown {1 / speed:g} times slower"
        )
    rows, fps = film_rows(time, 100, 1.0)
    assert len(rows) == 100
    assert fps == pytest.approx(25.0)
    assert time[rows[-1]] == pytest.approx(99 * 0.04)  # its beginning
    rows, _ = film_rows(time, 20, None, fastest=2.0)  # eight frames a period of 0.5 s, and no more than 20
    assert len(rows) == 20
    assert np.diff(time[rows]).max() <= 0.5 / 8
    rows, fps = film_rows(time, None, None)
    assert (len(rows), fps) == (223, 25.0)  # every ninth sample: at most 250
    assert rows[-1] > 1990


def test_options_that_cannot_be_drawn_are_all_named_at_once(tmp_path: Path) -> None:
    with pytest.raises(InputError) as raised:
        draw_run(tmp_path / "missing", tmp_path, PictureOptions(interval=-1.0, scale=0.0, speed=float("nan")))
    assert [fault.split(":")[0] for fault in raised.value.faults] == [
        "--interval -1",
        "--scale 0",
        "--speed nan",
        str(tmp_path / "missing"),
    ]
    assert "1 is real time, 0.1 ten times slower" in str(raised.value)
