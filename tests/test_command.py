"""The command `hybrid-modal`: its sub-commands, how fast its help is, what is said of what is not installed."""

import subprocess
import sys
from importlib.metadata import EntryPoint, EntryPoints, version
from pathlib import Path

import pytest
from typer.testing import CliRunner

from hybrid.commands import benchmark
from hybrid.commands.app import COMMANDS, app, main_app
from tests.test_layout import imports_of

ROOT = Path(__file__).parents[1]
NAMES = [*(command.__name__ for command in COMMANDS), "benchmark"]
HEAVY = {"torch", "scipy", "matplotlib", "numba", "exudyn", "pyvista", "vtkmodules"}


def test_it_has_the_sub_commands_that_the_documents_name() -> None:
    known = {"build", "simulate", "train", "predict", "render", "diagnose", "watch", "compare", "inspect", "benchmark"}
    assert set(NAMES) == known
    result = CliRunner().invoke(app, ["--help"])
    assert result.exit_code == 0
    listed = [line.split()[0] for line in result.output.split("Commands:")[1].splitlines() if line.strip()]
    assert listed == NAMES


@pytest.mark.slow
@pytest.mark.parametrize("arguments", [[], *([name] for name in NAMES)], ids=lambda names: " ".join(names) or "itself")
def test_help_loads_nothing_heavy(arguments: list[str]) -> None:
    script = (
        "import sys\n"
        "from benchmarks.command import benchmark\n"
        "from hybrid.commands.app import app\n"
        "try:\n"
        f"    app({[*arguments, '--help']})\n"
        "finally:\n"
        f"    print('heavy:', *sorted({HEAVY} & set(sys.modules)))\n"
    )
    done = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == "heavy:"
    assert "Usage:" in done.stdout


def test_no_other_part_of_the_package_imports_the_commands() -> None:
    files = [path for path in (ROOT / "hybrid").rglob("*.py") if path.parent.name != "commands"]
    assert len(files) > 10
    for path in files:
        assert not any(module.startswith("hybrid.commands") for module, _ in imports_of(path)), path


def test_without_the_benchmarks_one_line_tells_how_to_get_them(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(benchmark, "entry_points", lambda **_: EntryPoints())
    result = CliRunner().invoke(main_app(), ["benchmark"])
    assert result.exit_code == 2
    assert result.stderr.splitlines() == [f"error: {benchmark.REMEDY}"]
    assert "pip install ./benchmarks" in benchmark.REMEDY


def test_the_benchmarks_plug_in_by_their_entry_point(monkeypatch: pytest.MonkeyPatch) -> None:
    """The one that their pyproject.toml declares."""
    declared = 'benchmark = "benchmarks.command:benchmark"'
    assert declared in (ROOT / "benchmarks" / "pyproject.toml").read_text()
    entry = EntryPoint("benchmark", "benchmarks.command:benchmark", benchmark.GROUP)
    monkeypatch.setattr(benchmark, "entry_points", lambda **_: EntryPoints([entry]))
    result = CliRunner().invoke(main_app(), ["benchmark", "--help"])
    assert result.exit_code == 0
    assert "--blind" in result.output


def test_quiet_leaves_the_path_of_the_result_alone(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["build", "four_dof", "--out", str(tmp_path), "--no-pictures", "--quiet"])
    assert result.exit_code == 0, result.output
    assert result.stdout.splitlines() == [str(tmp_path / "model.npz")]
    assert result.stderr == ""


def test_quiet_does_not_hide_faults(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["build", "nowhere", "--out", str(tmp_path), "--quiet"])
    assert result.exit_code == 2
    assert result.stdout == ""
    assert result.stderr.startswith("error: model 'nowhere' is unknown")


def test_the_installed_command_simulates_what_it_then_builds_on(tmp_path: Path) -> None:
    """As a shell starts it: recordings, their step and its error on stdout; a coarser step warns."""
    start = "from hybrid.commands.app import app; app(prog_name='hybrid-modal')"
    options = ["simulate", "bridge", "--out", str(tmp_path), "--pull", "19:y:-9.81", "--duration", "0.05"]
    run = [sys.executable, "-W", "error", "-c", start, *options]
    done = subprocess.run(run, cwd=ROOT, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    assert "Time step 0.000" in done.stdout
    assert "0.01 % too low" in done.stdout
    assert (tmp_path / "dataset.toml").is_file()
    coarse = CliRunner().invoke(app, [*options, "--step", "0.002", "-q"])
    assert coarse.exit_code == 0
    assert coarse.stdout.splitlines() == [str(tmp_path / "dataset.toml")]
    assert "warning: time step 0.002 s" in coarse.stderr
    assert "leave --step out" in coarse.stderr


def test_the_command_says_its_version() -> None:
    result = CliRunner().invoke(main_app(), ["--version"])
    assert result.exit_code == 0
    assert result.output == f"hybrid-modal {version('hybrid-modal')}\n"
