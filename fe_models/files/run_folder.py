"""What a run leaves in its folder for the pictures: the model, its modes, and, after a training, a prediction.

``model.npz`` holds the model: ``structure``, the text of its structure file, or "" where the model is the matrices in
the same file; and ``frequencies`` (mode,), Hz, ``damping_ratio`` (mode,) and ``mode_shapes`` (dof, mode) over all
degrees of freedom, supports included. Files of earlier versions, without ``structure``, have it in ``structure.toml``
beside them. ``prediction.npz`` holds, of the first test window, ``time`` (time,), ``hybrid`` and ``fe`` (time, dof),
``truth`` (time, dof) where the data are simulated, ``fe_initial`` (dof,) where it is not the first of ``fe``,
``damping_ratio`` (mode,), ``unit`` ("m", or "1" for relative displacements) and the sensors: ``sensor_name``,
``sensor_node``, ``sensor_direction``, ``sensor_role``.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fe_models.arrays import FloatArray
from fe_models.damping import ratios_of_modes, replace_ratios
from fe_models.directions import direction_of_text, direction_text
from fe_models.dof_map import DofMap
from fe_models.dofs import dofs_of
from fe_models.errors import InputError, raise_faults
from fe_models.files.array_files import load_arrays
from fe_models.files.atomic import write_npz
from fe_models.files.matrices_file import load_linear_model, save_linear_model
from fe_models.files.result_set import finish_exchanges
from fe_models.files.structure_file import load_structure, structure_from_text, structure_text
from fe_models.linear import LinearModel, ModalModel
from fe_models.recordings import Sensor
from fe_models.structure import Structure

MODEL = "model.npz"
PREDICTION = "prediction.npz"

Arrays = dict[str, NDArray[np.generic]]


@dataclass(frozen=True)
class Prediction:
    """Displacements (time, dof) of one window by the hybrid model, the FE model and, in simulations, the truth."""

    time: FloatArray
    hybrid: FloatArray
    fe: FloatArray
    fe_initial: FloatArray
    truth: FloatArray | None
    unit: str
    sensors: tuple[Sensor, ...]


@dataclass(frozen=True)
class Run:
    """Content of a folder; ``prediction`` is None where nothing was trained."""

    model: Structure | LinearModel
    modes: ModalModel
    prediction: Prediction | None


def run_files(folder: Path) -> tuple[Path, ...]:
    """Return the files of ``folder`` that `load_run` reads, as far as they are there."""
    return tuple(folder / name for name in (MODEL, PREDICTION, "structure.toml"))


def load_run(folder: Path) -> Run:
    """Read the folder of a run; `InputError` carries all that is missing or does not fit."""
    finish_exchanges(folder)
    if not folder.is_dir():
        raise InputError(f"{folder}: no such folder; give one that 'hybrid-modal build' or 'train' wrote")
    file = folder / MODEL
    if not file.is_file():
        raise InputError(f"{file}: no such file; give a folder that 'hybrid-modal build' or 'train' wrote")
    arrays = load_arrays(file)
    model = _model(arrays, file)
    dofs = dofs_of(model)
    faults: list[str] = []
    frequencies = _numbers(arrays, "frequencies", (None,), str(file), faults)
    shapes = _numbers(arrays, "mode_shapes", (len(dofs), len(frequencies)), str(file), faults)
    path = folder / PREDICTION
    predicted = load_arrays(path) if path.is_file() else {}
    prediction = _prediction(predicted, dofs, str(path), faults) if predicted else None
    given = predicted if "damping_ratio" in predicted else arrays
    ratios = np.zeros(len(frequencies))
    if "damping_ratio" in given:
        ratios = _numbers(given, "damping_ratio", (len(frequencies),), str(folder), faults)
    raise_faults(faults)
    omega = 2 * np.pi * frequencies
    if "damping_ratio" not in given:
        ratios = _own_ratios(load_linear_model(file), omega, shapes)
    return Run(model, ModalModel(omega, ratios, shapes, dofs), prediction)


def save_prediction(prediction: Prediction, folder: Path) -> None:
    """Write ``folder``/prediction.npz, as `load_run` reads it."""
    arrays = {
        "time": prediction.time,
        "hybrid": prediction.hybrid,
        "fe": prediction.fe,
        "fe_initial": prediction.fe_initial,
        "unit": np.array(prediction.unit),
        "sensor_name": np.array([sensor.name for sensor in prediction.sensors]),
        "sensor_node": np.array([sensor.node for sensor in prediction.sensors]),
        "sensor_direction": np.array([direction_text(sensor.direction) for sensor in prediction.sensors]),
        "sensor_role": np.array([sensor.role for sensor in prediction.sensors]),
    }
    write_npz(folder / PREDICTION, arrays if prediction.truth is None else {**arrays, "truth": prediction.truth})


def save_run_model(
    model: Structure | LinearModel, modes: ModalModel, folder: Path, linear: LinearModel | None = None
) -> None:
    """Write ``folder``/model.npz, the model and its modes, as `load_run` reads it, with the matrices of ``linear``."""
    structure = structure_text(model) if isinstance(model, Structure) else ""
    found: dict[str, ArrayLike] = {
        "frequencies": modes.frequencies,
        "damping_ratio": modes.damping_ratio,
        "mode_shapes": modes.shapes,
        "structure": np.array(structure),
    }
    matrices = linear or (None if isinstance(model, Structure) else model)
    if matrices is None:
        write_npz(folder / MODEL, found)
    else:
        save_linear_model(matrices, folder / MODEL, found)


def _model(arrays: Arrays, file: Path) -> Structure | LinearModel:
    beside = file.with_name("structure.toml")
    if "structure" not in arrays and beside.is_file():
        return load_structure(beside)
    text = str(arrays.get("structure", ""))
    return structure_from_text(text, str(file)) if text else load_linear_model(file)


def _prediction(arrays: Arrays, dofs: DofMap, where: str, faults: list[str]) -> Prediction:
    time = _numbers(arrays, "time", (None,), where, faults)
    series = (len(time), len(dofs))
    hybrid = _numbers(arrays, "hybrid", series, where, faults)
    fe = _numbers(arrays, "fe", series, where, faults)
    truth = _numbers(arrays, "truth", series, where, faults) if "truth" in arrays else None
    initial = _numbers(arrays, "fe_initial", (len(dofs),), where, faults) if "fe_initial" in arrays else fe[0]
    unit = str(arrays.get("unit", "m"))
    if unit not in ("m", "1"):
        faults.append(f'{where}: unit is {unit!r}; expected "m", or "1" for relative displacements')
    return Prediction(time, hybrid, fe, initial, truth, unit, _sensors(arrays, dofs, where, faults))


def _sensors(arrays: Arrays, dofs: DofMap, where: str, faults: list[str]) -> tuple[Sensor, ...]:
    """Return the sensors, as far as a picture shows them; none where the file names none."""
    if "sensor_name" not in arrays:
        return ()
    columns = [arrays.get(f"sensor_{part}", np.zeros(0)).tolist() for part in ("name", "node", "direction", "role")]
    if len({len(column) for column in columns}) > 1:
        faults.append(f"{where}: sensor_name, sensor_node, sensor_direction and sensor_role must be equally long")
        return ()
    found = []
    for name, node, direction, role in zip(*columns, strict=True):
        if node not in dofs.node:
            faults.append(f"{where}: sensor {name!r} sits at node {node}; the model has nodes 1 to {dofs.node.max()}")
        found.append(Sensor(str(name), int(node), direction_of_text(direction), "displacement", "m", role))
    return tuple(found)


def _numbers(arrays: Arrays, name: str, shape: tuple[int | None, ...], where: str, faults: list[str]) -> FloatArray:
    """Return finite numbers of that ``shape`` (None: any length but 0); else note a fault and return zeros."""
    stand_in = np.zeros([length or 1 for length in shape])
    expected = "(" + ", ".join("any" if length is None else str(length) for length in shape) + ")"
    if name not in arrays:
        faults.append(f"{where}: holds no array {name!r}; expected one of shape {expected}; run the program again")
        return stand_in
    array = arrays[name]
    fits = array.ndim == len(shape) and all(
        length > 0 and wanted in (None, length) for length, wanted in zip(array.shape, shape, strict=True)
    )
    if not fits or array.dtype.kind not in "iuf":
        faults.append(
            f"{where}: {name!r} is {array.dtype} of shape {array.shape}; expected numbers of shape {expected}"
        )
        return stand_in
    if not np.isfinite(array).all():
        faults.append(f"{where}: {name!r} holds values that are not finite; run the program again")
        return stand_in
    return array.astype(float)


def _own_ratios(model: LinearModel, omega: FloatArray, shapes: FloatArray) -> FloatArray:
    """Return the model's own damping ratios (mode,): xi = phi^T C phi / (2 omega), plus its modal ones."""
    free = shapes[model.dofs.free]
    ratios: FloatArray = np.einsum("di,di->i", free, model.damping @ free) / (2 * omega)
    return replace_ratios(ratios + ratios_of_modes(model.modal_ratios, len(omega)), model.replaced_ratios)
