"""Experts trained once: a run that takes them over is, bit for bit, the run that trains its experts itself."""

from dataclasses import replace
from pathlib import Path

import pytest
import torch

from fe_models.recordings import Dataset, Recording
from hybrid.config import Config
from hybrid.training.expert_reuse import TrainedExpert, take_over, train_expert
from hybrid.training.expert_training import ExpertsTrainer
from hybrid.training.run import Run, begin
from tests.hybrid_problems import SENSORS, TINY, off_chain, recorded, same
from tests.test_expert_runs import CONFIG
from tests.test_experts import two_days

NAMES = ("one", "other")


@pytest.fixture(scope="module")
def dataset() -> Dataset:
    return two_days()


@pytest.fixture(scope="module")
def experts(dataset: Dataset, tmp_path_factory: pytest.TempPathFactory) -> list[TrainedExpert]:
    return [train_expert(dataset, name, CONFIG, tmp_path_factory.mktemp(name)) for name in NAMES]


@pytest.fixture(scope="module")
def separate(dataset: Dataset, tmp_path_factory: pytest.TempPathFactory) -> Run:
    run = begin(dataset, CONFIG, tmp_path_factory.mktemp("separate"))
    for _ in run.epochs():
        pass
    return run


def test_the_run_is_that_of_a_separate_training(
    dataset: Dataset, experts: list[TrainedExpert], separate: Run, tmp_path: Path
) -> None:
    """The model with its buffers, where each optimiser stands, and the history."""
    run = begin(dataset, CONFIG, tmp_path)
    take_over(run, experts)
    assert same(run.trainer.model.state_dict(), separate.trainer.model.state_dict())
    found, expected = run.trainer.state()["members"], separate.trainer.state()["members"]
    for one, other in zip(found, expected, strict=True):
        assert one["param_groups"] == other["param_groups"]
        assert all(same(one["state"][i], other["state"][i]) for i in other["state"])
    assert run.history == separate.history
    assert run.trainer.finished
    assert run.origin.data_digest == separate.origin.data_digest


def test_the_seconds_are_those_of_the_preparation_and_of_every_training(
    dataset: Dataset, experts: list[TrainedExpert], tmp_path: Path
) -> None:
    run = begin(dataset, CONFIG, tmp_path)
    before = run.seconds
    take_over(run, experts)
    assert before > 0
    assert all(expert.seconds > 0 for expert in experts)
    assert run.seconds == pytest.approx(before + experts[0].seconds + experts[1].seconds, rel=1e-12)


def test_an_expert_can_be_taken_over_again(dataset: Dataset, experts: list[TrainedExpert], tmp_path: Path) -> None:
    """What is done to one run's members does not reach the next one's."""
    first, second = begin(dataset, CONFIG, tmp_path), begin(dataset, CONFIG, tmp_path)
    take_over(first, experts)
    with torch.no_grad():
        for parameter in first.trainer.model.parameters():
            parameter.zero_()
    take_over(second, experts)
    assert isinstance(second.trainer, ExpertsTrainer)
    for member, expert in zip(second.trainer.model.members, experts, strict=True):
        assert same(member.state_dict(), expert.weights)


def test_an_expert_of_other_windows_is_refused(dataset: Dataset, experts: list[TrainedExpert], tmp_path: Path) -> None:
    run = begin(dataset, CONFIG, tmp_path)
    with pytest.raises(ValueError, match="other windows"):
        take_over(run, experts[::-1])


def test_experts_have_to_be_as_many_as_the_members(
    dataset: Dataset, experts: list[TrainedExpert], tmp_path: Path
) -> None:
    with pytest.raises(ValueError, match="1 experts"):
        take_over(begin(dataset, CONFIG, tmp_path), experts[:1])
    with pytest.raises(ValueError, match="2 experts"):
        take_over(begin(dataset, TINY, tmp_path), experts)


def test_the_windows_are_as_long_as_the_shortest_recording_of_all_allows(tmp_path: Path) -> None:
    """Also where the shortest one is another's: else the expert would not fit beside it."""
    one, length = off_chain(), 60
    short = Recording("short", recorded(one, 8, length, 5))
    dataset = replace(two_days(), recordings=(two_days().recordings[0], short), sensors=SENSORS)
    config = Config(CONFIG.model, replace(CONFIG.training, epochs=1, window=80))
    run = begin(dataset, config, tmp_path / "run")
    take_over(run, [train_expert(dataset, name, config, tmp_path / name) for name in ("one", "short")])
    assert run.trainer.windows.shape[1] == length
