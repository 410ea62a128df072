"""Every file that is read: whatever is in it, the answer is what it holds or what is wrong with it, soon and in words.

The inputs come from a generator; `make test` tries a few hundred of them, `make test-all` thousands.
"""

import resource
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import tomli_w
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.io import savemat

from fe_models.assembly import linearise
from fe_models.built_in.four_dof import four_dof
from fe_models.dofs import structure_dofs
from fe_models.errors import InputError
from fe_models.files.dataset_file import load_dataset
from fe_models.files.modal_file import load_modal_model
from fe_models.files.models import load_model
from fe_models.files.recording_files import load_recording
from fe_models.files.structure_file import structure_table
from fe_models.linear import LinearModel
from fe_models.modes import natural_modes
from hybrid.inspection.inspection import inspect_file
from hybrid.inspection.inspection_report import describe
from tests.hybrid_problems import MASS, STIFFNESS, chain_modes, decay
from tests.odd_inputs import answered, changed, damaged, odd_values
from tests.sample_dataset import NAMES, RATE, free_decay
from tests.test_recording_formats import write_tdms, write_uff

PORTAL: dict[str, Any] = {
    "schema": 1,
    "name": "portal",
    "nodes": [[0.0, 0.0], [0.0, 3.0], [4.0, 3.0], [4.0, 0.0]],
    "divisions": 2,
    "damping": {"modal_ratios": [0.01, 0.02], "mass_factor": 0.1},
    "sections": [
        {
            "name": "tube",
            "youngs_modulus": 2.1e11,
            "density": 7850.0,
            "shape": "square_tube",
            "side": 0.1,
            "wall": 0.004,
        },
        {"name": "wire", "youngs_modulus": 2.1e11, "density": 7850.0, "area": 1e-5},
    ],
    "elements": [
        {"kind": "beam", "through": [1, 2, 3, 4], "section": "tube", "group": "frame"},
        {"kind": "cable", "nodes": [1, 3], "section": "wire", "prestress": 10.0},
        {"kind": "spring", "node": 2, "direction": "x", "stiffness": 1e4},
    ],
    "supports": [{"node": 1, "directions": ["x", "y", "rz"]}, {"node": 4, "directions": ["x", "y"]}],
    "point_masses": [{"node": 2, "mass": 3.0}],
    "dashpots": [{"nodes": [1, 2], "direction": "y", "coefficient": 4.0}],
    "effects": [
        {"kind": "cubic_spring", "node": 2, "direction": "x", "stiffness": 2.0},
        {"kind": "stiffness_change", "element": 1, "factor": 0.8},
        {"kind": "gap_stop", "node": 3, "direction": "y", "gap": 0.1, "stiffness": 5.0, "side": 1},
        {"kind": "modal_damping", "modes": [1], "ratio": 0.03},
        {"kind": "axial_force", "elements": [1, 2], "force": [-1.0, 2.0]},
        {"kind": "slack_cable", "element": 4, "pretension": 5.0},
        {"kind": "support_spring", "node": 4, "direction": "rz", "stiffness": 10.0},
        {"kind": "coulomb_friction", "nodes": [2, 3], "direction": "x", "force": 0.5},
        {"kind": "harmonic_force", "node": 2, "direction": "y", "amplitude": 1.0, "frequency": 2.0},
        {"kind": "mass_change", "element": 2, "factor": 1.1},
    ],
}
DATASET: dict[str, Any] = {
    "schema": 1,
    "model": "four_dof",
    "sampling_rate": 2.0,
    "lowpass": 0.9,
    "sensors": [
        {"name": "x4", "node": 4, "direction": "x", "quantity": "displacement", "unit": "m"},
        {"name": "a1", "node": 1, "direction": "x", "quantity": "acceleration", "unit": "m/s^2", "role": "held_out"},
    ],
    "recordings": [
        {"name": "r1", "file": "r1.npz", "key": "data", "role": "train"},
        {"name": "r2", "file": "r2.csv", "role": "test", "sampling_rate": 2.0, "excitation": "free"},
        {"name": "r3", "file": "r1.npz", "key": "loud", "loads": [
            {"node": 2, "direction": "x", "file": "r1.npz", "key": "force"}]},
    ],
    "simulation": {"damping_ratio": [0.01, 0.02], "modes": 2, "uncertainty": {"stiffness": 0.1}},
    "modes": [{"recording": "r1", "frequency": 0.04, "damping_ratio": 0.07, "shape": [1.0, 0.2]}],
}  # fmt: skip
MOST_MEMORY = 2 * 2**20  # KiB beyond what is taken already


