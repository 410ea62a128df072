"""Odd datasets and folders of results, given to the commands that compute: an answer or an exit status that says why.

`make test` tries a few of the quick ones, `make test-all` hundreds of each. What loads a file is tried far more
often elsewhere.
"""

import shutil
import tomllib
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import strategies as st

from fe_models.files.dataset_file import save_dataset
from hybrid.config import Config
from hybrid.training.results import write_results
from hybrid.training.run import begin
from tests.blank_sheets import blank_sheets
from tests.hybrid_problems import TINY, chain_dataset, chain_modes
from tests.odd_inputs import changed, damaged, odd_values
from tests.test_odd_inputs import as_toml, memory, tried
from tests.test_odd_options import ended

__all__ = ["memory"]  # which each test here is under, too

FEW, MANY = 4, 300  # inputs of each command
TRAIN = ("--window", "80", "--batch", "8", "--first-horizon", "20", "--threads", "1", "--epochs", "1", "--fresh")
STATUSES = {0, 1, 2}  # 1: a training that diverges, say


def each_of(quick: str, slow: str) -> list[Any]:
    """Commands and how many inputs each: of the quick one few in every run."""
    many = [pytest.param(command, MANY, id=f"{command}-many", marks=pytest.mark.slow) for command in (quick, slow)]
    return [pytest.param(quick, FEW, id=f"{quick}-few"), *many]


@pytest.fixture(scope="module")
@blank_sheets()
def trained(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A dataset of the chain, beside it a training of one epoch, and a dataset that is long enough to be compared."""
    folder = tmp_path_factory.mktemp("trained")
    save_dataset(chain_dataset(), folder, "four_dof")
    long = chain_dataset(chain_modes(), noise=0.005, realisations=1, samples=1000)
    single = tuple(replace(each, data=each.data[:1]) for each in long.recordings)  # of several, each is drawn
    save_dataset(replace(long, recordings=single), folder / "long", "four_dof")
    run = begin(chain_dataset(), Config(TINY.model, replace(TINY.training, epochs=1)), folder / "run")
    list(run.epochs())
    write_results(run, chain_dataset())
    return folder


def said(*words: str) -> int:
    """The exit status of a command, one that a command may have, with words fit to print."""
    status, output = ended(*words, "--quiet")
    assert status in STATUSES, output
    assert "Traceback" not in output
    assert "\x1b" not in output
    return status


@pytest.mark.parametrize(("command", "examples"), each_of("train", "compare"))
def test_datasets(command: str, examples: int, trained: Path, tmp_path: Path) -> None:
    folder = trained if command == "train" else trained / "long"
    document = tomllib.loads((folder / "dataset.toml").read_text())
    path, statuses = folder / "odd.toml", Counter[int]()

    def read(odd: Any) -> None:
        path.write_text(as_toml(odd), encoding="utf-8", errors="replace")
        options = TRAIN if command == "train" else ()
        statuses[said(command, str(path), "--out", str(tmp_path / "out"), *options)] += 1

    with blank_sheets():
        read(document)
    assert statuses == {0: 1}  # as it is, it can be used
    tried(examples, changed(document, odd_values()), read)
    assert statuses[2] > 0


@pytest.mark.parametrize(("command", "examples"), each_of("predict", "render"))
def test_folders_of_a_training(command: str, examples: int, trained: Path, tmp_path: Path) -> None:
    """Bytes of one of its files are turned, cut off or doubled."""
    files = {path.name: path.read_bytes() for path in (trained / "run").iterdir() if path.suffix in (".npz", ".pt")}
    statuses = Counter[int]()
    more = (
        ("--dataset", str(trained / "dataset.toml"), "--duration", "2") if command == "predict" else ("--frames", "2")
    )

    def read(odd: tuple[str, bytes]) -> None:
        name, content = odd
        folder = tmp_path / "run"
        shutil.copytree(trained / "run", folder, dirs_exist_ok=True)
        (folder / name).write_bytes(content)
        statuses[said(command, str(folder), "--out", str(tmp_path / "out"), *more)] += 1

    name = min(files)
    read((name, files[name]))
    assert statuses[0] == 1
    one = st.sampled_from(sorted(files)).flatmap(lambda name: st.tuples(st.just(name), damaged(files[name])))
    tried(examples, one, read)
    assert statuses[2] > 0
