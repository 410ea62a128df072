"""Checkpoints: one file with everything a trained, or half-trained, model needs; loading it runs no code from it."""

import json
from dataclasses import asdict, dataclass
from io import BytesIO
from pathlib import Path
from secrets import token_hex
from typing import Any

import numpy as np
import torch

from fe_models.directions import components
from fe_models.dof_map import DofMap
from fe_models.dofs import structure_dofs
from fe_models.errors import InputError, noting
from fe_models.files.atomic import writing
from fe_models.files.result_set import finish_exchanges
from fe_models.files.run_folder import Run
from fe_models.files.structure_file import structure_from_text, structure_text
from fe_models.files.tables import read_table
from fe_models.linear import ModalModel
from fe_models.recordings import Sensor
from fe_models.structure import Structure
from hybrid.config import Config, ModelConfig, TrainingConfig
from hybrid.estimation.experts import Hybrid
from hybrid.neural_modal_ode.connectors import Connectors
from hybrid.training.checkpoint_content import (
    FORMAT,
    Content,
    content_digest,
    damaged,
    is_archive,
    raw_content,
    read_content,
)
from hybrid.training.checkpoint_model import rebuilt, state_faults
from hybrid.training.gradient_training import EpochResult
from hybrid.training.origin import Origin


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
    whole = BytesIO()  # not the file itself: PyTorch has errors of its own where a disk is full
    torch.save(content | {"digest": content_digest(content)}, whole)
    with writing(path) as temporary:
        temporary.write_bytes(whole.getvalue())


def load_checkpoint(path: Path) -> Checkpoint:
    """Read a checkpoint, its model on the CPU; `InputError` where the file is none, another version's, or damaged."""
    finish_exchanges(path.parent)
    content, faults = read_content(path), list[str]()
    config, origin = _config(content.config, faults), _origin(content, faults)
    epochs = [read_table(EpochResult, row, f"history[{n}]", faults) for n, row in enumerate(content.history, start=1)]
    history = tuple(epoch for epoch in epochs if epoch is not None)
    if faults or config is None or origin is None:
        raise damaged(path, faults)
    model = noting(faults, "model", rebuilt, config.model, origin, content.model)
    faults += [] if model is None else state_faults(model, content.trainer)
    if faults or model is None:
        raise damaged(path, faults)
    return Checkpoint(config, origin, model, content.trainer, history, content.seconds)


def require_together(checkpoint: Checkpoint, run: Run, folder: Path) -> None:
    """Raise `InputError` where the model that a ``run`` left in ``folder`` is not that of its checkpoint."""
    structure = run.model if isinstance(run.model, Structure) else None
    origin = checkpoint.origin
    one, other = run.modes.frequencies, origin.modal.frequencies
    same_modes = one.shape == other.shape and np.allclose(one, other)
    if structure != origin.structure or not same_modes:
        raise InputError(
            f"{folder}: its model is not the one in its checkpoint, one of them was exchanged;"
            " give a folder as 'hybrid-modal train' wrote it"
        )


def require_own(path: Path) -> Path | None:
    """Raise `InputError` where ``path`` is a file, but not the state of a training, of this version or another.

    One that is damaged is moved aside, and where it is now is returned: it is not gone on with, and nobody loses what
    may be left of it.
    """
    if not path.exists():
        return None
    try:
        content = raw_content(path)
    except InputError:
        if not is_archive(path):
            raise
        return path.replace(path.with_stem(f"{path.stem}-damaged-{token_hex(4)}"))
    if not {"config", "model", "trainer"} <= content.keys():
        raise InputError(f"{path}: was not written by this program and would be replaced; give another folder")
    return None


def _config(text: str, faults: list[str]) -> Config | None:
    """Return the configuration in a JSON text."""
    try:
        raw = json.loads(text)
    except (ValueError, RecursionError):
        faults.append("config: is no JSON")
        return None
    if not isinstance(raw, dict) or raw.keys() != {"model", "training"}:
        faults.append("config: expected a table with model and training")
        return None
    model = read_table(ModelConfig, raw["model"], "config.model", faults)
    training = read_table(TrainingConfig, raw["training"], "config.training", faults)
    return None if model is None or training is None else Config(model, training)


def _origin(content: Content, faults: list[str]) -> Origin | None:
    """Return what the model was made from, its parts checked against each other."""
    modal, known = content.modal, len(faults)
    structure = noting(faults, "", structure_from_text, content.structure, "structure") if content.structure else None
    sensors = [read_table(Sensor, row, f"sensors[{n}]", faults) for n, row in enumerate(content.sensors, start=1)]
    if len(modal.dof_direction) != len(modal.dof_node):
        faults.append(f"modal: {len(modal.dof_direction)} directions of {len(modal.dof_node)} degrees of freedom")
    if len(faults) > known:
        return None
    dofs = DofMap(modal.dof_node.numpy(), np.array(modal.dof_direction), modal.dof_free.numpy())
    read = tuple(sensor for sensor in sensors if sensor is not None)
    if structure is not None and not _same_dofs(structure_dofs(structure), dofs):
        faults.append("modal: its degrees of freedom are not those of the structure")
    faults += [f"sensor {sensor.name!r}: {fault}" for sensor in read for fault in _place_faults(sensor, dofs)]
    if not any(sensor.role == "measured" for sensor in read):
        faults.append("sensors: none is measured")
    places = content.connectors
    if places is not None and len(places.names) != len(places.shapes):
        faults.append(f"connectors: {len(places.names)} names of {len(places.shapes)} places")
    return Origin(
        structure=structure,
        modal=ModalModel(modal.omega.numpy(), modal.damping_ratio.numpy(), modal.shapes.numpy(), dofs),
        sensors=read,
        sampling_rate=content.sampling_rate,
        lowpass=content.lowpass,
        kept=tuple(content.kept),
        left_out=tuple(content.left_out),
        unexplained=content.unexplained,
        data_digest=content.data_digest,
        connectors=None
        if places is None
        else Connectors(tuple(places.names), places.shapes.numpy(), places.feeds.numpy()),
    )


def _same_dofs(one: DofMap, other: DofMap) -> bool:
    return all(np.array_equal(getattr(one, part), getattr(other, part)) for part in ("node", "direction", "free"))


def _place_faults(sensor: Sensor, dofs: DofMap) -> list[str]:
    """Return a fault where the model has no degree of freedom that a sensor shows."""
    faults = list[str]()
    axes = noting(faults, "", components, sensor.direction) or {}
    known = set(zip(dofs.node.tolist(), dofs.direction.tolist(), strict=True))
    missing = [axis for axis in axes if (sensor.node, axis) not in known]
    return faults + [f"the model has no node {sensor.node} that moves in {axis}" for axis in missing]


def _connector_table(connectors: Connectors | None) -> dict[str, Any] | None:
    if connectors is None:
        return None
    arrays = {"shapes": torch.tensor(connectors.shapes), "feeds": torch.tensor(connectors.feeds)}
    return {"names": list(connectors.names), **arrays}
