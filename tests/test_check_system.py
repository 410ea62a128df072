"""What the set-up says about a machine that cannot run the product."""

import ctypes
import runpy
import sys
from pathlib import Path
from typing import Any

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
