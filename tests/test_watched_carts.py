"""The watch on recordings of a structure, from the command to the diagnosis of what changed."""

import json
import subprocess
import sys
import time
from math import pi
from pathlib import Path

import pytest
from typer.testing import CliRunner

from hybrid.commands.app import app
from hybrid.commands.watch import ALARM_STATUS
from tests.watched_carts import STIFFNESS, natural_modes, record, station

ROOT = Path(__file__).parents[1]


@pytest.mark.slow
def test_a_spring_that_softens_raises_an_alarm_and_is_named(tmp_path: Path) -> None:
    """Ten per cent of the first spring, of which a standard deviation of 1 % is normal."""
    folder, out = tmp_path / "carts", tmp_path / "out"
    station(folder)
    for day in range(1, 9):
        record(folder, f"day{day}", day, age=100.0 - day)
    words = ["watch", str(folder), "--out", str(out), "--once"]
    ran = CliRunner().invoke(app, words)
    assert ran.exit_code == 0, ran.output
    table = json.loads((out / "watch.json").read_text())
    assert [own["standing"] for own in table["observations"]] == ["history"] * 5 + ["as usual"] * 4
    first = table["observations"][0]["modes"]
    exact = natural_modes(STIFFNESS)[0] / (2 * pi)
    assert [mode["frequency"] for mode in first] == pytest.approx(exact, rel=3e-3)  # springs scatter by 0.1 %
    record(folder, "soft", 20, softened=0.9, age=20.0)
    ran = CliRunner().invoke(app, words)
    assert ran.exit_code == ALARM_STATUS, ran.output
    assert "ALARM: soft" in ran.stderr
    report = json.loads((out / "change-soft" / "report.json").read_text())
    assert report["verdict"] == "explained"
    cause = report["findings"][0]
    assert cause["kind"] == "stiffness_change"
    assert cause["location"] == {"element": 1}
    assert cause["parameters"]["factor"]["value"] == pytest.approx(0.9, abs=0.01)
    assert (out / "change-soft" / "report.html").is_file()


@pytest.mark.slow
def test_an_interrupt_ends_a_watch_at_once_and_it_goes_on(tmp_path: Path) -> None:
    folder, out = tmp_path / "carts", tmp_path / "out"
    station(folder)
    script = "from hybrid.commands.app import app; app()"
    words = ["watch", str(folder), "--out", str(out), "--every", "3600"]
    running = subprocess.Popen(
        [sys.executable, "-c", script, *words], cwd=ROOT, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True
    )
    end = time.monotonic() + 300  # s: a busy machine
    while not (out / "watch.html").exists() and time.monotonic() < end:
        time.sleep(0.05)
    begun = time.monotonic()
    running.send_signal(2)
    _, said = running.communicate(timeout=60)
    assert time.monotonic() - begun < 10.0  # a tenth of a second on an idle machine
    assert (running.returncode, said) == (130, "Interrupted; results written before are whole.\n")
    assert len(json.loads((out / "watch.json").read_text())["observations"]) == 1
