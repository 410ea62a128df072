"""Imports run one way, fe_models <- hybrid <- scripts, and heavy libraries are loaded by one home each."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
HOMES = {  # library: the only files that may import it
    "exudyn": {"fe_models/exudyn_io.py", "fe_models/exudyn_items.py", "fe_models/exudyn_solve.py"},
    "pyvista": {"fe_models/pictures/render.py"},
}


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
    ("package", "banned"), [("fe_models", {"torch", "hybrid", "scripts"}), ("hybrid", {"scripts"})]
)
def test_imports_run_one_way(package: str, banned: set[str]) -> None:
    files = list((ROOT / package).rglob("*.py"))
    assert len(files) > 10
    assert [path.name for path in files if imported(path) & banned] == []


@pytest.mark.parametrize("library", HOMES)
def test_heavy_libraries_have_one_home(library: str) -> None:
    files = [path for folder in ("fe_models", "hybrid", "scripts") for path in (ROOT / folder).rglob("*.py")]
    users = {path.relative_to(ROOT).as_posix() for path in files if library in imported(path)}
    assert users
    assert users <= HOMES[library]


def test_the_learning_part_loads_neither_exudyn_nor_pyvista() -> None:
    modules = [path.relative_to(ROOT).with_suffix("") for path in (ROOT / "hybrid").glob("*.py")]
    lines = "\n".join(f"import {'.'.join(module.parts)}" for module in modules if module.name != "__init__")
    script = f"import sys\n{lines}\nsys.exit(bool({{'exudyn', 'pyvista'}} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", script], cwd=ROOT, check=False).returncode == 0
