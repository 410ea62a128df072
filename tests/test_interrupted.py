"""Ctrl-C ends a command in one line, wherever it comes."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from hybrid.commands.console import command_line


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
