"""Checkpoints: one file with everything a trained, or half-trained, model needs; loading it runs no code from it."""

import json
import pickle
import struct
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from fe_models.causes.laws import force_laws
from fe_models.dof_map import DofMap
from fe_models.errors import InputError
from fe_models.files.atomic import writing
from fe_models.files.result_set import finish_exchanges
from fe_models.files.structure_file import structure_from_text, structure_text
from fe_models.linear import ModalModel
from fe_models.recordings import Sensor
from fe_models.structure import Structure
from hybrid.config import Config, ModelConfig, TrainingConfig
from hybrid.estimation.experts import Experts, Hybrid
from hybrid.estimation.start_evidence import StartEvidence
from hybrid.neural_modal_ode.connectors import Connectors
from hybrid.neural_modal_ode.model import NeuralModalODE
from hybrid.neural_modal_ode.scaling import StateScale
from hybrid.training.gradient_training import EpochResult

FORMAT = 4
CONTENT = {
    "format", "config", "structure", "sensors", "modal", "sampling_rate", "kept",
    "left_out", "unexplained", "data_digest",
    "connectors", "model", "trainer", "history", "seconds",
}  # fmt: skip
READING_ERRORS = (pickle.UnpicklingError, RuntimeError, EOFError, OSError, LookupError, ValueError, struct.error)
"""What torch.load raises on other files, and on those that were cut short or damaged."""


@dataclass(frozen=True)
class Origin:
    """What a model was made from, besides its configuration.

    ``structure`` is None for a model of the user's own matrices. ``data_digest`` is that of the training windows;
    ``sampling_rate`` and ``lowpass`` (Hz) are those of the recordings.
    """

    structure: Structure | None
    modal: ModalModel
    sensors: tuple[Sensor, ...]
    sampling_rate: float
    kept: tuple[str, ...]
    left_out: tuple[str, ...]
    unexplained: float | None
    data_digest: str
    connectors: Connectors | None = None
    lowpass: float | None = None


@dataclass(frozen=True, repr=False)
class Checkpoint:
    """A model, where it came from, and where its training stands (``trainer``)."""

    config: Config
    origin: Origin
    model: Hybrid
    trainer: dict[str, Any]
    history: tuple[EpochResult, ...]
    seconds: float

    def __repr__(self) -> str:
        origin = self.origin
        return f"Checkpoint({len(origin.modal.omega)} modes, {len(origin.sensors)} sensors, {len(self.history)} epochs)"


def save_checkpoint(checkpoint: Checkpoint, path: Path) -> None:
    """Write the checkpoint whole; an older one stays until the new one is complete."""
    origin, modal = checkpoint.origin, checkpoint.origin.modal
    content = {
        "format": FORMAT,
        "config": json.dumps(asdict(checkpoint.config)),
        "structure": structure_text(origin.structure) if origin.structure else "",
        "sensors": [asdict(sensor) for sensor in origin.sensors],
        "modal": {
            "omega": torch.tensor(modal.omega),
            "damping_ratio": torch.tensor(modal.damping_ratio),
            "shapes": torch.tensor(modal.shapes),
            "dof_node": torch.tensor(modal.dofs.node),
            "dof_direction": [str(direction) for direction in modal.dofs.direction],
            "dof_free": torch.tensor(modal.dofs.free),
        },
        "sampling_rate": origin.sampling_rate,
        "lowpass": origin.lowpass,
        "kept": list(origin.kept),
        "left_out": list(origin.left_out),
        "unexplained": origin.unexplained,
        "data_digest": origin.data_digest,
        "model": checkpoint.model.state_dict(),
        "trainer": checkpoint.trainer,
        "connectors": _connector_table(origin.connectors),
        "history": [asdict(result) for result in checkpoint.history],
        "seconds": checkpoint.seconds,
    }
    with writing(path) as temporary:
        torch.save(content, temporary)


