"""What the program is made of: locked packages, their licences, the wheel that 'pip install' makes of the sources."""

import re
import shutil
import subprocess
import sys
import tomllib
from importlib.metadata import Distribution
from pathlib import Path
from unittest.mock import Mock
from zipfile import ZipFile

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from scripts.licences import NOT_STATED, licence_of, main, needed
from scripts.lock_requirements import LOCK, OF_CUDA, ROOT, TORCH_LOCKS, wanted

ENTRY = re.compile(r"^(?P<name>[A-Za-z0-9._-]+)==(?P<version>[^ ]+)(?: ; [^\\]+)? \\$")


def locked(path: Path) -> dict[str, str]:
    """The version of each package in a lock; all of its lines are entries with digests."""
    found = dict[str, str]()
    for entry in re.split(r"\n(?=\S)", path.read_text().split("\n", 1)[1].rstrip()):
        head, *digests = entry.split("\n")
        named = ENTRY.match(head)
        assert named, head
        assert digests
        assert all(re.fullmatch(r"    --hash=sha256:[0-9a-f]{64}(?: \\)?", line) for line in digests), entry
        found[canonicalize_name(named["name"])] = named["version"]
    return found


def test_all_that_the_set_up_installs_is_locked() -> None:
    """With the versions of the constraints, from which pages and wheels elsewhere are made."""
    cpu, pypi = (locked(TORCH_LOCKS[kind]) for kind in ("cpu", "pypi"))
    assert list(cpu) == ["torch"]
    assert cpu["torch"] == f"{pypi['torch']}+cpu"
    found = locked(LOCK) | {"torch": pypi.pop("torch")}
    for requirement in map(Requirement, wanted()["dependencies"]):
        assert requirement.specifier.contains(found[canonicalize_name(requirement.name)]), requirement
    pairs = (line.split("==") for line in (ROOT / "constraints.txt").read_text().split())
    versions = {str(canonicalize_name(name)): version for name, version in pairs}
    assert {name for name, version in found.items() if versions.get(name, version) != version} == set()
    assert not any(OF_CUDA.match(f"{name}==") for name in found)
    assert all(OF_CUDA.match(f"{name}==") for name in pypi)


def test_licences_of_all_packages_are_listed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["dev"]) == 0
    lines = capsys.readouterr().out.splitlines()
    rows = {line.split()[0]: line.split(maxsplit=2)[2] for line in lines}
    assert rows["numpy"].startswith("BSD-3-Clause")
    assert rows["hybrid-modal"] == "MIT"
    assert "pytest" in rows
    assert rows.keys() <= locked(LOCK).keys() | {"hybrid-modal", "torch"}
    assert "pytest" not in needed("hybrid-modal")


def test_a_package_without_a_licence_is_no_licence() -> None:
    fields = {"License": ["UNKNOWN"], "Classifier": ["Topic :: Software Development"]}
    own = Mock(spec=Distribution, metadata=Mock(get_all=fields.get))
    assert licence_of(own) == NOT_STATED
    fields["License"] = ["A Licence\nof many\nlines"]
    assert licence_of(own) == "A Licence"
    fields["License-Expression"] = ["MIT"]
    assert licence_of(own) == "MIT"


@pytest.mark.slow
def test_the_wheel_is_whole_and_runs_where_it_is_installed(tmp_path: Path) -> None:
    """Of a copy of the sources, beside the packages that are installed already, by none of the sources' own files."""
    sources = tmp_path / "sources"
    kept = ("fe_models", "hybrid", "pyproject.toml", "README.md", "LICENSE")
    sources.mkdir()
    for name in kept:
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
        copy(ROOT / name, sources / name)
    pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check"]
    build = ["wheel", "--no-deps", "--no-build-isolation", "--wheel-dir", str(tmp_path), str(sources)]
    subprocess.run([*pip, *build], check=True)
    (wheel,) = tmp_path.glob("hybrid_modal-*.whl")
    names = set(ZipFile(wheel).namelist())
    for package in ("fe_models", "hybrid"):
        files = [path for path in (ROOT / package).rglob("*.py") if path.read_text()]
        assert {path.relative_to(ROOT).as_posix() for path in files} <= names
    assert not any(name.startswith(("tests/", "benchmarks/", "scripts/")) for name in names)
    site = tmp_path / "site"
    subprocess.run([*pip, "install", "--no-deps", "--no-index", "--target", str(site), str(wheel)], check=True)
    words = "import hybrid, sys; from hybrid.commands.app import app; print(hybrid.__file__); app(sys.argv[1:])"
    options = ["simulate", "four_dof", "--out", "data", "--realisations", "2", "--duration", "5", "--no-pictures"]
    run = subprocess.run(
        [sys.executable, "-c", words, *options],
        cwd=tmp_path,
        env={"PYTHONPATH": str(site), "PATH": "/usr/bin:/bin", "HOME": str(tmp_path)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert run.stdout.startswith(str(site))
    assert (tmp_path / "data/dataset.toml").is_file()
    version = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"]
    assert f"-{version}-" in wheel.name
