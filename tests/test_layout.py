"""Imports run one way, fe_models <- hybrid <- benchmarks <- scripts; heavy libraries are loaded by one home each."""

import ast
import re
import subprocess
import sys
import tomllib
from fnmatch import fnmatch
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
HOMES = {  # library: the only files that may import it
    "exudyn": {
        "fe_models/exudyn/item_matrices.py",
        "fe_models/exudyn/items.py",
        "fe_models/exudyn/solve.py",
        "fe_models/exudyn/internal_forces.py",
    },
    "pyvista": {"fe_models/pictures/render.py"},
}

ABOVE = {"benchmarks", "scripts"}  # what the library never imports


def imported(path: Path) -> set[str]:
    """Top-level packages that a file imports anywhere, also inside functions."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name.split(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found.add(node.module.split(".")[0])
    return found


@pytest.mark.parametrize(
    ("package", "banned"),
    [("fe_models", {"torch", "hybrid", *ABOVE}), ("hybrid", ABOVE), ("benchmarks", {"scripts"})],
)
def test_imports_run_one_way(package: str, banned: set[str]) -> None:
    files = list((ROOT / package).rglob("*.py"))
    assert len(files) > 10
    assert [path.name for path in files if imported(path) & banned] == []


def test_each_folder_of_the_diagnosis_imports_from_those_before_it_alone() -> None:
    """In the order in which the package's docstring names them."""
    home = ROOT / "hybrid" / "diagnosis"
    told = ast.get_docstring(ast.parse((home / "__init__.py").read_text())) or ""
    order = [word for word in re.findall(r"`(\w+)`", told) if (home / word).is_dir()]
    assert set(order) == {path.parent.name for path in home.glob("*/__init__.py")}
    for number, folder in enumerate(order):
        later = "|".join([*order[number + 1 :], "diagnosis", "report"])
        for path in (home / folder).glob("*.py"):
            assert not re.search(rf"hybrid\.diagnosis\.(?:{later})\b", path.read_text()), path


@pytest.mark.parametrize("library", HOMES)
def test_heavy_libraries_have_one_home(library: str) -> None:
    files = [path for folder in ("fe_models", "hybrid", *ABOVE) for path in (ROOT / folder).rglob("*.py")]
    users = {path.relative_to(ROOT).as_posix() for path in files if library in imported(path)}
    assert users
    assert users <= HOMES[library]


def test_importing_any_module_loads_neither_exudyn_nor_pyvista() -> None:
    """But for Exudyn's own homes; what only learns or reads files starts without either. fe_models loads no torch."""
    paths = [path for folder in ("fe_models", "hybrid") for path in sorted((ROOT / folder).rglob("*.py"))]
    modules = [
        ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
        for path in paths
        if path.parent.name != "exudyn"
    ]
    assert "hybrid.neural_modal_ode.model" in modules
    assert modules.index("hybrid") > modules.index("fe_models.structure")
    script = (
        "import importlib, sys\n"
        f"for name in {modules}:\n"
        "    importlib.import_module(name)\n"
        "    heavy = {'exudyn', 'pyvista', 'vtk', 'vtkmodules'} | set(['torch'] * name.startswith('fe_models'))\n"
        "    if heavy & set(sys.modules):\n"
        "        sys.exit(f'{name} loads {heavy & set(sys.modules)}')\n"
    )
    done = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_a_diagnosis_loads_no_torch() -> None:
    """Only what learns does, which takes longer to load than a chain to screen."""
    script = "import sys\nimport hybrid.diagnosis.diagnosis\nsys.exit('torch' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", script], cwd=ROOT, check=False).returncode == 0


def test_every_package_is_installed() -> None:
    """An editable installation finds them all, another one only folders that have an __init__.py."""
    found = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["packages"]["find"]
    folders = {path.parent for folder in ("fe_models", "hybrid") for path in (ROOT / folder).rglob("*.py")}
    names = {".".join(folder.relative_to(ROOT).parts) for folder in folders}
    assert all(any(fnmatch(name, pattern) for pattern in found["include"]) for name in names)
    assert all((folder / "__init__.py").is_file() for folder in folders)
