"""Whatever --out says, no command writes over a file of the user; what another run left is never taken for its own."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import NoReturn

import pytest
from typer.testing import CliRunner, Result

from fe_models.assembly import linearise
from fe_models.built_in.four_dof import four_dof
from fe_models.errors import InputError
from fe_models.files.array_files import load_arrays
from fe_models.files.dataset_file import load_dataset, save_dataset, write_dataset
from fe_models.files.matrices_file import save_linear_model
from fe_models.files.result_list import LIST_FILE
from fe_models.files.run_folder import load_run
from fe_models.files.structure_file import save_structure
from fe_models.linear import LinearModel, ModalModel
from fe_models.pictures import render
from fe_models.structure import Structure
from hybrid.commands.app import app
from tests.hybrid_problems import chain_dataset

CHAIN = """\
# my chain, with the mass that I weighed
schema = 1
name = "chain"
nodes = [[1.0, 0.0], [2.0, 0.0]]
directions = ["x"]
elements = [
    { kind = "spring", node = 1, direction = "x", stiffness = 2.0 },
    { kind = "spring", nodes = [1, 2], direction = "x", stiffness = 1.0 },
]
point_masses = [{ node = 1, mass = 1.0 }, { node = 2, mass = 2.0 }]
"""


def command(*arguments: str | Path) -> Result:
    return CliRunner().invoke(app, [*map(str, arguments)])


def done(*arguments: str | Path) -> str:
    result = command(*arguments)
    assert result.exit_code == 0, result.output
    return result.output


def content(folder: Path) -> dict[str, bytes]:
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture
def own(tmp_path: Path) -> Path:
    """The user's folder: a dataset on matrices, and notes that happen to have the names of results."""
    folder = tmp_path / "own"
    folder.mkdir()
    write_dataset(chain_dataset(), folder, "model.npz")  # as by hand: no list says that it is this program's
    save_linear_model(linearise(four_dof()), folder / "model.npz")
    for name in ("structure.toml", "report.json", "backbones.png", "mode_01.png"):
        (folder / name).write_text("mine")
    return folder


