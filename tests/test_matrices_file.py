"""Linear models from matrices: exact round trips, the same model from each format, and every fault named."""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.io import mmwrite
from scipy.sparse import csr_array

from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.built_in.four_dof import four_dof
from fe_models.dof_map import DofMap
from fe_models.errors import InputError
from fe_models.files.atomic import write_npz
from fe_models.files.matrices_file import LARGEST_DENSE, load_linear_model, save_linear_model
from fe_models.files.models import load_model
from fe_models.linear import LinearModel
from fe_models.linear_checks import check_linear_model
from fe_models.structure import Structure

# Two masses between two walls, free in x; node 1 also has a held y, and node 3 is a wall.
M = np.diag([1.0, 2.0])
K = np.array([[3.0, -1.0], [-1.0, 4.0]])
C = 0.1 * K
NODES = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0]])
ARRAYS = {
    "M": M,
    "K": K,
    "C": C,
    "nodes": NODES,
    "dof_node": np.array([1, 2]),
    "dof_direction": np.array(["x", "x"]),
}


def model() -> LinearModel:
    dofs = DofMap(np.array([1, 1, 2, 3]), np.array(["x", "y", "x", "x"]), np.array([True, False, True, False]))
    return LinearModel(csr_array(M), csr_array(C), csr_array(K), dofs, NODES, (0.01, 0.02))


def assert_same(a: LinearModel, b: LinearModel) -> None:
    for name in ("mass", "damping", "stiffness"):
        np.testing.assert_array_equal(getattr(a, name).toarray(), getattr(b, name).toarray())
    np.testing.assert_array_equal(a.coordinates, b.coordinates)
    for name in ("node", "direction", "free"):
        np.testing.assert_array_equal(getattr(a.dofs, name), getattr(b.dofs, name))
    assert (a.modal_ratios, a.replaced_ratios) == (b.modal_ratios, b.replaced_ratios)


def test_a_saved_model_comes_back_with_its_supports(tmp_path: Path) -> None:
    save_linear_model(model(), tmp_path / "m.npz", {"frequencies": [1.0, 2.0]})
    assert_same(load_linear_model(tmp_path / "m.npz"), model())
    with np.load(tmp_path / "m.npz") as archive:
        assert archive["frequencies"].tolist() == [1.0, 2.0]
        assert archive["dof_node"].tolist() == [1, 2]  # of the rows of M


def test_damping_ratios_of_single_modes_come_back(tmp_path: Path) -> None:
    own = replace(model(), replaced_ratios=((1, 0.05), (2, 0.0)))
    save_linear_model(own, tmp_path / "m.npz")
    assert_same(load_linear_model(tmp_path / "m.npz"), own)


def test_a_large_model_is_saved_as_sparse_parts(tmp_path: Path) -> None:
    size = LARGEST_DENSE + 1
    band = csr_array(np.diag(np.full(size, 2.0)) - np.eye(size, k=1) - np.eye(size, k=-1))
    dofs = DofMap(np.arange(1, size + 1), np.full(size, "x"), np.ones(size, dtype=bool))
    chain = LinearModel(csr_array(np.eye(size)), csr_array((size, size)), band, dofs, np.zeros((size, 2)))
    save_linear_model(chain, tmp_path / "m.npz")
    assert (tmp_path / "m.npz").stat().st_size < 200_000  # 8 MB a matrix if it were dense
    assert_same(load_linear_model(tmp_path / "m.npz"), chain)


def test_damping_is_optional(tmp_path: Path) -> None:
    write_npz(tmp_path / "m.npz", {name: array for name, array in ARRAYS.items() if name != "C"})
    assert load_linear_model(tmp_path / "m.npz").damping.nnz == 0


def market_folder(folder: Path) -> Path:
    mmwrite(folder / "M.mtx", csr_array(M))
    mmwrite(folder / "K.mtx", csr_array(K), symmetry="symmetric")
    mmwrite(folder / "C.mtx", C)
    (folder / "nodes.csv").write_text("node,x,y\n1,0,0\n2,1,0\n3,2,0\n")
    (folder / "dofs.csv").write_text("node,direction\n1,x\n2,x\n")
    path = folder / "model.toml"
    path.write_text(
        'schema = 1\n[matrices]\nmass = "M.mtx"\nstiffness = "K.mtx"\ndamping = "C.mtx"\n'
        'nodes = "nodes.csv"\ndofs = "dofs.csv"\n'
    )
    return path


def test_matrix_market_and_npz_give_the_same_model(tmp_path: Path) -> None:
    write_npz(tmp_path / "m.npz", ARRAYS)
    market = load_model(market_folder(tmp_path).name, tmp_path)
    assert isinstance(market, LinearModel)
    assert_same(market, load_linear_model(tmp_path / "m.npz"))


