"""Training by gradients: raise the evidence lower bound over batches of windows, epoch by epoch.

Every random draw of an epoch follows from the seed and the epoch's number, so a training that resumes after any epoch
goes on exactly as if it had never stopped.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import cos, pi
from typing import Any

import numpy as np
import torch

from fe_models.arrays import FloatArray
from hybrid.config import TrainingConfig
from hybrid.neural_modal_ode.driving import Driving
from hybrid.neural_modal_ode.model import NeuralModalODE
from hybrid.training.config import GRADIENT
from hybrid.training.elbo import Elbo


class TrainingDivergedError(RuntimeError):
    """The loss is no longer a number. The message says what to change."""


@dataclass(frozen=True)
class EpochResult:
    """What one epoch did: its number from 1, the mean ``loss`` a window (nats) and a window's ``horizon`` (samples)."""

    epoch: int
    loss: float
    horizon: int


def horizon_of(config: TrainingConfig, epoch: int, length: int) -> int:
    """Return the samples forecast in an epoch (from 1): grows geometrically, whole after half of the epochs.

    A long forecast has useful gradients only once a short one is right.
    """
    progress = min((epoch - 1) / max(config.epochs / 2, 1), 1.0)
    first = min(config.first_horizon, length)
    return round(first * (length / first) ** progress)


def learning_rate_of(config: TrainingConfig, epoch: int) -> float:
    """Return the learning rate of an epoch (from 1), along a cosine."""
    progress = (epoch - 1) / max(config.epochs - 1, 1)
    return config.learning_rate * (
        GRADIENT.last_learning_rate_share + (1 - GRADIENT.last_learning_rate_share) * (1 + cos(pi * progress)) / 2
    )


class Trainer:
    """A model, its optimiser and its windows; `epochs` trains on from wherever these stand."""

    def __init__(
        self,
        model: NeuralModalODE,
        windows: FloatArray,
        config: TrainingConfig,
        device: str = "cpu",
        driving: Driving | None = None,
    ) -> None:
        self.model = model.to(device)
        self.config = config
        self.device = device
        self.windows = torch.tensor(windows, dtype=torch.get_default_dtype(), device=device)  # (window, time, sensor)
        self.driving = None if driving is None else driving.to(self.windows)
        self.objective = Elbo(self.model, self.windows, config, self.driving)
        self.optimiser = torch.optim.Adam(model.parameters(), lr=config.learning_rate)
        self.done = 0

    def state(self) -> dict[str, Any]:
        """Return where the training stands, besides the model: the state of the optimiser."""
        return self.optimiser.state_dict()

    def load_state(self, state: dict[str, Any]) -> None:
        """Go on from there."""
        self.optimiser.load_state_dict(state)

    @property
    def finished(self) -> bool:
        """Whether all epochs are done."""
        return self.done >= self.config.epochs

    def epochs(self) -> Iterator[EpochResult]:
        """Train one epoch at each step of the iteration, until `TrainingConfig.epochs` are done."""
        while not self.finished:
            yield self.train_epoch(self.done + 1)

    def batches(self, epoch: int) -> list[np.ndarray]:
        """Return the window numbers of each batch of an epoch, shuffled."""
        order = np.random.default_rng([self.config.seed, epoch]).permutation(len(self.windows))
        return np.array_split(order, max(len(order) // self.config.batch, 1))

    def train_epoch(self, epoch: int) -> EpochResult:
        """Train one epoch (from 1); `TrainingDivergedError` where a loss or a forecast is no number."""
        generator = torch.Generator().manual_seed(
            int(np.random.SeedSequence([self.config.seed, epoch]).generate_state(1)[0])
        )
        horizon = horizon_of(self.config, epoch, self.windows.shape[1])
        for group in self.optimiser.param_groups:
            group["lr"] = learning_rate_of(self.config, epoch)
        total = 0.0
        for batch in self.batches(epoch):
            losses = self.objective(self.model, self.windows, torch.as_tensor(batch), horizon, generator)
            self.optimiser.zero_grad()
            (losses.mean() / horizon).backward()
            norm = torch.nn.utils.clip_grad_norm_(self.model.parameters(), GRADIENT.max_gradient_norm)
            if not torch.isfinite(norm):
                raise self._diverged(epoch, horizon)
            self.optimiser.step()
            total += float(losses.detach().sum())
        if epoch == self.config.epochs and not self._gives_numbers():
            raise self._diverged(epoch, horizon)
        self.done = epoch
        return EpochResult(epoch, total / len(self.windows), horizon)

    @torch.no_grad()
    def _gives_numbers(self) -> bool:
        """Return whether forecasts are finite: no gradient looks at the model after its very last step."""
        driving = None if self.driving is None else self.driving[: self.config.batch]
        mean, _ = self.model.encode(self.windows[: self.config.batch], driving)
        return bool(torch.isfinite(self.model.forecast(mean, self.windows.shape[1], driving).channels).all())

    def _diverged(self, epoch: int, horizon: int) -> TrainingDivergedError:
        return TrainingDivergedError(
            f"The training diverged in epoch {epoch} (learning rate {learning_rate_of(self.config, epoch):.1e},"
            f" forecasts of {horizon} samples). Start again with --fresh and a smaller --learning-rate or"
            " --first-horizon."
        )
