"""A training run in a folder: start or resume it, checkpoint every epoch, and finish it.

While a training is under way its state is in ``training.pt``; older results stay whole until it is done. Only when all
new results are written is that file removed: a run that is cut short before is resumed, and writes them again.
"""

import hashlib
import json
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch

from fe_models.arrays import FloatArray
from fe_models.errors import InputError
from fe_models.files.result_set import ResultSet
from fe_models.files.run_folder import MODEL, PREDICTION
from fe_models.nominal import nominal_modes
from fe_models.progress import nothing
from fe_models.recordings import Dataset
from fe_models.structure import Structure
from hybrid.config import Config
from hybrid.estimation.experts import Experts
from hybrid.estimation.windows import cut_all, cut_driving, window_length
from hybrid.known_loads.modal_input import modal_input
from hybrid.neural_modal_ode.driving import Driving
from hybrid.neural_modal_ode.model import NeuralModalODE
from hybrid.result_sets import PAGE
from hybrid.training.checkpoint import Checkpoint, load_checkpoint, require_own, save_checkpoint
from hybrid.training.expert_preparation import prepare_experts
from hybrid.training.gradient_training import EpochResult
from hybrid.training.origin import Origin
from hybrid.training.preparation import Prepared, prepare
from hybrid.training.trainable import trainable
from hybrid.training.trainers import AnyTrainer, trainer_for

PARTIAL_CHECKPOINT = "training.pt"
CHECKPOINT = "checkpoint.pt"
METRICS = "metrics.json"
LOOP = "force_displacement.png"
CURVES = ("training.png", "channels.png", "latent.png", "displacement.png", LOOP)


