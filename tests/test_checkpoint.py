"""Checkpoints: everything comes back, nothing in a file is executed, and a bad file is one clear line."""

import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from scipy.sparse import csr_array

from fe_models.built_in.four_dof import four_dof
from fe_models.causes import CubicSpring
from fe_models.dofs import structure_dofs
from fe_models.errors import InputError
from fe_models.linear import LinearModel, ModalModel
from fe_models.recordings import Dataset
from hybrid.config import Config, ModelConfig, paper_preset
from hybrid.estimation.forecast import forecast_windows
from hybrid.estimation.windows import cut_all
from hybrid.training.checkpoint import Checkpoint, load_checkpoint, save_checkpoint
from hybrid.training.checkpoint_content import FORMAT
from hybrid.training.run import begin
from tests.hybrid_problems import MASS, STIFFNESS, TINY, chain_dataset, learned, same

PAPER = Config(replace(paper_preset("four_dof").model, encoder_hidden=4, rnn_hidden=4, net_hidden=4), TINY.training)


@pytest.fixture(scope="module")
def dataset() -> Dataset:
    """Of a chain that carries an effect of its own, which the model has to feel after loading as before."""
    spring = CubicSpring((1,), "x", 0.01)
    return replace(chain_dataset(), model=four_dof().with_effects(spring))


@pytest.fixture(scope="module")
def checkpoint(dataset: Dataset, tmp_path_factory: pytest.TempPathFactory) -> Checkpoint:
    run = begin(dataset, replace(TINY, training=replace(TINY.training, epochs=2)), tmp_path_factory.mktemp("run"))
    list(run.epochs())
    return run.checkpoint()


def reloaded(checkpoint: Checkpoint, folder: Path) -> Checkpoint:
    save_checkpoint(checkpoint, folder / "checkpoint.pt")
    return load_checkpoint(folder / "checkpoint.pt")


def test_a_loaded_model_forecasts_the_same_bits(checkpoint: Checkpoint, dataset: Dataset, tmp_path: Path) -> None:
    again = reloaded(checkpoint, tmp_path)
    windows = cut_all(dataset.select("test"), 80, 20)
    before, after = (forecast_windows(each.model, windows) for each in (checkpoint, again))
    np.testing.assert_array_equal(after.channels, before.channels)
    np.testing.assert_array_equal(after.q, before.q)
    assert same(learned(again.model), learned(checkpoint.model))


@pytest.mark.parametrize("config", [PAPER, replace(TINY, model=ModelConfig(modes=2, net_hidden=4, encoder_samples=7))])
def test_every_kind_of_model_comes_back(config: Config, dataset: Dataset, tmp_path: Path) -> None:
    first = begin(dataset, config, tmp_path).checkpoint()
    again = reloaded(first, tmp_path)
    windows = cut_all(dataset.select("test"), 40, 20)
    np.testing.assert_array_equal(
        forecast_windows(again.model, windows).channels, forecast_windows(first.model, windows).channels
    )


def test_it_carries_config_structure_sensors_and_normalisation(
    checkpoint: Checkpoint, dataset: Dataset, tmp_path: Path
) -> None:
    again = reloaded(checkpoint, tmp_path)
    assert again.config == checkpoint.config
    assert again.origin.structure == dataset.model
    assert again.origin.sensors == dataset.sensors
    assert again.origin.sampling_rate == dataset.sampling_rate
    assert again.origin.kept == ("one", "other")
    assert again.history == checkpoint.history
    assert (again.origin.unexplained, again.origin.data_digest, again.seconds) == (
        checkpoint.origin.unexplained,
        checkpoint.origin.data_digest,
        checkpoint.seconds,
    )
    assert_same_modes(again.origin.modal, checkpoint.origin.modal)
    for name in ("channel_scale", "dynamics.a", "dynamics.b"):
        assert torch.equal(again.model.get_buffer(name), checkpoint.model.get_buffer(name))