def generated(examples: int) -> Callable[[Any], Any]:
    """The same inputs at every run, so many of them."""
    return settings(
        max_examples=examples,
        derandomize=True,
        deadline=None,
        database=None,
        suppress_health_check=list(HealthCheck),
    )


EFFORTS = [pytest.param(60, id="some"), pytest.param(1000, id="many", marks=pytest.mark.slow)]


@pytest.fixture(autouse=True)
def memory() -> Any:
    """No input takes more than 2 GB."""
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    yield
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < MOST_MEMORY


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Recordings that `DATASET` names."""
    folder = tmp_path_factory.mktemp("odd")
    modal = chain_modes()
    rng = np.random.default_rng(0)
    motion = decay(modal, rng.standard_normal((3, 4)), rng.standard_normal((3, 4)), 0.5, 100)
    seen = np.stack([motion.q @ modal.shapes[3], motion.q_ddot @ modal.shapes[0]], axis=-1)
    np.savez(folder / "r1.npz", data=seen[0], loud=30 * seen[1], force=rng.standard_normal(100), dt=0.5)
    table = np.column_stack([0.5 * np.arange(100), seen[2]])
    np.savetxt(folder / "r2.csv", table, delimiter=",", header="time (s),x4,a1", comments="")
    np.save(folder / "r3.npy", seen[0])
    savemat(folder / "r4.mat", {"data": seen[0], "dt": 0.5}, do_compression=True)
    with h5py.File(folder / "r5.mat", "w") as file:
        file["data"] = seen[0].T
    write_uff(folder / "r6.uff", free_decay(1))
    write_uff(folder / "r7.unv", free_decay(1), binary=1)
    write_tdms(folder / "r8.tdms", free_decay(1))
    matrices = {"M": MASS, "K": STIFFNESS, "C": 0.1 * MASS, "nodes": np.zeros((4, 2)), "modal_ratios": np.array([0.01])}
    places = {"dof_node": np.arange(1, 5), "dof_direction": np.array(["x"] * 4), "groups": np.array(["all"])}
    np.savez(folder / "matrices.npz", **matrices, **places, K_1=0.5 * STIFFNESS)  # type: ignore[arg-type]
    np.savez(folder / "modal.npz", omega=modal.omega, xi=modal.damping_ratio, phi=modal.shapes)
    return folder


def as_toml(document: Any) -> str:
    """A document as the text of a file, as far as it can be one."""
    try:
        return tomli_w.dumps(document)
    except (TypeError, AttributeError, ValueError):
        return repr(document)


def tried(examples: int, strategy: st.SearchStrategy[Any], read: Callable[[Any], object]) -> int:
    """How many of the generated inputs could be used."""
    used = list[bool]()

    @generated(examples)
    @given(strategy)
    def try_each(odd: Any) -> None:
        used.append(answered(lambda: read(odd)))

    try_each()
    assert len(used) >= examples
    return sum(used)


def computed(path: Path) -> None:
    model = load_model(str(path))
    natural_modes(model if isinstance(model, LinearModel) else linearise(model), 1)


def is_answered(document: dict[str, Any], path: Path, read: Callable[[Path], object], examples: int) -> None:
    """Check that a document is read, and that every odd one made of it ends in an answer."""

    def read_odd(odd: Any) -> None:
        path.write_text(as_toml(odd), encoding="utf-8", errors="replace")
        read(path)

    read_odd(document)
    assert tried(examples, changed(document, odd_values()), read_odd) < examples


@pytest.mark.parametrize("examples", EFFORTS)
@pytest.mark.parametrize("structure", [PORTAL, structure_table(four_dof())], ids=["frame", "chain"])
def test_structures(structure: dict[str, Any], examples: int, tmp_path: Path) -> None:
    is_answered(structure, tmp_path / "odd.toml", computed, examples)


@pytest.mark.parametrize("examples", EFFORTS)
def test_datasets(examples: int, folder: Path) -> None:
    is_answered(DATASET, folder / "dataset.toml", load_dataset, examples)


@pytest.mark.parametrize("examples", EFFORTS)
@pytest.mark.parametrize("name", ["r1.npz", "r2.csv", "r3.npy", "r4.mat", "r5.mat", "r6.uff", "r7.unv", "r8.tdms"])
def test_recordings(name: str, examples: int, folder: Path, tmp_path: Path) -> None:
    whole = (folder / name).read_bytes()
    path = tmp_path / name

    named = name in ("r6.uff", "r7.unv", "r8.tdms")
    sensors, rate = (NAMES, RATE) if named else (["x4", "a1"], 2.0)

    def read(content: bytes) -> None:
        path.write_bytes(content)
        load_recording(path, "data" if name.endswith((".npz", ".mat")) else None, sensors, rate)

    read(whole)
    tried(examples // 2, damaged(whole), read)


@pytest.mark.parametrize("examples", EFFORTS)
@pytest.mark.parametrize("name", ["r1.npz", "r2.csv", "r8.tdms"])
def test_inspected_files(name: str, examples: int, folder: Path, tmp_path: Path) -> None:
    whole, path = (folder / name).read_bytes(), tmp_path / name

    def read(content: bytes) -> None:
        path.write_bytes(content)
        describe(inspect_file(path, "data" if name == "r1.npz" else None, 2.0 if name == "r1.npz" else None))

    read(whole)
    tried(examples // 3, damaged(whole), read)


def as_array(value: Any) -> Any:
    """A value as an array, in words where it is none."""
    try:
        return np.asarray(value)
    except ValueError:
        return np.array(str(value))


ODD_ARRAYS: list[Any] = [
    np.zeros(0), np.zeros((4, 4)), -np.eye(4), np.eye(3), np.full((4, 4), np.nan), 1e300 * np.eye(4),
    1e-300 * np.eye(4), np.array(["x", "\x1b[2J"]), np.array(5.0), np.array([1.5, 2.0]), np.array([10**12]),
    np.eye(4, dtype=complex), np.arange(5),
]  # fmt: skip


@pytest.mark.parametrize("examples", EFFORTS)
def test_matrices(examples: int, folder: Path, tmp_path: Path) -> None:
    with np.load(folder / "matrices.npz") as file:
        whole = dict(file)

    def read(arrays: dict[str, Any]) -> None:
        plain = {str(name)[:40] or "none": as_array(array) for name, array in arrays.items()}
        named = {f"{name}_" if name == "file" else name.replace("/", "_"): plain[name] for name in plain}
        np.savez(tmp_path / "odd.npz", **named)
        computed(tmp_path / "odd.npz")

    read(whole)
    assert tried(examples, changed(whole, odd_values(ODD_ARRAYS)), read) < examples


@pytest.mark.parametrize("examples", EFFORTS)
@pytest.mark.parametrize("name", ["matrices.npz", "modal.npz"])
def test_damaged_models(name: str, examples: int, folder: Path, tmp_path: Path) -> None:
    whole, path = (folder / name).read_bytes(), tmp_path / name

    def read(content: bytes) -> None:
        path.write_bytes(content)
        if name == "modal.npz":
            load_modal_model(path, structure_dofs(four_dof()))
        else:
            computed(path)

    read(whole)
    tried(examples // 2, damaged(whole), read)


def test_marks_of_byte_order_and_capital_endings_are_valid(folder: Path, tmp_path: Path) -> None:
    """Windows' editors write the one, cameras and loggers the other."""
    (tmp_path / "PORTAL.TOML").write_bytes(b"\xef\xbb\xbf" + as_toml(PORTAL).encode())
    computed(tmp_path / "PORTAL.TOML")
    for name, key in (("r1.npz", "data"), ("r2.csv", None), ("r4.mat", "data")):
        (tmp_path / name.upper()).write_bytes((folder / name).read_bytes())
        assert load_recording(tmp_path / name.upper(), key, ["x4", "a1"], 2.0).data.shape == (1, 100, 2)


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        (lambda data: 1e30 * data, "expected 1e-15 to 1e+15 in SI units"),
        (lambda data: 1e-30 * data, "expected 1e-15 to 1e+15 in SI units"),
        (lambda data: np.where(np.arange(100)[:, None] == 16, 1e300, data), "its largest value is 1e+300 (number 17)"),
        (lambda data: 1e12 * data, ""),
        (lambda data: 1e-12 * data, ""),
        (lambda data: np.where(np.arange(100)[:, None] < 34, 0.0, data), ""),
    ],
)
def test_sizes_of_recordings(change: Callable[[Any], Any], fault: str, folder: Path, tmp_path: Path) -> None:
    """Within limits every size is taken, silence before a motion, too; beyond them it is a wrong unit, or a sample."""
    with np.load(folder / "r1.npz") as file:
        np.savez(tmp_path / "r1.npz", data=change(file["data"]))
    plain = {key: DATASET[key] for key in ("schema", "model", "sampling_rate", "sensors")}
    (tmp_path / "dataset.toml").write_text(as_toml(plain | {"recordings": DATASET["recordings"][:1]}))
    if not fault:
        assert load_dataset(tmp_path / "dataset.toml").recordings[0].data.shape == (1, 100, 2)
        return
    with pytest.raises(InputError) as caught:
        load_dataset(tmp_path / "dataset.toml")
    assert len(caught.value.faults) in (1, 2)  # one a channel that is too large, one for all that are too small
    assert all(fault in each for each in caught.value.faults)


