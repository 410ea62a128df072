"""Training on a dataset whose model is matrices that another program assembled."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.sparse import csr_array
from typer.testing import CliRunner, Result

from fe_models.built_in.four_dof import four_dof
from fe_models.dofs import structure_dofs
from fe_models.files.dataset_file import load_dataset, save_dataset
from fe_models.files.run_folder import load_run
from fe_models.linear import LinearModel
from fe_models.recordings import Assumptions, Dataset
from hybrid.training.checkpoint import load_checkpoint
from hybrid.training.run import CHECKPOINT, begin
from scripts.predict_motion import app as predict
from scripts.train_hybrid import app
from tests.blank_sheets import blank_sheets
from tests.hybrid_problems import MASS, STIFFNESS, TINY, chain_dataset, chain_modes

OPTIONS = ("--window", "80", "--batch", "8", "--first-horizon", "20", "--threads", "1", "--epochs", "1")


def matrix_dataset() -> Dataset:
    """The chain's recordings with M and K of the textbook, C = 2 % of K's, in place of the structure."""
    model = LinearModel(
        csr_array(MASS),
        csr_array(0.02 * STIFFNESS),
        csr_array(STIFFNESS),
        structure_dofs(four_dof()),
        np.column_stack([np.arange(1.0, 5.0), np.zeros(4)]),
    )
    return replace(chain_dataset(), model=model, assumptions=Assumptions())


def train(dataset: Path, out: Path) -> Result:
    return CliRunner().invoke(app, [str(dataset), "--out", str(out), *OPTIONS])


def scores_of(out: Path) -> Any:
    return json.loads((out / "metrics.json").read_text())["scores"]


@pytest.fixture(scope="module")
@blank_sheets()
def trained(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with dataset.toml, matrices.npz and, in "run", what the script made of them."""
    folder = tmp_path_factory.mktemp("matrices")
    result = train(save_dataset(matrix_dataset(), folder), folder / "run")
    assert result.exit_code == 0, result.output
    return folder


def test_the_model_is_that_of_the_matrices(trained: Path) -> None:
    """Frequencies by scipy's dense solver; xi = omega beta / 2 for C = beta K."""
    origin = load_checkpoint(trained / "run" / CHECKPOINT).origin
    assert origin.structure is None
    omega = chain_modes().omega
    np.testing.assert_allclose(origin.modal.omega, omega, rtol=1e-10)
    np.testing.assert_allclose(origin.modal.damping_ratio, 0.02 * omega / 2, rtol=1e-10)
    run = load_run(trained / "run")
    assert isinstance(run.model, LinearModel)
    np.testing.assert_allclose(run.model.stiffness.toarray(), STIFFNESS, rtol=0, atol=0)
    assert run.prediction is not None
    assert run.prediction.hybrid.shape == (80, 4)


@pytest.mark.slow
def test_scores_are_those_of_the_same_modes_of_a_structure(trained: Path, tmp_path: Path) -> None:
    """Where a model comes from makes no difference, only its modes do."""
    modal = load_checkpoint(trained / "run" / CHECKPOINT).origin.modal
    same = replace(chain_dataset(), assumptions=Assumptions(modal_model=modal))
    result = train(save_dataset(same, tmp_path, "four_dof"), tmp_path / "run")
    assert result.exit_code == 0, result.output
    assert scores_of(tmp_path / "run") == scores_of(trained / "run")


def test_only_a_structure_of_masses_in_a_row_has_a_loop(trained: Path) -> None:
    """Matrices do not say which mass hangs on node 1."""
    names = {path.name for path in (trained / "run").iterdir()}
    assert {"channels.png", "latent.png", "displacement.png", "training.png"} <= names
    assert not names & {"force_displacement.png", "structure.toml"}


@pytest.mark.slow
def test_an_interrupted_training_on_matrices_goes_on(trained: Path, tmp_path: Path) -> None:
    training = replace(TINY.training, epochs=2, noise_std=0.1)
    begun = begin(load_dataset(trained / "dataset.toml"), replace(TINY, training=training), tmp_path)
    next(begun.epochs())
    command = [*OPTIONS[:-1], "2"]
    result = CliRunner().invoke(app, [str(trained / "dataset.toml"), "--out", str(tmp_path), *command])
    assert result.exit_code == 2  # the network of TINY is smaller than the script's
    assert "net_hidden was 8, now 64" in result.output
    assert "another model" not in result.output


def test_a_motion_is_predicted_from_a_state(trained: Path, tmp_path: Path) -> None:
    (tmp_path / "pull.csv").write_text("node,direction,displacement,velocity\n4,x,0.5,0\n")
    arguments = [str(trained / "run"), "--out", str(tmp_path / "out"), "--initial", str(tmp_path / "pull.csv")]
    result = CliRunner().invoke(predict, arguments)
    assert result.exit_code == 0, result.output
    run = load_run(tmp_path / "out")
    assert isinstance(run.model, LinearModel)
    assert run.prediction is not None
    pulled = np.linalg.solve(STIFFNESS, [0, 0, 0, 1.0])
    np.testing.assert_allclose(run.prediction.fe[0], 0.5 * pulled / pulled[3], rtol=0, atol=1e-6)  # float32


@pytest.mark.slow
def test_matrices_in_the_folder_of_an_older_structure_are_the_model(trained: Path, tmp_path: Path) -> None:
    chain = save_dataset(chain_dataset(), tmp_path / "chain", "four_dof")
    for dataset in (chain, trained / "dataset.toml"):
        assert train(dataset, tmp_path / "run").exit_code == 0
    assert isinstance(load_run(tmp_path / "run").model, LinearModel)
    assert not (tmp_path / "run" / "force_displacement.png").exists()


def test_faults_of_the_matrices_are_named(trained: Path, tmp_path: Path) -> None:
    with np.load(trained / "matrices.npz") as file:
        arrays = dict(file)
    arrays["K"][0, 1] = 5.0
    arrays["M"] = arrays["M"][:3, :3]
    for name in ("dataset.toml", "recording_1.npz", "recording_2.npz", "recording_3.npz"):
        (tmp_path / name).write_bytes((trained / name).read_bytes())
    np.savez(tmp_path / "matrices.npz", **arrays)
    result = train(tmp_path / "dataset.toml", tmp_path / "out")
    assert result.exit_code == 2
    assert all(line.startswith("error: ") and "matrices.npz" in line for line in result.output.splitlines())
    assert not (tmp_path / "out").exists()
