"""Datasets as one TOML file beside its recordings. Units SI, frequencies in Hz.

::

    schema = 1
    model = "frame.toml"          # "four_dof", "bridge", or a structure (.toml) or matrices (.npz, .toml)
    sampling_rate = 100.0         # of every recording that does not state its own
    lowpass = 30.0                # optional: the recordings hold nothing above it

    [[sensors]]                   # one a column of the recordings, in their order
    name = "A1"
    node = 5                      # from 1
    direction = "y"               # "x", "y", "rz", degrees from x towards y, or a vector [dx, dy]
    quantity = "acceleration"     # "displacement", "velocity" or "acceleration"
    unit = "m/s^2"                # SI, or "1" for a normalised channel
    role = "measured"             # "measured" (default) or "held_out": never fitted, only scored
    reference = "absolute"        # "absolute" (default), or "base": relative to a base that moves

    [[recordings]]
    name = "r1"
    file = "r1.npz"               # .npz, .npy, .mat: (time, sensor), or (recording, time, sensor) for many alike;
                                  # .csv, .txt, .uff, .tdms: columns with the sensors' names
    key = "data"                  # the array's name, for .npz and .mat
    role = "train"                # "train" (default) or "test"
    sampling_rate = 200.0         # optional: this recording's own
    excitation = "measured"       # "free", "measured" (loads are named) or "ambient" (unknown, broadband)
    loads = [{ node = 19, direction = "y", file = "load.npz", key = "force" }]   # optional, N, one value a sample;
                                  # of a .csv, also the recording's own, ``key`` is the column
    base = [{ direction = "x", file = "quake.csv", key = "acceleration", unit = "m/s^2" }]   # optional: acceleration of
                                  # all supports together; direction as "x", "y", degrees or [dx, dy]; unit also "g"

    [[modes]]                     # modes that somebody identified, beside recordings or instead: see `mode_tables`;
    recording = "before"          # of these alone no ``sampling_rate`` is needed
    frequency = 3.866             # Hz
    shape = [0.19, 1.0]           # at the sensors

    [simulation]                  # what the user's own simulation assumes; every key is optional
    damping_ratio = 0.01          # one, or one a mode: in place of the structure's own damping, but for its effects'
    modes = 4
    modal_model = "modal.npz"     # instead of the structure's own: omega (rad/s), xi, phi (dof, mode)
    integrator = "exact"          # "exact" (default) or "newmark"
    step = 0.01                   # s
    uncertainty = { stiffness = 0.01, mass = 0.01, damping = 0.1 }   # relative standard deviations (the defaults)
    tolerance = 0.05              # by how much of the noise floor forecasts may exceed it
"""

from dataclasses import replace
from math import isfinite
from pathlib import Path
from typing import Any

from fe_models.dofs import structure_dofs
from fe_models.errors import InputError, noting, raise_faults
from fe_models.files.atomic import write_npz, write_text
from fe_models.files.dataset_parts import (
    HEADER_KEYS,
    DatasetHeader,
    Surroundings,
    read_assumptions,
    read_header,
    read_sensors,
)
from fe_models.files.matrices_file import save_linear_model
from fe_models.files.modal_file import save_modal_model
from fe_models.files.mode_tables import check_states, mode_row, read_modes
from fe_models.files.models import load_model
from fe_models.files.recording_checks import check_rates
from fe_models.files.recording_parts import read_recordings
from fe_models.files.result_set import ResultSet, finish_exchanges
from fe_models.files.shared_samples import shared_stretches
from fe_models.files.structure_file import save_structure
from fe_models.files.tables import Table, at, check_keys, read_toml
from fe_models.files.toml_text import toml_text
from fe_models.files.unsaid import unsaid_faults, unsaid_notes
from fe_models.linear import LinearModel
from fe_models.recordings import TOLERANCE, Assumptions, Dataset, Recording, Sensor, Uncertainty
from fe_models.structure import Structure

DRAWING = "sensors.png"  # of the structure with its sensors, which commands leave beside a dataset


def load_dataset(path: str | Path, dead_channels: bool = False) -> Dataset:
    """Read a dataset with its model and all its recordings; `InputError` carries all faults.

    ``dead_channels``: channels that never change are read, too, for callers who can do without them.
    """
    path = Path(path)
    finish_exchanges(path.parent)
    document, where, faults = read_toml(path), f"{path.name}:", list[str]()
    check_keys(document, [*HEADER_KEYS, "simulation", "sensors", "recordings", "modes"], where, faults)
    header = read_header(document, where, faults)
    spec = document.get("model")
    model = noting(faults, at(where, "model"), load_model, spec, path.parent) if isinstance(spec, str) else None
    surroundings = replace(_surroundings(model, header, path.parent), dead_channels=dead_channels)
    sensors, channels = read_sensors(document, where, surroundings, faults)
    read = read_recordings(document, where, surroundings, channels, faults)
    modes = read_modes(document, where, list(channels.names), faults)
    check_states(modes, read.recordings, where, faults)
    assumptions = read_assumptions(document, where, surroundings, faults)
    if header is None or model is None:
        raise InputError(faults)
    faults += [f"{where} {fault}" for fault in shared_stretches(read.recordings)]
    raise_faults(faults)
    rate, lowpass = header.sampling_rate, header.lowpass
    dataset = Dataset(model, rate, sensors, read.recordings, lowpass, assumptions, read.notes, modes)
    return _with_note_on_rates(dataset.of_highest_rate())


def _with_note_on_rates(dataset: Dataset) -> Dataset:
    """Return the dataset with what a user should know where its recordings have different rates."""
    if len(dataset.sampling_rates) < 2:
        return dataset
    rates = " and ".join(f"{rate:g}" for rate in dataset.sampling_rates)
    note = f"recordings were sampled at {rates} Hz: what needs one rate takes the lowest, below a stated lowpass"
    return replace(dataset, notes=(*dataset.notes, note))


