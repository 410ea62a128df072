"""What a case ran on, in words."""

import os
import platform
from importlib.metadata import version
from pathlib import Path


def machine(jobs: int) -> str:
    """Return how many cases ran at a time on what: cores, processor, system, and versions that numbers depend on."""
    libraries = ", ".join(f"{name} {version(name)}" for name in ("numpy", "scipy", "numba"))
    computer = f"{os.cpu_count()} cores, {_processor()}, {platform.system()}"
    return f"{jobs} at a time on {computer}; Python {platform.python_version()}, {libraries}"


def _processor() -> str:
    """Return the processor's name, which Python itself does not know on Linux."""
    listed = Path("/proc/cpuinfo")
    if listed.is_file():
        for line in listed.read_text().splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    return platform.processor() or platform.machine()
