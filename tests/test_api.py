"""What a notebook imports: names that exist, load late and print well."""

import ast
import importlib
import inspect
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import fe_models as fe
import hybrid
from fe_models.files.dataset_file import save_dataset
from fe_models.html import html_paragraph, html_table
from fe_models.lazy_exports import lazy_exports
from fe_models.simulation import FreeConfig, simulate_free
from hybrid.notebook.data import dataset_of

ROOT = Path(__file__).parents[1]
HEAVY = {"torch", "matplotlib", "numba", "vtk", "vtkmodules", "pyvista", "exudyn"}
SLOW_SCIPY = {"scipy.optimize", "scipy.signal", "scipy.stats"}
SENSORS = (fe.Sensor("x4", 4, "x", "displacement", "m"), fe.Sensor("a1", 1, "x", "acceleration", "m/s^2", "held_out"))


def motions(*counts: int) -> fe.Dataset:
    """Return recordings of so many motions each, no two samples alike."""
    data = np.arange(sum(counts) * 40 * 2, dtype=float).reshape(-1, 40, 2)
    ends = np.cumsum(counts)[:-1]
    recordings = tuple(fe.Recording(f"r{i}", part) for i, part in enumerate(np.split(data, ends), start=1))
    return fe.Dataset(fe.four_dof(), 10.0, SENSORS, recordings)


@pytest.mark.parametrize("package", [fe, hybrid])
def test_all_exported_names_exist_and_say_what_they_are(package: object) -> None:
    names = package.__all__  # type: ignore[attr-defined]
    assert len(names) == len(set(names)) > 1
    for name in names:
        found = getattr(package, name)
        assert inspect.getdoc(found), name
        assert getattr(found, "__name__", "") == name
    assert set(names) <= set(dir(package))


@pytest.mark.parametrize("package", ["fe_models", "hybrid"])
def test_types_and_run_time_find_the_same_names_in_the_same_modules(package: str) -> None:
    tree = ast.parse((ROOT / package / "__init__.py").read_text())
    block, _ = (node for node in tree.body if isinstance(node, ast.If))
    typed = {
        (node.module, alias.name, alias.asname)
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
    homes = importlib.import_module(package)._HOMES
    assert typed == {(module, name, name) for module, names in homes.items() for name in names}


@pytest.mark.parametrize("package", ["fe_models", "hybrid"])
def test_no_module_has_the_name_of_an_export(package: str) -> None:
    """Importing it would put it in the export's place."""
    home = ROOT / package
    modules = {path.stem for path in home.glob("*.py")} | {path.parent.name for path in home.glob("*/__init__.py")}
    assert not modules & set(importlib.import_module(package).__all__)


def test_unknown_names_are_refused_as_of_any_module() -> None:
    with pytest.raises(AttributeError, match="module 'hybrid' has no attribute 'diagnos'"):
        _ = hybrid.diagnos  # type: ignore[attr-defined]
    get, names = lazy_exports("fe_models", {"fe_models.structure": ("Beam",)})
    assert get("Beam") is fe.Beam
    assert "Beam" in names()


def test_a_mistake_in_a_dataset_is_reported_before_anything_heavy_is_loaded(tmp_path: Path) -> None:
    (tmp_path / "dataset.toml").write_text('schema = 1\nmodl = "four_dof"\nsampling_rate = 10.0\n')
    script = (
        "import sys, fe_models, hybrid\n"
        "assert 'numpy' not in sys.modules, 'importing the packages loads NumPy'\n"
        "try:\n"
        f"    hybrid.diagnose({str(tmp_path / 'dataset.toml')!r})\n"
        "except fe_models.InputError as error:\n"
        "    assert \"did you mean 'model'\" in str(error), error\n"
        f"    sys.exit(str({HEAVY | SLOW_SCIPY!r} & set(sys.modules) or ''))\n"
        "sys.exit('no fault found')\n"
    )
    done = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr.strip()) == (1, ""), done.stderr


def test_reports_and_comparisons_load_neither_torch_nor_matplotlib() -> None:
    modules = ("diagnosis.diagnosis", "diagnosis.report", "diagnosis.learned.gain", "notebook.report")
    lines = [f"import hybrid.{module}" for module in modules]
    lines += ["import sys", "sys.exit(str({'torch', 'matplotlib'} & set(sys.modules) or 0))"]
    done = subprocess.run([sys.executable, "-c", "\n".join(lines)], cwd=ROOT, capture_output=True, check=False)
    assert done.stderr.decode().strip() == "0"