def assert_same_modes(one: ModalModel, other: ModalModel) -> None:
    for name in ("omega", "damping_ratio", "shapes"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    for name in ("node", "direction", "free"):
        np.testing.assert_array_equal(getattr(one.dofs, name), getattr(other.dofs, name))


def test_a_model_of_ones_own_matrices_has_no_structure(dataset: Dataset, tmp_path: Path) -> None:
    dofs = structure_dofs(four_dof())
    matrices = LinearModel(csr_array(MASS), csr_array(0.1 * MASS), csr_array(STIFFNESS), dofs, np.zeros((4, 2)))
    again = reloaded(begin(replace(dataset, model=matrices), PAPER, tmp_path).checkpoint(), tmp_path)
    assert again.origin.structure is None
    assert again.origin.sensors == dataset.sensors


class Burglar:
    """What a hostile file holds: unpickling it makes a folder."""

    def __init__(self, trace: Path) -> None:
        self.trace = trace

    def __reduce__(self) -> tuple[object, ...]:
        return Path.mkdir, (self.trace,)


@pytest.mark.parametrize("container", ["torch", "pickle"])
def test_nothing_in_a_file_is_executed(container: str, tmp_path: Path) -> None:
    path, trace = tmp_path / "checkpoint.pt", tmp_path / "trace"
    content = {"format": 1, "model": Burglar(trace)}
    if container == "torch":
        torch.save(content, path)
    else:
        path.write_bytes(pickle.dumps(content, protocol=2))
    with pytest.raises(InputError, match=r"checkpoint.pt: is not a checkpoint of this program"):
        load_checkpoint(path)
    assert not trace.exists()
    torch.load(path, weights_only=False) if container == "torch" else pickle.loads(path.read_bytes())
    assert trace.exists()  # the trap works


def test_a_missing_file_says_what_to_give(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none.pt: no such file; give the folder or checkpoint"):
        load_checkpoint(tmp_path / "none.pt")


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 0.99])
def test_a_truncated_file_is_refused(share: float, checkpoint: Checkpoint, tmp_path: Path) -> None:
    path = tmp_path / "checkpoint.pt"
    save_checkpoint(checkpoint, path)
    whole = path.read_bytes()
    path.write_bytes(whole[: int(share * len(whole))])
    with pytest.raises(InputError, match="is not a checkpoint of this program"):
        load_checkpoint(path)


def test_other_files_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "checkpoint.pt"
    for content in (torch.zeros(3), [1, 2], {"weights": torch.zeros(2)}, 5, {"format": FORMAT}):
        torch.save(content, path)
        with pytest.raises(InputError, match="is not a checkpoint of this program"):
            load_checkpoint(path)
    for raw in (b"schema = 1\nmodel = 'four_dof'\n", b"\x93NUMPY\x01\x00", b"\x00" * 100, bytes(range(256))):
        path.write_bytes(raw)
        with pytest.raises(InputError, match="is not a checkpoint of this program"):
            load_checkpoint(path)


def test_a_folder_in_its_place_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError):
        load_checkpoint(tmp_path)


def test_another_version_is_refused(tmp_path: Path) -> None:
    torch.save({"format": 99}, tmp_path / "new.pt")
    with pytest.raises(InputError, match=f"has checkpoint format 99, this program reads {FORMAT}; train again"):
        load_checkpoint(tmp_path / "new.pt")


def test_an_older_checkpoint_stays_until_the_new_one_is_whole(
    checkpoint: Checkpoint, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "checkpoint.pt"
    save_checkpoint(checkpoint, path)
    before = path.read_bytes()

    def interrupted(target: Path, content: bytes) -> None:
        with target.open("wb") as file:
            file.write(content[: len(content) // 2])
        raise KeyboardInterrupt

    monkeypatch.setattr(Path, "write_bytes", interrupted)
    with pytest.raises(KeyboardInterrupt):
        save_checkpoint(checkpoint, path)
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]