def test_all_faults_of_matrix_market_files_at_once(tmp_path: Path) -> None:
    path = market_folder(tmp_path)
    (tmp_path / "M.mtx").unlink()
    (tmp_path / "K.mtx").write_text("not a matrix")
    (tmp_path / "nodes.csv").write_text("a,b\n1,2\n")
    (tmp_path / "dofs.csv").write_text("node,direction\none,x\n2,x\n")
    with pytest.raises(InputError) as caught:
        load_model(path.name, tmp_path)
    words = ("M.mtx: no such file", "K.mtx: not a readable Matrix", "expected the columns x,y", "'one' is not a node")
    assert len(caught.value.faults) == len(words)
    for fault, word in zip(caught.value.faults, words, strict=True):
        assert word in fault


def with_entry(matrix: np.ndarray, row: int, column: int, value: float) -> np.ndarray:
    changed = matrix.copy()
    changed[row, column] = value
    return changed


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({"K": K[:1]}, "K is 1 x 2; the dof map has 2 free degrees of freedom"),
        ({"K": np.zeros((2, 2, 2))}, "K has shape (2, 2, 2); expected (free, free)"),
        ({"M": np.eye(3)}, "M is 3 x 3; the dof map has 2 free"),
        (
            {"K": with_entry(K, 0, 1, np.nan)},
            "K holds numbers that are not finite (NaN or infinity), the first between node 1 in x and node 2 in x",
        ),
        (
            {"C": with_entry(C, 1, 1, np.inf)},
            "C holds numbers that are not finite (NaN or infinity), the first between node 2 in x",
        ),
        ({"K": with_entry(K, 0, 1, -1.01)}, "K is not symmetric"),
        (
            {"M": with_entry(M, 1, 0, 0.5)},
            "M is not symmetric: 0 between node 1 in x and node 2 in x, 0.5 the other way round",
        ),
        ({"K": -K}, "K has a negative stiffness, -3, at node 1 in x"),
        ({"M": 0 * M}, "M is zero: nothing has mass"),
        ({"M": M.astype(complex)}, "array 'M' holds complex128, not real numbers"),
        ({"nodes": np.zeros((3, 4))}, "coordinates have shape (3, 4); expected (node, 2), or (node, 3) in space"),
        ({"nodes": with_entry(NODES, 1, 1, np.nan)}, "coordinates hold numbers that are not finite"),
        ({"replaced_ratios": np.array([1.0, 0.02, 3.0])}, "replaced_ratios is no table of mode and ratio"),
        ({"dof_node": np.array([1, 7])}, "the dof map names nodes 1 to 7; coordinates are given for nodes 1 to 3"),
        ({"dof_node": np.array([1, 1])}, "node 1 x appears 2 times"),
        ({"dof_node": np.array([1, 2, 3])}, "dof_node (3,) and dof_direction (2,) differ in shape"),
        ({"dof_node": np.array([1, 1.5])}, "dof_node must hold whole numbers"),
        ({"dof_direction": np.array(["x", "u"])}, "direction 'u' is unknown; expected x, y, z, rx, ry or rz"),
        ({"dof_direction": np.array([0, 1])}, "dof_direction must be an array of texts"),
    ],
)
def test_a_fault_is_named(tmp_path: Path, change: dict[str, np.ndarray], fault: str) -> None:
    write_npz(tmp_path / "m.npz", (ARRAYS | change))
    with pytest.raises(InputError) as caught:
        load_linear_model(tmp_path / "m.npz")
    assert any(fault in line for line in caught.value.faults), caught.value.faults


def test_missing_arrays_are_all_named(tmp_path: Path) -> None:
    np.savez(tmp_path / "m.npz", stiffness=K)
    with pytest.raises(InputError) as caught:
        load_linear_model(tmp_path / "m.npz")
    assert len(caught.value.faults) == 5  # M, K, nodes, dof_node, dof_direction
    assert "it has stiffness" in caught.value.faults[0]


@pytest.mark.parametrize("part", ["indices", "indptr"])
def test_sparse_parts_that_point_outside_are_refused(tmp_path: Path, part: str) -> None:
    sparse = csr_array(K)
    parts = {f"K_{name}": np.array(getattr(sparse, name)) for name in ("data", "indices", "indptr", "shape")}
    parts[f"K_{part}"] = parts[f"K_{part}"] + 100
    write_npz(tmp_path / "m.npz", {name: array for name, array in ARRAYS.items() if name != "K"} | parts)
    with pytest.raises(InputError, match="no compressed sparse row matrix"):
        load_linear_model(tmp_path / "m.npz")