def test_models_and_data_print_what_they_are() -> None:
    chain = fe.four_dof(0.5)
    assert repr(chain) == "Structure('four_dof': 4 nodes, 4 springs, 1 effect)"
    assert repr(fe.linearise(chain)) == "LinearModel(4 free degrees of freedom, 4 nodes)"
    assert repr(motions(2, 1).split(0.5)) == (
        "Dataset(Structure('four_dof': 4 nodes, 4 springs): 2 motions for training, 1 for testing, each 4 s at 10 Hz;"
        " sensors x4, a1 (held out))"
    )
    assert repr(motions(2).recordings[0]) == "Recording('r1': 2 motions of 40 samples and 2 channels, train)"
    assert repr(fe.Load(2, "x", np.zeros(50))) == "Load(node 2 in x, 50 samples)"
    modes = fe.natural_modes(chain)
    assert repr(modes).splitlines()[1].split() == ["1", "0.03924", "Hz", "6.95", "%"]
    assert modes._repr_html_().count("<tr>") == 5


def test_names_from_files_are_escaped() -> None:
    assert html_table(["<b>"], [["<script>", 1]]) == (
        "<table><thead><tr><th>&lt;b&gt;</th></tr></thead><tbody><tr><td>&lt;script&gt;</td><td>1</td></tr></tbody></table>"
    )
    assert html_paragraph("a & b\nc") == "<p>a &amp; b<br>c</p>"


@pytest.mark.parametrize(
    ("share", "train", "test"),
    [
        (0.6, {"r1": 2, "r2": 1}, {"r2_test": 2}),
        (0.4, {"r1": 2}, {"r2": 3}),
        (0.01, {"r1": 1}, {"r1_test": 1, "r2": 3}),
        (0.99, {"r1": 2, "r2": 2}, {"r2_test": 1}),
    ],
)
def test_a_dataset_is_split_by_motions(share: float, train: dict[str, int], test: dict[str, int]) -> None:
    whole = motions(2, 3)
    parts = whole.split(share)
    assert {recording.name: len(recording.data) for recording in parts.select("train")} == train
    assert {recording.name: len(recording.data) for recording in parts.select("test")} == test
    found, expected = (np.concatenate([recording.data for recording in each.recordings]) for each in (parts, whole))
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize(("counts", "share"), [((1,), 0.5), ((2, 2), 1.0), ((2, 2), 0.0)])
def test_what_cannot_be_split_is_refused(counts: tuple[int, ...], share: float) -> None:
    with pytest.raises(fe.InputError, match="cannot be split"):
        motions(*counts).split(share)


def test_recordings_are_simulated_alike_from_the_same_seed_and_by_the_names_of_sensors() -> None:
    wanted = {"sensors": ["x4", "a1"], "held_out": ["v2"], "motions": 2, "duration": 5.0}
    one, again, other = (fe.simulate(fe.four_dof(0.5), **wanted, seed=seed) for seed in (1, 1, 2))  # type: ignore[arg-type]
    np.testing.assert_array_equal(one.recordings[1].data, again.recordings[1].data)
    assert not np.allclose(one.recordings[1].data, other.recordings[1].data)
    assert [(s.name, s.node, s.quantity, s.unit, s.role) for s in one.sensors] == [
        ("x4", 4, "displacement", "m", "measured"),
        ("a1", 1, "acceleration", "m/s^2", "measured"),
        ("v2", 2, "velocity", "m/s", "held_out"),
    ]
    assert [recording.name for recording in one.recordings] == ["motion_1", "motion_2"]


def test_a_chain_s_steps_follow_from_its_highest_mode() -> None:
    """A step four times finer changes a chain of 3.5 to 30 Hz by less than 1e-5; what would fold down is refused."""
    springs = (element for element in fe.four_dof().elements if isinstance(element, fe.Spring))
    stiff = replace(fe.four_dof(), elements=tuple(replace(each, stiffness=8000 * each.stiffness) for each in springs))
    with pytest.raises(fe.InputError, match=r"up to 30\.44 Hz.*sample at 76\.1 Hz or more"):
        fe.simulate(stiff, ["a1"], motions=1)
    wanted = {"motions": 1, "duration": 3.0, "sampling_rate": 100.0, "noise": 0.0}
    found = fe.simulate(stiff, ["x1", "a4"], **wanted).recordings[0].data[0]  # type: ignore[arg-type]
    start = np.random.default_rng(0).standard_normal((2, 1, 4))
    finer = simulate_free(stiff, start[0], start[1], FreeConfig(3.0, 100.0, 2e-4), progress=False)
    exact = np.stack([finer.displacement[0, :, 0], finer.acceleration[0, :, 3]], axis=-1)
    assert np.abs(found - exact).max(axis=0) / exact.std(axis=0) == pytest.approx([0.0, 0.0], abs=1e-5)


