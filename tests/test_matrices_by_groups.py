"""Matrices by groups, plane and in space: read, changed by effects, linked rigidly; closed forms; every fault named."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.io import mmwrite
from scipy.sparse import csr_array

from fe_models.causes import AddedMass, CubicSpring, MassChange, PointDamper, StiffnessChange, SupportSpring
from fe_models.errors import InputError
from fe_models.files.atomic import write_npz
from fe_models.files.matrices_file import load_linear_model, save_linear_model
from fe_models.files.models import load_model
from fe_models.linear import LinearModel
from fe_models.matrix_effects import matrix_changes_of, model_with_effects
from fe_models.modes import natural_modes
from tests.space_frames import FOLLOWED, cantilever_arrays, two_storeys


def read(folder: Path, arrays: dict[str, np.ndarray]) -> LinearModel:
    write_npz(folder / "m.npz", arrays)
    return load_linear_model(folder / "m.npz")


def test_a_cantilever_in_space_has_the_frequencies_of_the_closed_form(tmp_path: Path) -> None:
    """Bending in two planes, (1.875104 / L)^2 sqrt(E I / rho A); cubic elements, sixteen of them: off by 1e-7."""
    arrays, weak, strong = cantilever_arrays(16)
    modal = natural_modes(read(tmp_path, arrays), 2)
    np.testing.assert_allclose(modal.omega, [weak, strong], rtol=1e-6)
    moves = np.abs(modal.shapes).max(axis=0)
    tip = {axis: np.abs(modal.shapes[modal.dofs.row(17, axis)]) / moves for axis in ("y", "z")}
    assert tip["z"][0] > 0.1 > 1e-6 > tip["y"][0]  # the weak axis bends in z
    assert tip["y"][1] > 0.1 > 1e-6 > tip["z"][1]


def test_a_saved_model_comes_back_with_its_groups_links_and_lines(tmp_path: Path) -> None:
    model = read(tmp_path, two_storeys())
    save_linear_model(model, tmp_path / "again.npz")
    again = load_linear_model(tmp_path / "again.npz")
    assert [group.name for group in again.groups] == ["storey 1", "storey 2"]
    for one, other in zip(model.groups, again.groups, strict=True):
        np.testing.assert_array_equal(one.stiffness.toarray(), other.stiffness.toarray())
        np.testing.assert_array_equal(one.mass.toarray(), other.mass.toarray())
    assert model.dofs.links is not None
    assert again.dofs.links is not None
    np.testing.assert_array_equal(model.dofs.links.toarray(), again.dofs.links.toarray())
    assert again.lines is not None
    np.testing.assert_array_equal(again.lines, [[1, 2], [2, 3]])


def test_matrix_market_gives_the_same_model(tmp_path: Path) -> None:
    arrays = two_storeys()
    for name in ("M", "K", "K_1", "M_1", "K_2", "M_2"):
        mmwrite(tmp_path / f"{name}.mtx", csr_array(arrays[name]), symmetry="symmetric")
    places = "\n".join(",".join(map(str, place)) for place in arrays["nodes"].tolist())
    (tmp_path / "nodes.csv").write_text(f"x,y,z\n{places}\n")
    dofs = zip(arrays["dof_node"].tolist(), arrays["dof_direction"].tolist(), strict=True)
    (tmp_path / "dofs.csv").write_text("node,direction\n" + "\n".join(f"{n},{d}" for n, d in dofs) + "\n")
    (tmp_path / "model.toml").write_text(
        'schema = 1\n[matrices]\nmass = "M.mtx"\nstiffness = "K.mtx"\nnodes = "nodes.csv"\ndofs = "dofs.csv"\n'
        f"modal_ratios = [0.01]\nrigid_links = {arrays['rigid_links'].tolist()}\n"
        '[[matrices.groups]]\nname = "storey 1"\nstiffness = "K_1.mtx"\nmass = "M_1.mtx"\n'
        '[[matrices.groups]]\nname = "storey 2"\nstiffness = "K_2.mtx"\nmass = "M_2.mtx"\n'
    )
    market, other = load_model("model.toml", tmp_path), read(tmp_path, arrays)
    assert isinstance(market, LinearModel)
    np.testing.assert_allclose(natural_modes(market).shapes, natural_modes(other).shapes, atol=1e-12)
    assert market.modal_ratios == other.modal_ratios == (0.01,)


def test_a_corner_of_a_rigid_floor_follows_its_middle(tmp_path: Path) -> None:
    """u_s = u_m + theta x r: the corner at (2, 1) from the middle moves by -1 in x and 2 in y for a unit turn."""
    model = read(tmp_path, two_storeys())
    turned = np.zeros(model.mass.shape[0])
    turned[
        [
            n
            for n, (node, d) in enumerate(zip(model.dofs.node, model.dofs.direction, strict=True))
            if (node, d) == (2, "rz")
        ]
    ] = 1.0
    moved = model.dofs.expand(turned)
    assert moved[model.dofs.row(FOLLOWED, "x")] == -1.0
    assert moved[model.dofs.row(FOLLOWED, "y")] == 2.0
    force = np.zeros(len(model.dofs))
    force[model.dofs.row(FOLLOWED, "y")] = 3.0
    work = float(model.dofs.gathered(force) @ turned)
    assert work == pytest.approx(6.0, rel=1e-15)


def test_effects_change_the_matrices_as_their_definitions_say(tmp_path: Path) -> None:
    model = read(tmp_path, two_storeys())
    softer = model_with_effects(model, StiffnessChange((), 0.5, "storey 2"), MassChange((), 1.2, "storey 1"))
    np.testing.assert_allclose(
        softer.stiffness.toarray(), (model.stiffness - 0.5 * model.groups[1].stiffness).toarray(), rtol=1e-14
    )
    np.testing.assert_allclose(softer.mass.toarray(), (model.mass + 0.2 * model.groups[0].mass).toarray(), rtol=1e-14)
    np.testing.assert_allclose(softer.groups[1].stiffness.toarray(), 0.5 * model.groups[1].stiffness.toarray())
    mass = matrix_changes_of(model, AddedMass(FOLLOWED, 3.0))[0].toarray()
    turning = 2  # row of node 2 in rz: 3 kg at a distance of sqrt(5) m
    assert mass[turning, turning] == pytest.approx(15.0, rel=1e-12)
    assert matrix_changes_of(model, SupportSpring(3, "x", 7.0))[2].toarray()[3, 3] == 7.0
    between = matrix_changes_of(model, PointDamper((2, 3), "x", 2.0))[1].toarray()
    np.testing.assert_allclose(between[np.ix_([0, 3], [0, 3])], [[2.0, -2.0], [-2.0, 2.0]])


def test_effects_in_a_file_are_those_of_the_model(tmp_path: Path) -> None:
    model = read(tmp_path, two_storeys())
    (tmp_path / "damaged.toml").write_text(
        'schema = 1\n[matrices]\nfile = "m.npz"\n'
        '[[effects]]\nkind = "stiffness_change"\ngroup = "storey 1"\nfactor = 0.7\n'
        '[[effects]]\nkind = "added_mass"\nnode = 3\nmass = 100.0\n'
    )
    damaged = load_model("damaged.toml", tmp_path)
    assert isinstance(damaged, LinearModel)
    expected = model_with_effects(model, StiffnessChange((), 0.7, "storey 1"), AddedMass(3, 100.0))
    np.testing.assert_array_equal(damaged.stiffness.toarray(), expected.stiffness.toarray())
    np.testing.assert_array_equal(damaged.mass.toarray(), expected.mass.toarray())


def test_all_faults_of_effects_at_once(tmp_path: Path) -> None:
    model = read(tmp_path, two_storeys())
    with pytest.raises(InputError) as caught:
        model_with_effects(
            model,
            StiffnessChange((), 0.5, "storey 3"),
            StiffnessChange((1,), 0.5),
            AddedMass(9, 1.0),
            SupportSpring(2, "z", 1.0),
            CubicSpring((2,), "x", 1.0),
        )
    expected = (
        "there is no group 'storey 3'; the groups are: storey 1, storey 2",
        "matrices have groups, no elements",
        "node 9 does not exist; the nodes are 1 to 4",
        "node 2 does not move in z; it moves in x, y, rz",
        "cubic_spring: matrices alone do not say what it acts on",
    )
    assert len(caught.value.faults) == len(expected)
    for fault, words in zip(caught.value.faults, expected, strict=True):
        assert words in fault


def test_all_faults_of_groups_and_links_at_once(tmp_path: Path) -> None:
    arrays = two_storeys()
    broken = {
        **arrays,
        "groups": np.array(["storey 1", "storey 2", "roof"]),
        "K_1": 3 * arrays["K_1"],
        "K_2": arrays["K_2"] + 1e4 * np.triu(np.ones_like(arrays["K_2"]), 1),
    }
    with pytest.raises(InputError) as caught:
        read(tmp_path, broken)
    assert "group 'roof': holds neither K_3 nor M_3" in caught.value.faults[0]
    with pytest.raises(InputError) as caught:
        read(
            tmp_path, {name: value for name, value in broken.items() if name != "groups"} | {"groups": arrays["groups"]}
        )
    assert "group 'storey 2': its share of K is not symmetric" in str(caught.value)
    with pytest.raises(InputError) as caught:
        read(tmp_path, arrays | {"K_1": 3 * arrays["K_1"]})
    assert "the groups' shares of K at node 2 in x add up to" in str(caught.value)
    with pytest.raises(InputError) as caught:
        read(tmp_path, arrays | {"rigid_links": np.array([[2, 4], [3, 4], [4, 9]])})
    assert "rigid_links names nodes 2 to 9" in str(caught.value)
    with pytest.raises(InputError) as caught:
        read(tmp_path, arrays | {"rigid_links": np.array([[2, 4], [3, 4]])})
    assert "node 4 follows 2 nodes; one can lead it" in str(caught.value)


def test_a_huge_matrix_market_file_is_refused_before_it_is_read(tmp_path: Path) -> None:
    (tmp_path / "M.mtx").write_text("%%MatrixMarket matrix coordinate real general\n1000000 1000000 999999999\n1 1 1\n")
    for name in ("nodes.csv", "dofs.csv"):
        (tmp_path / name).write_text("x,y\n0,0\n" if name == "nodes.csv" else "node,direction\n1,x\n")
    (tmp_path / "model.toml").write_text(
        'schema = 1\n[matrices]\nmass = "M.mtx"\nstiffness = "M.mtx"\nnodes = "nodes.csv"\ndofs = "dofs.csv"\n'
    )
    with pytest.raises(InputError, match="announces 3e\\+09 numbers"):
        load_model("model.toml", tmp_path)


def test_groups_are_no_part_of_equal_modes(tmp_path: Path) -> None:
    model = read(tmp_path, two_storeys())
    np.testing.assert_array_equal(natural_modes(model).omega, natural_modes(replace(model, groups=())).omega)
