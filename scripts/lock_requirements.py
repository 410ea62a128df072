"""Write the locks that 'make setup' installs from: every package, with the digests of all its files on PyPI.

python scripts/lock_requirements.py CPU_WHEEL_SHA256...      needs uv (pip install uv)

Versions are those of constraints.txt. PyTorch has two locks of its own: the wheels without CUDA, which lie on PyTorch's
own index and whose digests are given, and PyPI's, which bring gigabytes of libraries on Linux.
"""

import re
import subprocess
import sys
import tomllib
from argparse import ArgumentParser
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

ROOT = Path(__file__).parents[1]
LOCK = ROOT / "requirements.lock"
TORCH_LOCKS = {kind: ROOT / f"requirements-torch-{kind}.lock" for kind in ("cpu", "pypi")}
OWN = re.compile(r"hybrid-modal\b")
TORCH = re.compile(r"torch==\S+")
OF_CUDA = re.compile(r"(nvidia-|cuda-|triton==)")  # what PyPI's torch alone asks for, on Linux
HEADER = "# Made by scripts/lock_requirements.py from pyproject.toml and constraints.txt: do not edit.\n"


def wanted() -> dict[str, Any]:
    """Return a project that needs all that the set-up installs, of both of ours, and what builds them."""
    own, benchmarks = (
        tomllib.loads((ROOT / place / "pyproject.toml").read_text(encoding="utf-8")) for place in ("", "benchmarks")
    )
    project = own["project"]
    extras = project["optional-dependencies"]
    every = [*project["dependencies"], *extras["fleet"], *extras["dev"], *benchmarks["project"]["dependencies"]]
    every += own["build-system"]["requires"]
    named = [requirement for requirement in every if not OWN.match(requirement)]
    return {"name": "set-up", "version": "0", "requires-python": project["requires-python"], "dependencies": named}


def resolved(project: dict[str, Any]) -> list[str]:
    """Return an entry of a requirements file for each package, with its digests, for all systems."""
    from tomli_w import dumps

    words = ["uv", "pip", "compile", "pyproject.toml", "--universal", "--generate-hashes", "--no-header"]
    words += ["--no-annotate", "--constraint", str(ROOT / "constraints.txt"), "--python-version", "3.11"]
    with TemporaryDirectory() as folder:
        (Path(folder) / "pyproject.toml").write_text(dumps({"project": project}), encoding="utf-8")
        text = subprocess.run(words, cwd=folder, check=True, capture_output=True, text=True).stdout
    return re.findall(r"^\S.*(?:\n .*)*\n", text, re.MULTILINE)


def digest(word: str) -> str:
    """Return a SHA-256 in hexadecimal digits; `ValueError` where it is none."""
    if not re.fullmatch(r"[0-9a-f]{64}", word):
        raise ValueError(word)
    return word


def main(digests: list[str]) -> int:
    """Write the locks; return the exit status."""
    entries = resolved(wanted())
    (torch,) = (entry for entry in entries if TORCH.match(entry))
    of_cuda = [entry for entry in entries if OF_CUDA.match(entry)]
    without_cuda = " \\\n    ".join([f"{torch.split()[0]}+cpu", *(f"--hash=sha256:{digest}" for digest in digests)])
    _write(LOCK, [entry for entry in entries if entry not in (torch, *of_cuda)])
    _write(TORCH_LOCKS["cpu"], [f"{without_cuda}\n"])
    _write(TORCH_LOCKS["pypi"], [torch, *of_cuda])
    return 0


def _write(lock: Path, entries: list[str]) -> None:
    lock.write_text(HEADER + "".join(entries), encoding="utf-8")


if __name__ == "__main__":
    parser = ArgumentParser(description="Write the locks that 'make setup' installs from.")
    parser.add_argument("digests", nargs="+", type=digest, metavar="CPU_WHEEL_SHA256", help="of torch without CUDA")
    sys.exit(main(parser.parse_args().digests))