def dataset_in(folder: Path, writer: str = "simulate") -> ResultSet:
    """Return what `write_dataset` leaves in ``folder`` for a ``writer``, and a drawing of the sensors.

    No name is one that a built model has, so that both may stand in one folder.
    """
    names = ("dataset.toml", "model.toml", "matrices.npz", "modal.npz", "recording_[0-9]*.npz", DRAWING)
    return ResultSet(folder, writer, names)


def save_dataset(dataset: Dataset, folder: str | Path, model_spec: str | None = None) -> Path:
    """Save a dataset as ``dataset.toml`` and what it needs in ``folder``; return its path, for `load_dataset`.

    ``model_spec`` names the model ("bridge", "frame.toml"); without it the model is saved beside the dataset. A dataset
    saved there before is replaced as a whole, or stays as it was. `InputError` where another file is in the way, or
    where a file has no words for what the dataset knows (`unsaid_faults`).
    """
    results = dataset_in(Path(folder), "save_dataset")
    results.check()
    with results.replacing() as new:
        path = write_dataset(dataset, new, model_spec)
    return results.folder / path.name


def write_dataset(dataset: Dataset, folder: Path, model_spec: str | None = None) -> Path:
    """Write the files of `save_dataset` into a new ``folder``, to be exchanged as a set; return that of the dataset.

    `InputError` where the files could not say what the dataset knows (`unsaid_faults`).
    """
    raise_faults(unsaid_faults(dataset))
    if model_spec is None:
        model_spec = _save_model(dataset.model, folder)
    document: Table = {"schema": 1, "model": model_spec}
    if isfinite(dataset.sampling_rate):
        document["sampling_rate"] = float(dataset.sampling_rate)
    if dataset.lowpass is not None:
        document["lowpass"] = float(dataset.lowpass)
    document["sensors"] = [_sensor_table(sensor) for sensor in dataset.sensors]
    document["recordings"] = [
        _save_recording(recording, folder, f"recording_{number}")
        for number, recording in enumerate(dataset.recordings, start=1)
    ]
    if dataset.modes:
        document["modes"] = [mode_row(mode) for mode in dataset.modes]
    simulation = _save_assumptions(dataset.assumptions, folder)
    if simulation:
        document["simulation"] = simulation
    path = folder / "dataset.toml"
    write_text(path, "".join(f"# {note}\n" for note in unsaid_notes(dataset)) + toml_text(document))
    return path


def _surroundings(model: Structure | LinearModel | None, header: DatasetHeader | None, folder: Path) -> Surroundings:
    dofs, node_count = None, 0
    if isinstance(model, Structure):
        dofs, node_count = structure_dofs(model), len(model.nodes)
    elif model is not None:
        dofs, node_count = model.dofs, len(model.coordinates)
    rate = header.sampling_rate if header and header.sampling_rate > 0 else None
    sound = header is not None and not check_rates(header.sampling_rate, header.lowpass)
    return Surroundings(folder, dofs, node_count, rate, header.lowpass if header and sound else None)


def _save_model(model: Structure | LinearModel, folder: Path) -> str:
    if isinstance(model, Structure):
        save_structure(model, folder / "model.toml")
        return "model.toml"
    save_linear_model(model, folder / "matrices.npz")
    return "matrices.npz"


def _sensor_table(sensor: Sensor) -> Table:
    """Return the table of a sensor, without a reference that is the usual one."""
    table = {key: value for key, value in vars(sensor).items() if (key, value) != ("reference", "absolute")}
    return table | ({"direction": list(sensor.direction)} if isinstance(sensor.direction, tuple) else {})


def _save_recording(recording: Recording, folder: Path, stem: str) -> Table:
    """Write the arrays of one recording and return its table."""
    alone = len(recording.data) == 1
    arrays = {"data": recording.data[0] if alone else recording.data}
    row: Table = {"name": recording.name, "file": f"{stem}.npz", "key": "data", "role": recording.role}
    if recording.sampling_rate is not None:
        row["sampling_rate"] = float(recording.sampling_rate)
    if recording.excitation is not None:
        row["excitation"] = recording.excitation
    for number, load in enumerate(recording.loads, start=1):
        key = f"force_{number}"
        arrays[key] = load.values
        table = {"node": int(load.node), "direction": load.direction, "file": row["file"], "key": key}
        row.setdefault("loads", []).append(table)
    for number, motion in enumerate(recording.base, start=1):
        key = f"base_{number}"
        arrays[key] = motion.values
        along = list(motion.direction) if isinstance(motion.direction, tuple) else motion.direction
        row.setdefault("base", []).append({"direction": along, "file": row["file"], "key": key})
    write_npz(folder / row["file"], arrays)
    return row


def _save_assumptions(assumptions: Assumptions, folder: Path) -> Table:
    """Return the table of what differs from the defaults; a modal model goes into a file of its own."""
    table: Table = {}
    for key in ("damping_ratio", "modes", "step"):
        value: Any = getattr(assumptions, key)
        if value is not None:
            table[key] = list(value) if isinstance(value, tuple) else value
    if assumptions.modal_model is not None:
        save_modal_model(assumptions.modal_model, folder / "modal.npz")
        table["modal_model"] = "modal.npz"
    if assumptions.integrator != "exact":
        table["integrator"] = assumptions.integrator
    if assumptions.tolerance != TOLERANCE:
        table["tolerance"] = assumptions.tolerance
    if assumptions.uncertainty != Uncertainty():
        table["uncertainty"] = vars(assumptions.uncertainty)
    return table
