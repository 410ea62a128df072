"""What the set-up says about a machine that cannot run the product."""

import ctypes
import runpy
import sys
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import pytest

SCRIPT = Path(__file__).parents[1] / "scripts" / "check_system.py"


def faults() -> list[str]:
    found: list[str] = runpy.run_path(str(SCRIPT))["faults"]()
    return found


def test_this_machine_will_do() -> None:
    assert faults() == []


def test_a_missing_library_is_named_with_the_command_that_brings_it(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> Any:
        raise OSError(name)

    monkeypatch.setattr(ctypes, "CDLL", missing)
    lines = faults()
    assert "libGL.so.1" in lines[0]
    assert "apt-get install libgl1" in lines[0]
    assert len(lines) == 2


@pytest.mark.parametrize("version", [(3, 10, 0), (3, 14, 1)])
def test_another_python_is_refused(monkeypatch: pytest.MonkeyPatch, version: tuple[int, int, int]) -> None:
    monkeypatch.setattr(sys, "version_info", version)
    assert f"Python 3.{version[1]} is not supported" in faults()[0]


def test_only_what_is_missing_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    def without_egl(name: str) -> None:
        if name == "libEGL.so.1":
            raise OSError(name)

    monkeypatch.setattr(ctypes, "CDLL", without_egl)
    (line,) = faults()
    assert "libEGL.so.1" in line
    assert "libegl1" in line


@pytest.mark.parametrize("minor", [11, 12, 13])
def test_the_supported_pythons_pass(monkeypatch: pytest.MonkeyPatch, minor: int) -> None:
    monkeypatch.setattr(sys, "version_info", (3, minor, 0))
    assert faults() == []


def test_the_program_ends_with_2_and_a_line_each(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "version_info", (3, 9, 0))
    monkeypatch.setattr(ctypes, "CDLL", Mock(side_effect=OSError))
    with pytest.raises(SystemExit) as caught:
        runpy.run_path(str(SCRIPT), run_name="__main__")
    assert caught.value.code == 2
    assert len(capsys.readouterr().err.splitlines()) == 3


def test_it_needs_nothing_that_is_not_in_every_python() -> None:
    """It runs before anything is installed, on whatever Python is there."""
    words = [line.split()[1] for line in SCRIPT.read_text().splitlines() if line.startswith(("import ", "from "))]
    assert words
    assert set(words) <= set(sys.stdlib_module_names)