def test_rounding_noise_is_no_asymmetry() -> None:
    # Assembled or printed matrices are symmetric to their last digits only.
    stiffness = csr_array(K + np.array([[0.0, 1e-12], [0.0, 0.0]]))
    assert check_linear_model(replace(model(), stiffness=stiffness)) == []


@pytest.mark.parametrize(("spec", "kind"), [("four_dof", Structure), ("bridge", Structure), ("m.npz", LinearModel)])
def test_models_are_found_by_name_or_file(tmp_path: Path, spec: str, kind: type) -> None:
    write_npz(tmp_path / "m.npz", ARRAYS)
    assert isinstance(load_model(spec, tmp_path), kind)


@pytest.mark.parametrize(
    ("spec", "fault"),
    [
        ("brigde", "model 'brigde' is unknown; did you mean 'bridge'\\?; or give a .toml or .npz file"),
        ("none.toml", "none.toml: no such file"),
        ("none.npz", "none.npz: no such file"),
    ],
)
def test_an_unknown_model_is_bad_input(tmp_path: Path, spec: str, fault: str) -> None:
    with pytest.raises(InputError, match=fault):
        load_model(spec, tmp_path)


class Malicious:
    """Unpickling it would make the file ``pwned``."""

    def __init__(self, target: Path) -> None:
        self.target = target

    def __reduce__(self) -> tuple[Callable[..., object], tuple[str, ...]]:
        return Path.touch, (self.target,)  # type: ignore[return-value]  # a path pickles as well as a text


def test_a_pickled_object_is_refused_and_not_run(tmp_path: Path) -> None:
    target = tmp_path / "pwned"
    np.savez(tmp_path / "m.npz", allow_pickle=True, **(ARRAYS | {"K": np.array([Malicious(target)], dtype=object)}))
    with pytest.raises(InputError, match="no plain array 'K'"):
        load_linear_model(tmp_path / "m.npz")
    assert not target.exists()
    with np.load(tmp_path / "m.npz", allow_pickle=True) as archive:
        assert archive["K"] is not None  # the trap was armed
    assert target.exists()


def test_damping_that_feeds_energy_is_a_fault() -> None:
    model = linearise(four_dof())
    negative = replace(model, damping=csr_array(-model.damping))
    assert "C has a negative damping, -0.1, at node 1 in x" in check_linear_model(negative)


def test_a_damper_may_take_away_from_modal_damping() -> None:
    model = linearise(four_dof())
    taken = replace(model, damping=csr_array(-0.1 * model.damping), modal_ratios=(0.1,))
    assert not check_linear_model(taken)
    assert any("negative damping" in fault for fault in check_linear_model(replace(taken, modal_ratios=(0.001,))))
    loose = replace(taken, stiffness=0.0 * taken.stiffness)  # which its natural modes tell, not this
    assert not any("negative damping" in fault for fault in check_linear_model(loose))
    both = replace(taken, modal_ratios=(), stiffness=csr_array(-taken.stiffness))
    assert {fault.split(" has")[0] for fault in check_linear_model(both)} == {"C", "K"}


@pytest.mark.parametrize(
    ("arrays", "fault"),
    [
        ({"modal_ratios": np.array([np.nan])}, "modal_ratios: nan is no damping ratio"),
        ({"modal_ratios": np.array([9.0])}, "modal_ratios: 9 is no damping ratio"),
        ({"replaced_ratios": np.array([[1.0, -0.1]])}, "replaced_ratios: -0.1 is no damping ratio"),
        ({"replaced_ratios": np.array([[0.0, 0.1]])}, "replaced_ratios: there is no mode 0"),
        ({"C": np.array([[1.0, 2.0], [2.0, 1.0]])}, "C feeds energy into some motion, most of all node"),
        ({"K": np.diag([1e200, 1.0])}, "K holds numbers beyond 1e+30"),
    ],
)
def test_damping_that_is_none_is_refused(arrays: dict[str, FloatArray], fault: str, tmp_path: Path) -> None:
    np.savez(tmp_path / "m.npz", **(ARRAYS | arrays))  # type: ignore[arg-type]
    with pytest.raises(InputError, match=re.escape(fault)):
        load_linear_model(tmp_path / "m.npz")


def test_gyroscopic_terms_feed_no_energy(tmp_path: Path) -> None:
    """Their work is zero: C may be skew."""
    np.savez(tmp_path / "m.npz", **(ARRAYS | {"C": np.array([[0.1, 2.0], [-2.0, 0.1]])}))  # type: ignore[arg-type]
    assert load_linear_model(tmp_path / "m.npz").damping[0, 1] == 2.0
