"""Where an answer comes from: the command that repeats it, its inputs with their hashes, and what made it."""

import platform
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from fe_models.files.inputs import files_read
from fe_models.files.result_list import digest
from fe_models.files.run_guard import remembered
from hybrid.report.page import Block, Bullets, Cell, Heading, Paragraph, Table

PACKAGES = ("hybrid-modal", "numpy", "scipy", "exudyn", "torch", "matplotlib")


@dataclass(frozen=True)
class InputFile:
    """A file that was read: its ``name``, ``size`` in bytes and SHA-256 when the run began."""

    name: str
    size: int
    sha256: str


@dataclass(frozen=True)
class Provenance:
    """The ``command`` that was given, ``inputs`` that it read, ``versions`` of what it used, and when it was
    ``written``; ``seed``: of what is random, in words; ``seconds`` that it took.
    """

    command: str
    inputs: tuple[InputFile, ...]
    versions: tuple[tuple[str, str], ...]
    written: datetime
    seed: str
    seconds: float


def provenance_of(command: Sequence[str], dataset: Path, seed: str, seconds: float) -> Provenance:
    """Return where an answer from the ``dataset`` file comes from, by the words of a ``command``; files are named
    relative to it.
    """
    return Provenance(shlex.join(command), inputs_of(dataset), versions(), datetime.now().astimezone(), seed, seconds)


def inputs_of(dataset: Path) -> tuple[InputFile, ...]:
    """Return the files that a diagnosis of the ``dataset`` file reads."""
    return tuple(_input(path, dataset.parent) for path in files_read(dataset))


def in_python(call: str, seed: str, seconds: float) -> Provenance:
    """Return where an answer of a ``call`` in Python comes from: its inputs are objects."""
    return Provenance(call, (), versions(), datetime.now().astimezone(), seed, seconds)


def versions() -> tuple[tuple[str, str], ...]:
    """Return the versions of Python, of this program and of the libraries that numbers depend on."""
    found = [("Python", platform.python_version())]
    for name in PACKAGES:
        try:
            found.append((name, version(name)))
        except PackageNotFoundError:  # of a source tree that is not installed
            continue
    return (*found, ("system", f"{platform.system()} {platform.machine()}"))


def _input(path: Path, home: Path) -> InputFile:
    name = path.relative_to(home) if path.is_relative_to(home) else path.name
    return InputFile(str(name), path.stat().st_size, remembered(path) or digest(path))


def repeated(provenance: Provenance) -> tuple[Block, ...]:
    """Return what somebody needs to get the same answer again."""
    rows = tuple(
        (Cell(own.name), Cell(f"{own.size:,}", float(own.size)), Cell(own.sha256)) for own in provenance.inputs
    )
    used = ", ".join(f"{name} {own}" for name, own in provenance.versions)
    files = [Table("Files that were read.", ("file", "bytes", "SHA-256"), rows)] if rows else []
    return (
        Heading("To repeat it"),
        Paragraph(f"Command: {provenance.command}"),
        Bullets(
            (
                f"Versions: {used}.",
                f"Random numbers: {provenance.seed}.",
                f"It took {provenance.seconds:.3g} s on this machine.",
            )
        ),
        *files,
    )


def written_by(provenance: Provenance) -> str:
    """Return the foot of a page."""
    own = dict(provenance.versions).get("hybrid-modal", "")
    return (
        f"Written {provenance.written:%d %B %Y, %H:%M} by hybrid-modal {own}. This page is whole in itself: it loads"
        " nothing and reports to nobody."
    )
