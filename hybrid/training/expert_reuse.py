"""Experts trained once for several splits of the same recordings.

An expert trains on its recording alone, so that it is the same, bit for bit, whatever recordings stand beside it.
Trained alone it can take its place in a run of experts, which then is where its own training would have ended.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from torch import Tensor

from fe_models.recordings import Dataset
from hybrid.config import Config
from hybrid.estimation.windows import window_length
from hybrid.training.expert_training import ExpertsTrainer, mean_result
from hybrid.training.gradient_training import EpochResult
from hybrid.training.run import Run, begin, digest
from hybrid.training.session import train


@dataclass(frozen=True)
class TrainedExpert:
    """What a training leaves: the model's ``weights``, its ``trainer``'s state, its past and its seconds.

    ``seconds`` are those of the epochs; what comes before them is done again in every run that takes the expert.
    """

    weights: dict[str, Tensor]
    trainer: dict[str, Any]
    history: tuple[EpochResult, ...]
    seconds: float
    data_digest: str


def train_expert(dataset: Dataset, name: str, config: Config, folder: Path) -> TrainedExpert:
    """Train the expert of the recording ``name`` as a run of experts on ``dataset`` would, under a progress bar."""
    length = window_length(dataset, config)
    alone = replace(dataset, recordings=tuple(each for each in dataset.recordings if each.name == name))
    own = Config(replace(config.model, experts=False), replace(config.training, window=length))
    run = begin(alone, own, folder)
    prepared = run.seconds
    train(run, f"Training the expert of {name}")
    run.finish()
    trainer = run.trainer
    return TrainedExpert(
        weights={key: value.detach().clone() for key, value in trainer.model.state_dict().items()},
        trainer=trainer.state(),
        history=run.history,
        seconds=run.seconds - prepared,
        data_digest=run.origin.data_digest,
    )


def take_over(run: Run, experts: Sequence[TrainedExpert]) -> None:
    """Put a run of experts that has just begun where its training ends, with ``experts`` in the order of its members.

    `ValueError` where an expert was trained on other windows than the member whose place it takes.
    """
    trainer = run.trainer
    if not isinstance(trainer, ExpertsTrainer) or len(experts) != len(trainer.trainers):
        raise ValueError(f"{len(experts)} experts do not fit this run, which has other members")
    counts = trainer.model.counts.tolist()
    for expert, windows in zip(experts, trainer.windows.split(counts), strict=True):
        if digest(windows.numpy()) != expert.data_digest:
            raise ValueError("an expert was trained on other windows than the run's")
    for member, expert in zip(trainer.model.members, experts, strict=True):
        member.load_state_dict(expert.weights)
    trainer.load_state({"members": [expert.trainer for expert in experts]})
    pasts = zip(*(expert.history for expert in experts), strict=True)
    run.history = tuple(mean_result(results, counts) for results in pasts)
    trainer.done = len(run.history)
    run.seconds += sum(expert.seconds for expert in experts)