def test_noise_is_a_share_of_each_channel_or_in_the_sensors_units() -> None:
    wanted = {"motions": 1, "duration": 20.0}
    clean, share, absolute = (
        fe.simulate(fe.four_dof(), ["x4", "a1"], noise=noise, **wanted).recordings[0].data[0]  # type: ignore[arg-type]
        for noise in (0.0, 0.05, {"m": 0.01, "m/s^2": 0.2})
    )
    np.testing.assert_allclose((share - clean).std(axis=0), 0.05 * clean.std(axis=0), rtol=1e-12)
    np.testing.assert_allclose((absolute - clean).std(axis=0), [0.01, 0.2], rtol=1e-12)
    with pytest.raises(fe.InputError, match=r"noise of the sensors in m/s\^2 \(a1\) is missing"):
        fe.simulate(fe.four_dof(), ["x4", "a1"], noise={"m": 0.01}, **wanted)  # type: ignore[arg-type]


def test_all_faults_of_a_simulation_are_reported_at_once() -> None:
    with pytest.raises(fe.InputError) as caught:
        fe.simulate(fe.four_dof(), sensors=["q4", "a1y"], held_out=["z"])
    assert [fault.split(":")[0] for fault in caught.value.faults] == ["sensor 'q4'", "sensor 'a1y'", "sensor 'z'"]
    with pytest.raises(fe.InputError, match="node 9 does not exist"):
        fe.simulate(fe.four_dof(), sensors=["a9"])
    with pytest.raises(fe.InputError, match="a direction"):
        fe.simulate(fe.bridge(), sensors=["a5"], pulls=[fe.PointLoad(5, "y", -1.0)])
    with pytest.raises(fe.InputError, match="give pulls"):
        fe.simulate(fe.bridge(), sensors=["a5y"])


def test_a_design_takes_the_place_of_the_datasets_model(tmp_path: Path) -> None:
    data = motions(2)
    design = replace(fe.four_dof(), name="mine")
    assert dataset_of(design, data).model is design
    assert dataset_of(data, None).model is data.model
    rng = np.random.default_rng(0)
    noisy = replace(data, recordings=(fe.Recording("r", rng.standard_normal((1, 40, 2))),))
    path = save_dataset(noisy, tmp_path)
    assert dataset_of("four_dof", str(path)).model == fe.four_dof()
    shorter = replace(design, nodes=design.nodes[:3], elements=design.elements[:3], point_masses=(), dashpots=())
    with pytest.raises(fe.InputError, match="sensor 'x4': node 4 does not exist"):
        dataset_of(shorter, data)
    with pytest.raises(fe.InputError, match="give the dataset"):
        dataset_of(design, None)
    with pytest.raises(fe.InputError, match="two datasets"):
        dataset_of(data, data)


@pytest.mark.parametrize(
    ("effect", "fault"),
    [
        ("x", "effect 1 is 'x'; expected one such as AddedMass(node=1, mass=2.0)"),
        (fe.AddedMass(node=1, mass="a"), "AddedMass: mass = 'a'; expected a number"),  # type: ignore[arg-type]
        (fe.AddedMass(node="one", mass=1.0), "AddedMass: node = 'one'; expected an integer"),  # type: ignore[arg-type]
        (
            fe.CubicSpring(node=1, direction="q", stiffness=1.0),  # type: ignore[arg-type, call-arg]
            "CubicSpring: direction = 'q'; expected one of x, y, z, rx, ry, rz",
        ),
    ],
)
def test_what_is_no_effect_is_refused_at_once(effect: Any, fault: str) -> None:
    with pytest.raises(fe.InputError) as caught:
        fe.four_dof().with_effects(effect)
    assert caught.value.faults == (fault,)


def test_modes_of_what_is_no_model_are_refused() -> None:
    with pytest.raises(fe.InputError, match="'four_dof' is no model: give a structure or matrices"):
        fe.natural_modes("four_dof")  # type: ignore[arg-type]
