"""The script builds, prints and writes what it says, and refuses bad input with one line a fault."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import eigh
from typer.testing import CliRunner, Result

from fe_models.arrays import FloatArray
from fe_models.built_in.bridge import bridge
from fe_models.built_in.four_dof import four_dof
from fe_models.causes import (
    AddedMass,
    AxialForce,
    CoulombFriction,
    CubicSpring,
    DeadLoad,
    GapStop,
    HarmonicForce,
    HystereticSpring,
    MassChange,
    ModalDamping,
    PointDamper,
    QuadraticDamper,
    QuadraticSpring,
    SlackCable,
    StiffnessChange,
    SupportSpring,
    known_effects,
)
from fe_models.files.atomic import write_npz
from fe_models.files.dataset_file import load_dataset
from fe_models.files.matrices_file import load_linear_model
from fe_models.files.structure_file import load_structure, save_structure
from fe_models.four_dof_data import paper_dataset
from fe_models.structure import Damping, Spring
from hybrid.commands.app import app as hybrid_modal
from scripts.build_fe_model import app
from tests.problems import cantilever
from tests.space_frames import two_storeys

AT_100 = ("--sampling-rate", "100")


def build(*arguments: str) -> Result:
    return CliRunner().invoke(app, list(arguments))


def arrays(folder: Path) -> dict[str, np.ndarray[tuple[int, ...], np.dtype[np.float64]]]:
    with np.load(folder / "model.npz", allow_pickle=False) as file:
        return dict(file)


@pytest.mark.slow
def test_bridge_with_pictures(tmp_path: Path) -> None:
    result = build("bridge", "--out", str(tmp_path), "--modes", "3")
    assert result.exit_code == 0, result.output
    assert "153 free degrees of freedom" in result.output
    assert "Natural modes without loads and prestress:" in result.output
    assert "1.6387 Hz         0.300 %   1.6387 Hz" in result.output
    found = arrays(tmp_path)
    assert found["M"].shape == found["K"].shape == found["C"].shape == (153, 153)
    omega = np.sqrt(eigh(found["K"], found["M"], eigvals_only=True)[:3])
    np.testing.assert_allclose(found["frequencies"], omega / (2 * np.pi), rtol=1e-6)  # eigh on K, not on its inverse
    assert found["mode_shapes"].shape == (165, 3)
    assert (found["dof_node"][:3].tolist(), found["dof_direction"][:3].tolist()) == ([1, 1, 2], ["x", "rz", "x"])
    assert load_structure(tmp_path / "structure.toml") == bridge()
    assert (tmp_path / "modes.png").stat().st_size > 10_000
    assert (tmp_path / "structure.png").stat().st_size > 10_000


@pytest.mark.slow
def test_a_structure_with_effects_is_built_drawn_and_simulated_from_its_file(tmp_path: Path) -> None:
    effects = (
        StiffnessChange((5, 54), (0.7, 0.5)),
        MassChange((6,), 1.1),
        AddedMass(9, 0.4),
        SupportSpring(4, "y", 2e4),
        AxialForce((3, 35), 20.0),
        DeadLoad(),
        PointDamper((9, 21), "y", 3.0),
        ModalDamping((2,), 0.01),
        QuadraticDamper((12,), "y", 5.0),
        CoulombFriction((15,), "y", 0.05),
        CubicSpring((12,), "y", 1e9),
        QuadraticSpring((14,), "y", 1e5),
        HystereticSpring((16,), "y", 100.0, 0.5, 2.0),
        GapStop((18,), "y", 1e-4, 1e4, 1),
        SlackCable(55, 10.0),
        HarmonicForce(12, "y", 0.5, 4.0),
    )
    assert len(effects) == len(known_effects())
    save_structure(bridge().with_effects(*effects), tmp_path / "extended.toml")
    options = ["--modes", "2", "--simulate", "--pull", "19:y:-9.81", "--duration", "0.5", "--sensor", "9:y"]
    result = build(str(tmp_path / "extended.toml"), "--out", str(tmp_path / "run"), *options)
    assert result.exit_code == 0, result.output
    assert "154 free degrees of freedom" in result.output  # one that a support holds no more
    assert "1.000 %" in result.output
    assert "Natural modes about the state at rest under weight and prestress:" in result.output
    assert (tmp_path / "run/modes.png").stat().st_size > 10_000
    dataset = load_dataset(tmp_path / "run/dataset.toml")
    assert dataset.model == bridge().with_effects(*effects)
    found = arrays(tmp_path / "run")
    shapes = found["mode_shapes"][[i for i in range(165) if i not in _held(found)]]
    ratios = np.diag(shapes.T @ found["C"] @ shapes) / (4 * np.pi * found["frequencies"])
    np.testing.assert_allclose(ratios, found["damping_ratio"], rtol=1e-6)  # C is complete; dense eigenvectors


def _held(found: dict[str, np.ndarray[tuple[int, ...], np.dtype[np.float64]]]) -> list[int]:
    """Rows of the degrees of freedom that supports hold."""
    everywhere = list(zip(found["all_dof_node"].tolist(), found["all_dof_direction"].tolist(), strict=True))
    free = set(zip(found["dof_node"].tolist(), found["dof_direction"].tolist(), strict=True))
    return [row for row, dof in enumerate(everywhere) if dof not in free]


def test_built_structure_builds_again_refined(tmp_path: Path) -> None:
    assert build("bridge", "--out", str(tmp_path / "a"), "--no-pictures").exit_code == 0
    again = build(str(tmp_path / "a/structure.toml"), "--out", str(tmp_path / "b"), "--refine", "2", "--no-pictures")
    assert again.exit_code == 0, again.output
    assert arrays(tmp_path / "b")["M"].shape == (309, 309)
    # one element a member is off by 3e-5
    np.testing.assert_allclose(arrays(tmp_path / "b")["frequencies"], arrays(tmp_path / "a")["frequencies"], rtol=1e-4)


def test_refining_sets_the_divisions_and_does_not_compound(tmp_path: Path) -> None:
    model = "bridge"
    for folder in ("a", "b"):
        result = build(model, "--out", str(tmp_path / folder), "--refine", "3", "--no-pictures", "--modes", "1")
        assert result.exit_code == 0, result.output
        model = str(tmp_path / folder / "structure.toml")
        assert load_structure(Path(model)).divisions == 3
    build(model, "--out", str(tmp_path / "c"), "--no-pictures", "--modes", "1")
    assert load_structure(tmp_path / "c/structure.toml").divisions == 3


def test_a_node_that_dividing_beams_adds_is_none_to_pull_at(tmp_path: Path) -> None:
    options = ("--refine", "2", "--pull", "56:y:-1", "--sensor", "57:y")
    result = build("bridge", "--out", str(tmp_path / "a"), "--simulate", *options)
    assert result.exit_code == 2
    assert "load of -1 N: node 56 is none of the structure's; the nodes are 1 to 55" in result.output
    assert "node 57 does not exist; the model's nodes are 1 to 55" in result.output


def test_large_models_are_written_sparse(tmp_path: Path) -> None:
    result = build("bridge", "--out", str(tmp_path), "--refine", "10", "--no-pictures")
    assert result.exit_code == 0, result.output
    assert "M" not in arrays(tmp_path)
    assert load_linear_model(tmp_path / "model.npz").stiffness.nnz < 20_000


def test_own_matrices_give_their_modes(tmp_path: Path) -> None:
    build("four_dof", "--out", str(tmp_path / "a"), "--no-pictures")
    result = build(str(tmp_path / "a/model.npz"), "--out", str(tmp_path / "b"), "--no-pictures", "--modes", "4")
    assert result.exit_code == 0, result.output
    np.testing.assert_allclose(arrays(tmp_path / "b")["frequencies"], arrays(tmp_path / "a")["frequencies"], rtol=1e-12)


def test_c_holds_modal_damping(tmp_path: Path) -> None:
    structure = four_dof()
    damped = type(structure)(**{**vars(structure), "dashpots": (), "damping": Damping(modal_ratios=(0.05,))})
    save_structure(damped, tmp_path / "chain.toml")
    assert build(str(tmp_path / "chain.toml"), "--out", str(tmp_path), "--no-pictures").exit_code == 0
    found = arrays(tmp_path)
    modal = found["mode_shapes"].T @ found["C"] @ found["mode_shapes"]
    expected = np.diag(2 * 0.05 * 2 * np.pi * found["frequencies"])
    np.testing.assert_allclose(modal, expected, atol=1e-12)  # roundings


def test_four_dof_data_are_the_paper_s(tmp_path: Path) -> None:
    options = ("--simulate", "--realisations", "5", "--cubic-stiffness", "1", "--no-pictures")
    result = build("four_dof", "--out", str(tmp_path), *options)
    assert result.exit_code == 0, result.output
    dataset = load_dataset(tmp_path / "dataset.toml")
    expected = paper_dataset(1.0, realisations=5)
    for found, wanted in zip(dataset.recordings, expected.recordings, strict=True):
        np.testing.assert_array_equal(found.data, wanted.data)


def test_a_chain_s_steps_follow_from_its_highest_mode(tmp_path: Path) -> None:
    """Of a chain of 3.5 to 30 Hz; a coarser step that is asked for is warned about, what would fold down is refused."""
    springs = (element for element in four_dof().elements if isinstance(element, Spring))
    stiff = replace(four_dof(), elements=tuple(replace(each, stiffness=8000 * each.stiffness) for each in springs))
    save_structure(stiff, tmp_path / "chain.toml")
    options = (str(tmp_path / "chain.toml"), "--simulate", "--no-pictures", "--sensor", "1:x", "--realisations", "1")
    timing = ("--sampling-rate", "100", "--duration", "3", "--noise", "0")

    def data(name: str, *step: str) -> FloatArray:
        result = build(*options, *timing, *step, "--out", str(tmp_path / name))
        assert result.exit_code == 0, result.output
        warned = "warning: time step" in result.stderr and "the highest mode needs 0.00078 s or less" in result.stderr
        assert warned == (name == "coarse")
        return load_dataset(tmp_path / name / "dataset.toml").recordings[0].data

    own, finer, coarse = data("own"), data("finer", "--step", "2e-4"), data("coarse", "--step", "0.005")
    assert np.abs(own - finer).max() < 1e-5 * finer.std()
    assert np.abs(coarse - finer).max() > 1e-4 * finer.std()
    result = build(*options, "--out", str(tmp_path / "slow"))
    assert result.exit_code == 2
    assert "up to 30.44 Hz, above half the sampling_rate of 10 Hz: sample at 76.1 Hz or more" in result.stderr


def test_bridge_recordings_load_again(tmp_path: Path) -> None:
    options = ("--simulate", "--pull", "19:y:-9.81", "--pull", "9:y:-5+21:y:-5", "--duration", "1", "--step", "0.002")
    result = build("bridge", "--out", str(tmp_path), "--no-pictures", *options)
    assert result.exit_code == 0, result.output
    dataset = load_dataset(tmp_path / "dataset.toml")
    assert [recording.data.shape for recording in dataset.recordings] == [(1, 101, 8)] * 2
    assert [sensor.name for sensor in dataset.sensors if sensor.role == "held_out"] == ["A2"]


def test_own_frame_with_own_sensors(tmp_path: Path) -> None:
    damped = type(cantilever())(**{**vars(cantilever()), "damping": Damping(stiffness_factor=1e-4)})
    save_structure(damped, tmp_path / "beam.toml")
    options = ("--simulate", "--pull", "2:y:10", "--sensor", "2:y", "--sensor", "2:rz:displacement:held_out")
    timing = ("--duration", "0.5", "--sampling-rate", "200", "--noise", "0")
    result = build(str(tmp_path / "beam.toml"), "--out", str(tmp_path), "--no-pictures", *options, *timing)
    assert result.exit_code == 0, result.output
    tip, turn = load_dataset(tmp_path / "dataset.toml").sensors
    assert (tip.name, tip.unit, tip.role) == ("a2y", "m/s^2", "measured")
    assert (turn.quantity, turn.unit, turn.role) == ("displacement", "rad", "held_out")


def test_matrices_in_space_are_built_and_shaken_as_simulate_does(tmp_path: Path) -> None:
    write_npz(tmp_path / "floors.npz", two_storeys())
    write_npz(tmp_path / "quake.npz", {"a": np.random.default_rng(1).standard_normal(101)})
    options = (
        "--base",
        str(tmp_path / "quake.npz") + ":a",
        "--base-direction",
        "y",
        "--sensor",
        "4:y",
        "--no-pictures",
    )
    result = build(str(tmp_path / "floors.npz"), "--out", str(tmp_path / "a"), "--simulate", *options)
    assert result.exit_code == 0, result.output
    arguments = ["simulate", str(tmp_path / "floors.npz"), "--out", str(tmp_path / "b"), *options]
    assert CliRunner().invoke(hybrid_modal, arguments).exit_code == 0
    built, simulated = (load_dataset(tmp_path / name / "dataset.toml").recordings[0] for name in "ab")
    assert built.data.shape == (1, 101, 1)
    np.testing.assert_array_equal(built.data, simulated.data)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("nowhere",), ["'nowhere' is unknown"]),
        (("bridge", "--modes", "400"), ["153 free degrees of freedom"]),
        (
            ("bridge", "--simulate", "--pull", "99:y:3", "--pull", "x", "--sensor", "foo", "--lowpass", "60", *AT_100),
            ["--sensor foo", "--pull x", "lowpass = 60 Hz", "node 99 has no"],
        ),
        (
            ("bridge", "--simulate", "--noise", "0.01 m", "--duration", "1"),
            ["noise in m:", "noise of the sensors in m/s^2"],
        ),
        (("bridge", "--simulate", "--noise", "much"), ["--noise much: expected a number"]),
        (("bridge", "--simulate", "--noise", "1 m/s^2", "--noise", "2"), ["--noise: give either one number"]),
        (("four_dof", "--simulate", "--pull", "3:x:3", "--noise", "3"), ["--pull: four_dof", "--noise: four_dof"]),
        (("bridge", "--simulate", "--realisations", "3"), ["--realisations: is for chains"]),
        (("bridge", "--simulate", "--step", "0"), ["step = 0.0; must be positive"]),
    ],
)
def test_faults_are_one_line_each_and_leave_no_dataset(
    arguments: tuple[str, ...], words: list[str], tmp_path: Path
) -> None:
    result = build(*arguments, "--out", str(tmp_path), "--no-pictures")
    assert result.exit_code == 2
    lines = result.stderr.splitlines()
    assert len(lines) == len(words), result.stderr
    for line, word in zip(lines, words, strict=True):
        assert line.startswith("error: ")
        assert word in line
    assert list(tmp_path.iterdir()) == []


def test_help_teaches_by_examples() -> None:
    result = build("--help")
    assert "python scripts/build_fe_model.py bridge --out runs/bridge" in result.output
    assert "--simulate --pull 3:x:100 --sensor 2:x" in result.output


def test_a_model_without_damping_says_so(tmp_path: Path) -> None:
    save_structure(cantilever(), tmp_path / "beam.toml")
    result = build(str(tmp_path / "beam.toml"), "--out", str(tmp_path / "run"), "--no-pictures")
    assert "Note: the model has no damping" in result.stdout
    assert "Note: the model has no damping" not in build("bridge", "--out", str(tmp_path / "b"), "--no-pictures").stdout