@pytest.mark.parametrize(
    ("arguments", "file", "reason"),
    [
        (("train", "own/dataset.toml"), "model.npz", "is read by this run"),
        (("diagnose", "own/dataset.toml"), "report.json", "is not on the list"),
        (("compare", "own/dataset.toml"), "backbones.png", "is not on the list"),
        (("build", "own/model.npz"), "model.npz", "is read by this run"),
        (("build", "bridge"), "mode_01.png, model.npz, structure.toml", "are not on the list"),
        (("render", "own"), "mode_01.png", "is not on the list"),
        (("simulate", "four_dof"), "dataset.toml, modal.npz, recording_1.npz", "are not on the list"),
        (("predict", "own", "--dataset", "own/dataset.toml"), "model.npz", "is read by this run"),
    ],
)
def test_a_file_of_the_user_is_never_written_over(
    arguments: Sequence[str], file: str, reason: str, own: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(own.parent)
    before = content(own)
    result = command(*arguments, "--out", "own")
    assert result.exit_code == 2, result.output
    refusal = next(line for line in result.stderr.splitlines() if file in line and reason in line)
    assert refusal.startswith("error: --out: own: ")
    assert "give another folder, such as own/" in refusal
    assert content(own) == before


def test_out_is_refused_together_with_the_faults_of_the_dataset(own: Path) -> None:
    (own / "dataset.toml").write_text((own / "dataset.toml").read_text().replace("recording_2.npz", "missing.npz"))
    for name in ("train", "diagnose", "compare"):
        lines = command(name, own / "dataset.toml", "--out", own).stderr.splitlines()
        assert any("missing.npz" in line for line in lines), name
        assert any("--out" in line for line in lines), name


def test_a_structure_written_by_hand_stays_with_its_comments(tmp_path: Path) -> None:
    """Built into its own folder, also twice and refined; a copy of it elsewhere is made all the same."""
    (tmp_path / "structure.toml").write_text(CHAIN)
    for refine in ("1", "4"):
        result = command("build", tmp_path / "structure.toml", "--out", tmp_path, "--refine", refine, "--no-pictures")
        assert result.exit_code == 2
        assert "structure.toml would be replaced, but is read by this run" in result.stderr
    assert content(tmp_path) == {"structure.toml": CHAIN.encode()}
    done("build", tmp_path / "structure.toml", "--out", tmp_path / "build", "--no-pictures")
    assert (tmp_path / "structure.toml").read_text() == CHAIN


def test_a_result_that_the_user_edited_is_kept(tmp_path: Path) -> None:
    """It is "to edit and build again"; built again from elsewhere, the edited one must not be lost."""
    done("build", "four_dof", "--out", tmp_path, "--no-pictures")
    done("build", "four_dof", "--out", tmp_path, "--no-pictures")
    (tmp_path / "structure.toml").write_text(CHAIN)
    result = command("build", "four_dof", "--out", tmp_path, "--no-pictures")
    assert result.exit_code == 2
    assert "structure.toml would be replaced, but is changed since build wrote it" in result.stderr
    assert (tmp_path / "structure.toml").read_text() == CHAIN


def drawn(subject: object, modal: ModalModel, folder: Path) -> list[Path]:
    """As `render.draw_modes`, in no time."""
    paths = [folder / f"mode_{number:02d}.png" for number in range(1, len(modal.omega) + 1)] + [folder / "modes.png"]
    for path in paths:
        path.write_text("drawn")
    return paths


def test_matrices_in_the_folder_of_an_older_structure_are_what_is_drawn(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nor do pictures of its higher modes stay."""
    monkeypatch.setattr(render, "draw_modes", drawn)
    save_linear_model(linearise(four_dof()), tmp_path / "mine.npz")
    done("build", "four_dof", "--out", tmp_path / "run")
    assert isinstance(load_run(tmp_path / "run").model, Structure)
    done("build", tmp_path / "mine.npz", "--out", tmp_path / "run", "--modes", "2")
    assert isinstance(load_run(tmp_path / "run").model, LinearModel)
    names = {path.name for path in (tmp_path / "run").iterdir()}
    assert names == {LIST_FILE, "model.npz", "mode_01.png", "mode_02.png", "modes.png", "structure.png"}


def test_a_structure_left_beside_matrices_is_not_taken_for_them(tmp_path: Path) -> None:
    """A file of the user that appears later, of as many degrees of freedom."""
    save_linear_model(linearise(four_dof()), tmp_path / "mine.npz")
    done("build", tmp_path / "mine.npz", "--out", tmp_path / "run", "--no-pictures")
    save_structure(four_dof(), tmp_path / "run" / "structure.toml")
    assert isinstance(load_run(tmp_path / "run").model, LinearModel)


def test_a_dataset_keeps_its_structure_when_another_is_built_beside_it(tmp_path: Path) -> None:
    (tmp_path / "chain.toml").write_text(CHAIN)
    done("simulate", "four_dof", "--out", tmp_path / "run", "--realisations", "3")
    done("build", tmp_path / "chain.toml", "--out", tmp_path / "run", "--no-pictures")
    model = load_dataset(tmp_path / "run" / "dataset.toml").model
    assert isinstance(model, Structure)
    assert model.name == "four_dof"
    done("simulate", "four_dof", "--out", tmp_path / "run", "--realisations", "2")
    assert len(load_arrays(tmp_path / "run" / "model.npz")["frequencies"]) == 2


def test_a_picture_that_fails_leaves_the_new_model_and_no_older_pictures(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def failing(*arguments: object) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr(render, "draw_modes", drawn)
    done("build", "four_dof", "--out", tmp_path, "--modes", "4")
    monkeypatch.setattr(render, "draw_modes", failing)
    result = command("build", "four_dof", "--out", tmp_path, "--modes", "2")
    assert isinstance(result.exception, ZeroDivisionError)
    assert {path.name for path in tmp_path.iterdir()} == {LIST_FILE, "model.npz", "structure.toml"}
    assert len(load_arrays(tmp_path / "model.npz")["frequencies"]) == 2


def test_a_dataset_saved_from_python_never_takes_the_place_of_a_file_of_the_user(own: Path) -> None:
    before = content(own)
    with pytest.raises(InputError, match=r"dataset\.toml, .* are not on the list"):
        save_dataset(chain_dataset(), own)
    assert content(own) == before


def test_a_dataset_saved_again_replaces_the_older_one_as_a_whole_or_leaves_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = chain_dataset()
    fewer = replace(whole, recordings=whole.recordings[:1])
    save_dataset(whole, tmp_path)
    before = content(tmp_path)
    with monkeypatch.context() as patch, pytest.raises(ZeroDivisionError):
        patch.setattr("fe_models.files.dataset_file.toml_text", failing)  # when the arrays are written already
        save_dataset(fewer, tmp_path)
    assert content(tmp_path) == before
    save_dataset(fewer, tmp_path)
    assert len(list(tmp_path.glob("recording_*.npz"))) == 1  # none of the older ones is left beside it
    assert len(load_dataset(tmp_path / "dataset.toml").recordings) == 1
    result = command("simulate", "four_dof", "--out", tmp_path, "--realisations", "2", "--no-pictures")
    assert result.exit_code == 2
    assert "are written by save_dataset" in result.stderr


def failing(*arguments: object) -> NoReturn:
    raise ZeroDivisionError
