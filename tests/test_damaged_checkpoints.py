"""A checkpoint that is not what was written is refused whole, with all that is wrong with it and what to do."""

from collections import OrderedDict
from contextlib import suppress
from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import torch

from fe_models.errors import InputError
from hybrid.config import Config, ModelConfig, places_preset
from hybrid.training.checkpoint import load_checkpoint, require_own, save_checkpoint
from hybrid.training.checkpoint_content import content_digest, raw_content
from hybrid.training.run import begin
from tests.hybrid_problems import TINY, chain_dataset
from tests.odd_inputs import answered, changed, damaged, odd_values
from tests.test_odd_inputs import EFFORTS, tried

SOME = [pytest.param(20, id="some"), *EFFORTS[1:]]
PLACES = places_preset()
KINDS = {
    "default": TINY,
    "places": Config(replace(PLACES.model, net_hidden=2), replace(PLACES.training, window=80, epochs=2)),
    "experts": Config(ModelConfig(residual="backbone", experts=True, net_hidden=4), TINY.training),
}
ODD_TENSORS: list[Any] = [
    torch.zeros(0),
    torch.zeros(3, 2),
    torch.tensor(float("nan")),
    torch.ones(1).expand(2**40),
    torch.ones(4, dtype=torch.int64),
    torch.ones(4, 4, dtype=torch.complex64),
    torch.eye(3).to_sparse(),
    None,
]


@pytest.fixture(scope="module", params=list(KINDS))
def path(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp(request.param)
    run = begin(chain_dataset(), KINDS[request.param], folder)
    next(run.epochs())
    save_checkpoint(run.checkpoint(), folder / "checkpoint.pt")
    return folder / "checkpoint.pt"


def plain(content: Any) -> Any:
    """The same with plain tables and lists, which the generator changes."""
    if isinstance(content, dict):
        return {key: plain(value) for key, value in content.items()}
    return [plain(item) for item in content] if isinstance(content, list) else content


def write(content: Any, path: Path, signed: bool = True) -> Path:
    """Write a content as a checkpoint; ``signed``: with its own digest, so that only a look at it tells."""
    if signed and isinstance(content, dict):
        with suppress(RuntimeError):  # of tensors that announce more than there is
            content = content | {"digest": content_digest(content)}
    torch.save(content, path)
    return path


@pytest.mark.parametrize("examples", SOME)
def test_whatever_is_changed_is_refused_or_makes_a_model(path: Path, examples: int, tmp_path: Path) -> None:
    content = plain(raw_content(path))
    assert answered(lambda: load_checkpoint(write(content, tmp_path / "same.pt")))

    def read(odd: Any) -> None:
        load_checkpoint(write(odd, tmp_path / "odd.pt"))

    assert tried(examples, changed(content, odd_values(ODD_TENSORS)), read) < examples / 2


@pytest.mark.parametrize("examples", SOME)
def test_damaged_bytes_are_refused_or_change_nothing(path: Path, examples: int, tmp_path: Path) -> None:
    whole = path.read_bytes()
    known = content_digest(raw_content(path))

    def read(content: bytes) -> None:
        (tmp_path / "odd.pt").write_bytes(content)
        load_checkpoint(tmp_path / "odd.pt")
        assert content_digest(raw_content(tmp_path / "odd.pt")) == known

    tried(examples // 2, damaged(whole), read)


def test_all_faults_are_named_with_what_to_do(path: Path, tmp_path: Path) -> None:
    content = raw_content(path)
    content["modal"]["omega"] = content["modal"]["omega"][:2]
    content["sampling_rate"] = "fast"
    content["format"] = torch.zeros(0)
    content["colour"] = 1
    del content["history"]
    with pytest.raises(InputError) as caught:
        load_checkpoint(write(content, tmp_path / "bad.pt"))
    words = "\n".join(caught.value.faults)
    for part in (
        "modal.",
        "sampling_rate",
        "format",
        "colour: is unknown",
        "history: is missing",
        "train again with --fresh",
    ):
        assert part in words


def test_one_turned_bit_of_a_weight_is_noticed(path: Path, tmp_path: Path) -> None:
    whole = bytearray(path.read_bytes())
    weight = next(
        value for value in raw_content(path)["model"].values() if value.is_floating_point() and value.numel() > 7
    )
    place = bytes(whole).find(weight.contiguous().numpy().tobytes())
    assert place > 0
    whole[place + 1] ^= 1
    (tmp_path / "turned.pt").write_bytes(whole)
    with pytest.raises(InputError, match=r"(?s)not what was written.*--fresh"):
        load_checkpoint(tmp_path / "turned.pt")


def test_arrays_larger_than_the_file_take_no_memory(path: Path, tmp_path: Path) -> None:
    content = raw_content(path)
    content["model"] = OrderedDict(content["model"], more=torch.ones(1).expand(2**42))
    torch.save(content, tmp_path / "large.pt")
    with pytest.raises(InputError, match=r"announces 1\.76e\+13 bytes"):
        load_checkpoint(tmp_path / "large.pt")


def test_weights_of_another_structure_are_refused(path: Path, tmp_path: Path) -> None:
    content = deepcopy(raw_content(path))
    content["modal"]["dof_free"][1] = False
    with pytest.raises(InputError, match="not those of the structure"):
        load_checkpoint(write(content, tmp_path / "other.pt"))


def test_a_fresh_training_moves_a_damaged_state_aside_and_no_other_file(path: Path, tmp_path: Path) -> None:
    state = tmp_path / "training.pt"
    turned = path.read_bytes()[:1000]
    state.write_bytes(turned)
    with pytest.raises(InputError, match="--fresh"):
        load_checkpoint(state)
    moved = require_own(state)
    assert [kept.read_bytes() for kept in tmp_path.iterdir()] == [turned]
    assert [moved] == list(tmp_path.iterdir())
    assert not state.exists()
    state.write_text("a letter")
    with pytest.raises(InputError, match="is not a checkpoint"):
        require_own(state)
    assert state.read_text() == "a letter"