@pytest.mark.parametrize("rate", [1e-9, 1e308, 0.0, -1.0])
def test_rates_that_nobody_samples_at(rate: float, folder: Path) -> None:
    (folder / "rate.toml").write_text(as_toml({**DATASET, "sampling_rate": rate}))
    with pytest.raises(InputError, match=r"sampling_rate.*(expected 1e-06 to 1e\+09 Hz|must be positive|at most)"):
        load_dataset(folder / "rate.toml")


def test_files_of_an_old_python_are_read(tmp_path: Path) -> None:
    """Their headers have long integers."""
    np.save(tmp_path / "old.npy", np.arange(200.0).reshape(100, 2))
    content = (tmp_path / "old.npy").read_bytes().replace(b"(100, 2), } ", b"(100L, 2), }")
    (tmp_path / "old.npy").write_bytes(content)
    assert load_recording(tmp_path / "old.npy", None, ["x4", "a1"], 2.0).data[0, 99, 1] == 199


def test_a_dataset_without_a_readable_sensor_says_so(folder: Path) -> None:
    (folder / "none.toml").write_text(as_toml({**DATASET, "sensors": 0}))
    with pytest.raises(InputError, match="sensors: expected a list, found 0"):
        load_dataset(folder / "none.toml")


def test_packed_and_locked_members_are_named(folder: Path, tmp_path: Path) -> None:
    """The flag of encryption is set in an archive that has no password: it cannot be read either way."""
    content = bytearray((folder / "r1.npz").read_bytes())
    for mark, place in ((b"PK\x03\x04", 6), (b"PK\x01\x02", 8)):
        for start in (i for i in range(len(content)) if content.startswith(mark, i)):
            content[start + place] |= 1
    (tmp_path / "locked.npz").write_bytes(content)
    with pytest.raises(InputError, match=r"locked.npz: not a readable .npz file .*encrypted"):
        load_recording(tmp_path / "locked.npz", "data", ["x4", "a1"], 2.0)
    (tmp_path / "text.npz").write_text("time,a\n0,1\n")
    with pytest.raises(InputError, match=r"text.npz: not a readable .npz file \(File is not a zip file\)"):
        load_recording(tmp_path / "text.npz", "data", ["x4", "a1"], 2.0)
