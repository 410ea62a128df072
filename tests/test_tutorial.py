"""The tutorial runs as it stands: its files, then its commands, one after the other, in an empty folder."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

TUTORIAL = Path(__file__).parents[1] / "docs" / "tutorial.md"
BLOCK = re.compile(r"^```(toml file=(?P<file>\S+)|sh)\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL)


@pytest.mark.slow
def test_the_tutorial_leads_from_a_drawing_to_a_named_cause(tmp_path: Path) -> None:
    script = ["set -e"]
    for block in BLOCK.finditer(TUTORIAL.read_text()):
        if block["file"]:
            (tmp_path / block["file"]).write_text(block["text"])
        else:
            script.append(block["text"])
    assert len(script) > 5
    path = os.pathsep.join((str(Path(sys.executable).parent), os.environ["PATH"]))  # where hybrid-modal is
    environment = {**os.environ, "PATH": path, "PYTHONPATH": str(TUTORIAL.parents[1])}
    done = subprocess.run(
        ["bash", "-c", "\n".join(script)], cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    report = json.loads((tmp_path / "runs/diagnosis/report.json").read_text())
    (finding,) = report["findings"]
    assert (finding["kind"], finding["location"]) == ("added_mass", {"node": 3})
    assert finding["probability"] > 0.9
    mass = finding["parameters"]["mass"]
    assert abs(mass["value"] - 15.0) < 3 * mass["std"]
    assert (tmp_path / "runs/hybrid/metrics.json").is_file()
    assert list((tmp_path / "runs/pictures").glob("*.png"))