def load_checkpoint(path: Path) -> Checkpoint:
    """Read a checkpoint, its model on the CPU; `InputError` where the file is none or is another version's."""
    finish_exchanges(path.parent)
    content = _read(path)
    if content.get("format", FORMAT) != FORMAT:
        raise InputError(f"{path}: has checkpoint format {content['format']}, this program reads {FORMAT}; train again")
    missing = CONTENT - content.keys()
    if missing:
        raise InputError(f"{path}: is not a checkpoint of this program (without {', '.join(sorted(missing))})")
    raw = json.loads(content["config"])
    config = Config(ModelConfig(**raw["model"]), TrainingConfig(**raw["training"]))
    origin = _origin(content)
    model = rebuilt(config.model, origin, content["model"])
    history = tuple(EpochResult(**result) for result in content["history"])
    return Checkpoint(config, origin, model, content["trainer"], history, content["seconds"])


def require_own(path: Path) -> None:
    """Raise `InputError` where ``path`` is a file, but not the state of a training, of this version or another."""
    if path.exists() and not {"config", "model", "trainer"} <= _read(path).keys():
        raise InputError(f"{path}: was not written by this program and would be replaced; give another folder")


def rebuilt(config: ModelConfig, origin: Origin, weights: dict[str, Tensor]) -> Hybrid:
    """Return the model that has these ``weights``, its `state_dict`."""
    model: Hybrid
    if config.experts:
        counts = weights["counts"].tolist()
        members = [_blank(config, origin, _under(f"_members.{i}.", weights)) for i in range(len(counts))]
        evidence = [StartEvidence(weights[f"_evidence.{i}.root"]) for i in range(len(counts))]
        model = Experts(members, evidence, counts)
    else:
        model = _blank(config, origin, weights)
    model.load_state_dict(weights)
    return model


def _under(prefix: str, weights: dict[str, Tensor]) -> dict[str, Tensor]:
    return {name.removeprefix(prefix): value for name, value in weights.items() if name.startswith(prefix)}


def _blank(config: ModelConfig, origin: Origin, weights: dict[str, Tensor]) -> NeuralModalODE:
    """Return a model with the scales of ``weights``, the rest of which are yet to be loaded."""
    effects = force_laws(origin.structure) if origin.structure else ()
    scale = StateScale(weights["dynamics.a"].double().numpy(), weights["dynamics.b"].double().numpy())
    return NeuralModalODE(
        config,
        origin.modal,
        effects,
        origin.sensors,
        weights["channel_scale"],
        scale,
        1 / origin.sampling_rate,
        origin.connectors,
    )


def _read(path: Path) -> dict[str, Any]:
    """Return what the file holds; of tensors and plain containers only, whatever else is in it."""
    try:
        content = torch.load(path, map_location="cpu", weights_only=True)
    except FileNotFoundError:
        raise InputError(
            f"{path}: no such file; give the folder or checkpoint that 'hybrid-modal train' wrote"
        ) from None
    except READING_ERRORS as error:
        raise InputError(f"{path}: is not a checkpoint of this program ({type(error).__name__})") from error
    if not isinstance(content, dict):
        raise InputError(f"{path}: is not a checkpoint of this program (holds a {type(content).__name__})")
    return content


def _origin(content: dict[str, Any]) -> Origin:
    modal = content["modal"]
    dofs = DofMap(modal["dof_node"].numpy(), np.array(modal["dof_direction"]), modal["dof_free"].numpy())
    return Origin(
        structure=structure_from_text(content["structure"], "checkpoint") if content["structure"] else None,
        modal=ModalModel(modal["omega"].numpy(), modal["damping_ratio"].numpy(), modal["shapes"].numpy(), dofs),
        sensors=tuple(Sensor(**sensor) for sensor in content["sensors"]),
        sampling_rate=content["sampling_rate"],
        lowpass=content.get("lowpass"),  # models of before know of none
        kept=tuple(content["kept"]),
        left_out=tuple(content["left_out"]),
        unexplained=content["unexplained"],
        data_digest=content["data_digest"],
        connectors=_connectors(content["connectors"]),
    )


def _connector_table(connectors: Connectors | None) -> dict[str, Any] | None:
    if connectors is None:
        return None
    arrays = {"shapes": torch.tensor(connectors.shapes), "feeds": torch.tensor(connectors.feeds)}
    return {"names": list(connectors.names), **arrays}


def _connectors(table: dict[str, Any] | None) -> Connectors | None:
    if table is None:
        return None
    return Connectors(tuple(table["names"]), table["shapes"].numpy(), table["feeds"].numpy())
