"""Training of experts: each model on the windows of its own recording, an epoch of all of them at a time."""

from collections.abc import Iterator, Sequence
from typing import Any

import torch

from fe_models.arrays import FloatArray
from hybrid.config import TrainingConfig
from hybrid.estimation.experts import Experts
from hybrid.training.gradient_training import EpochResult, Trainer


class ExpertsTrainer:
    """A `Trainer` for each member; ``windows`` are those of all members, one's after the other's."""

    def __init__(self, model: Experts, windows: FloatArray, config: TrainingConfig, device: str = "cpu") -> None:
        self.model = model.to(device)
        self.config = config
        self.windows = torch.tensor(windows)
        counts = model.counts.tolist()
        parts = self.windows.split(counts)
        self.trainers = [
            Trainer(member, part.numpy(), config, device) for member, part in zip(model.members, parts, strict=True)
        ]
        self.done = 0

    def state(self) -> dict[str, Any]:
        """Return where the training stands, besides the model."""
        return {"members": [trainer.state() for trainer in self.trainers]}

    def load_state(self, state: dict[str, Any]) -> None:
        """Go on from there."""
        for trainer, its_state in zip(self.trainers, state["members"], strict=True):
            trainer.load_state(its_state)

    @property
    def finished(self) -> bool:
        """Whether all epochs are done."""
        return self.done >= self.config.epochs

    def epochs(self) -> Iterator[EpochResult]:
        """Train every member one epoch at each step of the iteration, until all are done."""
        while not self.finished:
            yield self.train_epoch(self.done + 1)

    def train_epoch(self, epoch: int) -> EpochResult:
        """Train one epoch (from 1) of every member; the loss is the mean over all windows."""
        results = [trainer.train_epoch(epoch) for trainer in self.trainers]
        self.done = epoch
        return mean_result(results, [len(trainer.windows) for trainer in self.trainers])


def mean_result(results: Sequence[EpochResult], counts: Sequence[int]) -> EpochResult:
    """Return what the same epoch of several trainings did, the loss the mean over the ``counts`` of their windows."""
    total = sum(result.loss * count for result, count in zip(results, counts, strict=True))
    return EpochResult(results[0].epoch, total / sum(counts), results[0].horizon)