def metrics_in(folder: Path) -> dict[str, Any]:
    """Return the scores that a training left in ``folder``; empty where there are none."""
    metrics = folder / METRICS
    if not metrics.is_file():
        return {}
    try:
        return dict(json.loads(metrics.read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError, RecursionError):
        raise InputError(f"{metrics}: cannot be read as scores; train again, or remove it") from None


@dataclass
class Run:
    """A trainer with its origin and its past; the one mutable thing here, as training is.

    ``moved``: where a damaged state that was in the way is now; None where there was none.
    """

    folder: Path
    config: Config
    origin: Origin
    trainer: AnyTrainer
    history: tuple[EpochResult, ...] = ()
    seconds: float = 0.0
    moved: Path | None = None

    def epochs(self) -> Iterator[EpochResult]:
        """Train on, one epoch at each step of the iteration; each is in the checkpoint before it is yielded."""
        started, before = time.perf_counter(), self.seconds
        for result in self.trainer.epochs():
            self.history += (result,)
            self.seconds = before + time.perf_counter() - started
            save_checkpoint(self.checkpoint(), self.folder / PARTIAL_CHECKPOINT)
            yield result

    def checkpoint(self) -> Checkpoint:
        """Return the state as it is now."""
        trainer = self.trainer
        return Checkpoint(self.config, self.origin, trainer.model, trainer.state(), self.history, self.seconds)

    def finish(self) -> None:
        """Leave the trained model alone, without scores or curves."""
        with results_in(self.folder).replacing() as new:
            save_checkpoint(self.checkpoint(), new / CHECKPOINT)
        self.forget_state()

    def forget_state(self) -> None:
        """Remove the training's state: all its results are written."""
        (self.folder / PARTIAL_CHECKPOINT).unlink(missing_ok=True)


def results_in(folder: Path) -> ResultSet:
    """Return what a training leaves in ``folder``."""
    return ResultSet(folder, "train", (CHECKPOINT, METRICS, PAGE, MODEL, PREDICTION, *CURVES))


def begin(
    dataset: Dataset,
    config: Config,
    folder: Path,
    device: str = "cpu",
    advance: Callable[[], object] = nothing,
) -> Run:
    """Start a new training; `InputError` where dataset or ``folder`` do not allow one. ``advance``: see `prepare`."""
    dataset = trainable(dataset)
    results_in(folder).check()
    moved = require_own(folder / PARTIAL_CHECKPOINT)
    torch.set_num_threads(config.training.threads)
    started = time.perf_counter()
    prepared: Prepared[NeuralModalODE] | Prepared[Experts]
    prepared = (prepare_experts if config.model.experts else prepare)(dataset, config, advance)
    structure = dataset.model if isinstance(dataset.model, Structure) else None
    origin = Origin(
        structure=structure,
        modal=prepared.modal,
        sensors=dataset.sensors,
        sampling_rate=dataset.sampling_rate,
        kept=prepared.kept,
        left_out=prepared.left_out,
        unexplained=prepared.unexplained,
        data_digest=digest(prepared.windows, prepared.driving),
        connectors=prepared.connectors,
        lowpass=dataset.lowpass,
    )
    trainer = trainer_for(prepared.model, prepared.windows, config.training, device, prepared.driving)
    return Run(folder, config, origin, trainer, seconds=time.perf_counter() - started, moved=moved)


def resume(dataset: Dataset, config: Config, folder: Path, device: str = "cpu") -> Run:
    """Go on with the training that was interrupted in ``folder``, exactly as if it had not been.

    `InputError` where it was started with other settings or other data.
    """
    dataset = trainable(dataset)
    results_in(folder).check()
    torch.set_num_threads(config.training.threads)
    found = load_checkpoint(folder / PARTIAL_CHECKPOINT)
    windows, driving = _windows(dataset, config, found.origin)
    faults = []
    if found.config != config:
        faults.append(
            f"{folder / PARTIAL_CHECKPOINT} is an interrupted training with other settings:"
            f" {_differences(found, config)}"
        )
    if windows is None or digest(windows, driving) != found.origin.data_digest:
        faults.append(
            f"{folder / PARTIAL_CHECKPOINT} is an interrupted training on other recordings than the dataset's"
        )
    if not _made_from(found.origin, dataset, config):
        faults.append(
            f"{folder / PARTIAL_CHECKPOINT} is an interrupted training of another model, other sensors or another rate"
        )
    if faults:
        raise InputError([*faults, "give the same settings and data to go on with it, or --fresh to start anew"])
    known = windows if windows is not None else np.empty(0)
    trainer = trainer_for(found.model, known, config.training, device, driving)
    trainer.load_state(found.trainer)
    trainer.done = len(found.history)
    return Run(folder, config, found.origin, trainer, found.history, found.seconds)


def digest(windows: FloatArray, driving: Driving | None = None) -> str:
    """Return a fingerprint of training windows, and of what drives them."""
    found = hashlib.sha256(np.ascontiguousarray(windows).tobytes())
    for part in () if driving is None else (driving.courses[:, :, 0], driving.participation, driving.shown):
        found.update(part.contiguous().numpy().tobytes())
    return found.hexdigest()


def _made_from(origin: Origin, dataset: Dataset, config: Config) -> bool:
    """Return whether a training's model, modes, sensors and sampling rate are those of the dataset."""
    structure = dataset.model if isinstance(dataset.model, Structure) else None
    if (structure, dataset.sensors, dataset.sampling_rate) != (origin.structure, origin.sensors, origin.sampling_rate):
        return False
    now, then = nominal_modes(dataset, config.model.modes), origin.modal
    pairs = [(now.omega, then.omega), (now.damping_ratio, then.damping_ratio), (now.shapes, then.shapes)]
    return all(one.shape == other.shape and np.allclose(one, other) for one, other in pairs)


def _windows(dataset: Dataset, config: Config, origin: Origin) -> tuple[FloatArray | None, Driving | None]:
    """Return the training windows and what drives them; None where the recordings are not those of ``origin``."""
    recordings = {recording.name: recording for recording in dataset.select("train")}
    if recordings.keys() != {*origin.kept, *origin.left_out}:
        return None, None
    length, stride = window_length(dataset, config), config.training.stride
    kept = [recordings[name] for name in origin.kept]
    forces = modal_input(dataset, origin.modal, dataset.select("train"))
    return cut_all(kept, length, stride), cut_driving(forces, kept, length, stride)


def _differences(found: Checkpoint, config: Config) -> str:
    pairs = [(found.config.model, config.model), (found.config.training, config.training)]
    changes = [
        f"{name} was {value}, now {getattr(now, name)}"
        for was, now in pairs
        for name, value in vars(was).items()
        if getattr(now, name) != value
    ]
    return "; ".join(changes)
