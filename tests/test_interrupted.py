"""Ctrl-C ends a command in one line, wherever it comes."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from hybrid.commands.console import command_line
from hybrid.diagnosis.parallel import parallel_map


@pytest.mark.parametrize("wrapped", [False, True])
def test_an_interrupt_is_one_line_and_its_exit_status(wrapped: bool, capsys: pytest.CaptureFixture[str]) -> None:
    """Also where a library turns it into an error of its own, as Exudyn does inside a function of the user."""
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(SystemExit) as end, command_line(quiet=False):
        try:
            os.kill(os.getpid(), signal.SIGINT)
        except KeyboardInterrupt:
            if not wrapped:
                raise
            raise RuntimeError("in a user function") from None
    assert end.value.code == 130
    assert capsys.readouterr().err == "Interrupted; results written before are whole.\n"
    assert signal.getsignal(signal.SIGINT) is before


def test_an_error_without_an_interrupt_stays_one() -> None:
    with pytest.raises(RuntimeError, match="of its own"), command_line(quiet=True):
        raise RuntimeError("of its own")


def test_a_command_ends_so(tmp_path: Path) -> None:
    """In a process of its own: what surrounds the command adds nothing to the line."""
    code = (
        "import os, signal\n"
        "import fe_models.synthetic as synthetic\n"
        "synthetic.simulate_free = lambda *a, **k: os.kill(os.getpid(), signal.SIGINT)\n"
        "from hybrid.commands.app import app\n"
        "app(['simulate', 'chain.toml', '--out', 'out', '--sensor', '1:x', '--realisations', '2'])\n"
    )
    (tmp_path / "chain.toml").write_text(
        'schema = 1\nname = "cart"\nnodes = [[0.0, 0.0]]\ndirections = ["x"]\n'
        'elements = [{ kind = "spring", nodes = [1], direction = "x", stiffness = 40.0 }]\n'
        "point_masses = [{ node = 1, mass = 1.0 }]\n"
    )
    run = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (run.returncode, run.stderr) == (130, "Interrupted; results written before are whole.\n"), run.stderr


@pytest.mark.slow
def test_a_command_deep_in_a_factorisation_ends_at_once(tmp_path: Path) -> None:
    """Which would go on for minutes, and hears no signal meanwhile."""
    code = """
import os, signal, threading, time
import numpy as np
from hybrid.commands.console import command_line

def interrupt():
    begun = time.process_time()
    while time.process_time() - begun < 0.7:
        time.sleep(0.01)
    os.kill(os.getpid(), signal.SIGINT)

with command_line(quiet=False):
    large = np.random.default_rng(0).random((6000, 6000))
    threading.Thread(target=interrupt, daemon=True).start()
    np.linalg.eigvals(large)
"""
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=60)
    assert (found.returncode, found.stderr) == (130, "Interrupted; results written before are whole.\n")


def test_what_runs_side_by_side_does_not_hold_ctrl_c_up() -> None:
    """Items that nobody has begun are let go."""
    begun = list[int]()

    def work(item: int) -> None:
        begun.append(item)
        if item == 0:
            raise KeyboardInterrupt
        time.sleep(0.02)

    with pytest.raises(KeyboardInterrupt):
        parallel_map(work, range(100))
    assert len(begun) < 50
