"""What a notebook's functions are given: a dataset or its file, and, beside it, the design to hold it against."""

from pathlib import Path

from fe_models.dof_map import DofMap
from fe_models.dofs import structure_dofs
from fe_models.errors import InputError, raise_faults
from fe_models.files.dataset_file import load_dataset
from fe_models.files.models import load_model
from fe_models.files.recording_checks import check_sensor
from fe_models.linear import LinearModel
from fe_models.recordings import Dataset
from fe_models.structure import Structure

Design = Structure | LinearModel | str | Path
"""A model, or what names one: "bridge", "frame.toml"."""
Data = Dataset | str | Path
"""A dataset, or the path of its TOML file."""


def dataset_of(first: Design | Data, data: Data | None, dead_channels: bool = False) -> Dataset:
    """Return the dataset, read where it is a file, and with its ``first`` as the model where both are given.

    `InputError` with all faults, also where the sensors do not fit the design. ``dead_channels``: see `load_dataset`.
    """
    if data is None:
        if isinstance(first, Structure | LinearModel):
            raise InputError("a model alone has no recordings: give the dataset, too")
        return _read(first, dead_channels)
    if isinstance(first, Dataset):
        raise InputError("two datasets: give the design first, then the dataset; or one dataset alone")
    found = _read(data, dead_channels)
    model = load_model(str(first)) if isinstance(first, str | Path) else first
    dofs, nodes = _places(model)
    faults = (
        f"sensor {sensor.name!r}: {fault}" for sensor in found.sensors for fault in check_sensor(sensor, dofs, nodes)
    )
    raise_faults(faults)
    return found.with_model(model)


def _read(data: Data, dead_channels: bool) -> Dataset:
    return data if isinstance(data, Dataset) else load_dataset(data, dead_channels)


def _places(model: Structure | LinearModel) -> tuple[DofMap, int]:
    if isinstance(model, Structure):
        return structure_dofs(model), len(model.nodes)
    return model.dofs, len(model.coordinates)
