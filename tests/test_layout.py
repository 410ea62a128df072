"""Imports run one way, fe_models <- hybrid <- benchmarks <- scripts; heavy libraries are loaded by one home each."""

import ast
import re
import subprocess
import sys
import tomllib
from collections.abc import Callable
from fnmatch import fnmatch
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

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


@cache
def imports_of(path: Path) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """What a file imports anywhere, also inside functions: modules, and the names that it takes from each."""
    found = list[tuple[str, tuple[str, ...]]]()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found += [(alias.name, ()) for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            found.append((node.module, tuple(alias.name for alias in node.names)))
    return tuple(found)


def imported(path: Path) -> set[str]:
    """Top-level packages that a file imports anywhere."""
    return {module.split(".")[0] for module, _ in imports_of(path)}


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
    documented = ast.get_docstring(ast.parse((home / "__init__.py").read_text())) or ""
    order = [word for word in re.findall(r"`(\w+)`", documented) if (home / word).is_dir()]
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


@pytest.mark.slow
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


def module_graph() -> dict[str, set[str]]:
    """Return what each module imports of the two packages, for types and inside functions included."""
    paths = {
        ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path
        for package in ("fe_models", "hybrid")
        for path in (ROOT / package).rglob("*.py")
    }
    graph = dict[str, set[str]]()
    for name, path in paths.items():
        imports = set()
        for module, names in imports_of(path):
            imports |= ({f"{module}.{inner}" for inner in names} & paths.keys()) or {module}
        graph[name] = (imports & paths.keys()) - {name}
    for package in ("fe_models", "hybrid"):  # their exports are for users alone
        graph[package] = set()
    return graph


def cycles(graph: dict[str, set[str]]) -> list[list[str]]:
    """Return the groups of names that lead to one another."""
    names = sorted({*graph, *(name for found in graph.values() for name in found)})
    rows, columns = zip(*((names.index(a), names.index(b)) for a, found in graph.items() for b in found), strict=True)
    links = csr_array((np.ones(len(rows)), (rows, columns)), shape=(len(names), len(names)))
    count, group = connected_components(links, directed=True, connection="strong")
    groups = [[names[i] for i in np.flatnonzero(group == number)] for number in range(count)]
    return [members for members in groups if len(members) > 1]


def merged(graph: dict[str, set[str]], room: Callable[[str], str]) -> dict[str, set[str]]:
    """Return which rooms import from which, where ``room`` says in which a module is."""
    found = dict[str, set[str]]()
    for name, imports in graph.items():
        found.setdefault(room(name), set()).update(room(other) for other in imports if room(other) != room(name))
    return found


def test_cycles_are_found() -> None:
    assert cycles({"a": {"b"}, "b": {"c"}, "c": {"a"}, "d": {"a"}}) == [["a", "b", "c"]]
    assert cycles({"a": {"b", "c"}, "b": {"c"}}) == []


def test_no_modules_import_one_another_not_even_for_types() -> None:
    graph = module_graph()
    assert "hybrid.estimation.most_probable_state" not in graph["hybrid.neural_modal_ode.model"]
    assert "fe_models.assembly" in graph["fe_models.modes"]
    assert cycles(graph) == []


def test_packages_import_one_way() -> None:
    """A package within the two may stand above or below another one, and above or below single modules, not both."""
    assert cycles(merged(module_graph(), lambda name: ".".join(name.split(".")[:2]))) == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("package", "never"),
    [
        ("identification", {"training", "estimation", "diagnosis", "neural_modal_ode", "notebook", "commands"}),
        ("neural_modal_ode", {"estimation", "training", "identification", "diagnosis", "notebook", "commands"}),
        ("estimation", {"training", "identification", "diagnosis", "notebook", "commands"}),
        ("training", {"diagnosis", "notebook", "commands"}),
        ("diagnosis", {"notebook", "commands"}),
        ("notebook", {"commands"}),
    ],
)
def test_each_package_of_the_hybrid_stands_on_those_below_it_alone(package: str, never: set[str]) -> None:
    links = merged(module_graph(), lambda name: ".".join(name.split(".")[:2]))[f"hybrid.{package}"]
    assert not links & {f"hybrid.{name}" for name in never}


@pytest.mark.slow
@pytest.mark.parametrize("package", ["identification", "diagnosis"])
def test_what_identifies_and_diagnoses_loads_neither_torch_nor_matplotlib_but_to_learn(package: str) -> None:
    """Module by module; the one that trains hybrid models is loaded when it is asked to."""
    home = ROOT / "hybrid" / package
    modules = [
        ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
        for path in sorted(home.rglob("*.py"))
        if path.stem != "learning"
    ]
    script = (
        "import importlib, sys\n"
        f"for name in {modules}:\n"
        "    importlib.import_module(name)\n"
        "    heavy = {'torch', 'matplotlib'} & set(sys.modules)\n"
        "    if heavy:\n"
        "        sys.exit(f'{name} loads {heavy}')\n"
    )
    done = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_every_package_is_installed() -> None:
    """An editable installation finds them all, another one only folders that have an __init__.py."""
    found = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["packages"]["find"]
    folders = {path.parent for folder in ("fe_models", "hybrid") for path in (ROOT / folder).rglob("*.py")}
    names = {".".join(folder.relative_to(ROOT).parts) for folder in folders}
    assert all(any(fnmatch(name, pattern) for pattern in found["include"]) for name in names)
    assert all((folder / "__init__.py").is_file() for folder in folders)
