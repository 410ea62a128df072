"""A fleet of real diagnoses by the command, killed and begun again."""

import json
import subprocess
import sys
import time
from pathlib import Path

import pytest

from benchmarks.blind_cases import BlindConfig, blind_case
from fe_models.files.dataset_file import save_dataset

ROOT = Path(__file__).parents[1]


def started(folder: Path, out: Path) -> "subprocess.Popen[str]":
    script = "from hybrid.commands.app import app; app()"
    words = ["diagnose", str(folder), "--out", str(out), "--jobs", "1"]
    return subprocess.Popen(
        [sys.executable, "-c", script, *words], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


@pytest.mark.slow
def test_a_fleet_that_is_killed_loses_what_is_in_work_alone(tmp_path: Path) -> None:
    folder, out = tmp_path / "chains", tmp_path / "out"
    for name, kind, seed in (("a", "added_mass", 31), ("b", "stiffness_change", 14)):
        config = BlindConfig((kind,), size=0.8, train=3, test=1, duration=20.0)
        save_dataset(blind_case(seed, config).dataset, folder / name)
    (folder / "broken.toml").write_text("sensors = [")
    run, first = started(folder, out), out / ".fleet" / "a.json"
    end = time.monotonic() + 1500  # s: seconds of a core, of a busy machine
    while not first.exists() and time.monotonic() < end:
        assert run.poll() is None, run.communicate()
        time.sleep(0.05)
    run.kill()
    run.communicate()
    before = {path: path.stat().st_mtime_ns for path in [first, *(out / "a").iterdir()]}
    assert out / "a" / "report.html" in before
    again = started(folder, out)
    printed, said = again.communicate(timeout=1500)
    assert again.returncode == 1, said  # one dataset is broken
    assert {path: path.stat().st_mtime_ns for path in before} == before
    assert said.startswith("error: broken: broken.toml: not valid TOML")
    assert said.count("\n") == 1
    table = json.loads((out / "fleet.json").read_text())
    assert [(own["name"], own["state"]) for own in table["cases"]] == [
        ("a", "diagnosed"),
        ("b", "diagnosed"),
        ("broken", "failed"),
    ]
    assert [own.get("verdict") for own in table["cases"]] == ["explained", "explained", None]
    assert "element" in table["cases"][1]["sentence"].lower()
    assert "a " in printed and "error: broken.toml" in printed
    page = (out / "fleet.html").read_text()
    assert page.count('/report.html">') == 2
