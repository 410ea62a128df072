"""The script that draws the pictures of a run: what it draws, and what it says about a folder it cannot use."""

import re
import subprocess
import sys
from pathlib import Path

import imageio.v3
import numpy as np

from fe_models.arrays import FloatArray
from fe_models.dofs import structure_dofs
from fe_models.files.atomic import write_npz
from fe_models.files.structure_file import save_structure
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


def test_script_draws_the_modes_of_a_model(tmp_path: Path) -> None:
    write_run(tmp_path)
    done = render_shapes(tmp_path, "--out", tmp_path / "pictures")
    said = [line for line in re.split(r"[\r\n]+", done.stderr) if line.strip() and not line.startswith("drawing modes")]
    assert (done.returncode, said) == (0, [])  # nor does VTK complain about a missing screen
    assert "mode 2, 5 Hz" in done.stdout
    assert "train_hybrid.py" in done.stdout
    assert len(list((tmp_path / "pictures").glob("*.png"))) == 3


def test_script_draws_a_training(tmp_path: Path) -> None:
    write_run(tmp_path)
    write_prediction(tmp_path)
    done = render_shapes(tmp_path, "--out", tmp_path / "pictures", "--format", "gif", "--frames", "3")
    assert done.returncode == 0, done.stderr
    drawn = {path.name for path in (tmp_path / "pictures").iterdir()}
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
