"""Simulated recordings as the options of a command describe them: parsed, checked all at once, then made."""

import sys
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Literal, TypeVar

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.base_motion import BaseDirection, BaseMotion, unit_vector
from fe_models.built_in.four_dof import four_dof
from fe_models.directions import direction_of_text
from fe_models.dofs import structure_dofs
from fe_models.errors import InputError, noting, raise_faults
from fe_models.files.bridge_recordings import bridge_sensors
from fe_models.files.known_motion import BASE_UNITS, SI_UNIT
from fe_models.files.modal_file import load_modal_model
from fe_models.files.recording_checks import UNITS
from fe_models.files.recording_files import load_force
from fe_models.files.size_limit import file_fault
from fe_models.four_dof_data import paper_dataset
from fe_models.modes import natural_modes
from fe_models.recordings import Dataset, Quantity, Sensor
from fe_models.simulation import FreeConfig, ReleaseConfig
from fe_models.simulation_size import length_faults
from fe_models.statics import STANDARD_GRAVITY, PointLoad
from fe_models.structure import ROTATIONS, TRANSLATIONS, Beam, Cable, Direction, Structure
from fe_models.synthetic import (
    OVERSAMPLING,
    Acquisition,
    check_driven,
    check_free,
    check_release,
    driven_dataset,
    free_dataset,
    release_dataset,
)
from fe_models.time_step import MAX_FREQUENCY_ERROR, TimeStep, free_step, time_step
from fe_models.usual_recordings import Kind
from fe_models.value_limits import number_fault
from hybrid.commands.models import NO_DAMPING
from hybrid.commands.recording_options import RecordingOptions

BRIDGE_PULLS = ("19:y:-9.81", "13:y:-9.81", "9:y:-9.81", "15:y:-9.81")
TOO_LONG = (
    "time step {step:.2g} s: the highest mode needs {needed:.2g} s or less, or a diagnosis may find the step's own "
    "error; leave --step out"
)
TOLERATED_ERROR = 1.01 * MAX_FREQUENCY_ERROR  # the step is chosen by the first term of the error's series
Role = Literal["measured", "held_out"]
Word = TypeVar("Word", bound=str)
Value = TypeVar("Value")
QUANTITIES: tuple[Quantity, ...] = ("displacement", "velocity", "acceleration")
DIRECTIONS: tuple[Direction, ...] = (*TRANSLATIONS, *ROTATIONS)
ROLES: tuple[Role, ...] = ("measured", "held_out")


def structure_recordings(model: str, subject: Structure, given: RecordingOptions, seed: int) -> Callable[[], Dataset]:
    """Check the options on recordings, all at once, and return the simulation that they ask for."""
    if model == "four_dof":
        return _paper_chain(given, seed)
    faults = given.useless("cubic_stiffness", because="is for four_dof; write effects into the structure file")
    faults += given.useless("modal_model", because="is for four_dof; name it in your dataset's [simulation] instead")
    sensors = sensors_of(given, faults)
    if model == "bridge" and not given.sensor:
        sensors = bridge_sensors(unit="m/s^2")
    elif not given.sensor:
        faults.append("recordings need sensors: give at least one --sensor NODE:DIRECTION, such as --sensor 2:x")
    if given.base:
        return _shaken(subject, sensors, given, np.random.default_rng(seed), faults)
    faults += base_faults(given)
    is_frame = any(isinstance(element, Beam | Cable) for element in subject.elements)
    make = _frame if is_frame else _chain
    return make(model, subject, sensors, given, np.random.default_rng(seed), faults)


def _paper_chain(given: RecordingOptions, seed: int) -> Callable[[], Dataset]:
    useless = (
        "pull",
        "base",
        "base_direction",
        "base_unit",
        "sensor",
        "duration",
        "step",
        "sampling_rate",
        "lowpass",
        "noise",
        "gravity",
    )
    because = (
        "four_dof gives the paper's data; for others run 'hybrid-modal build four_dof --out FOLDER', then simulate"
        " FOLDER/structure.toml"
    )
    raise_faults(given.useless(*useless, because=because))
    rng = np.random.RandomState(seed)  # the legacy generator of the paper's data
    modal = load_modal_model(given.modal_model, structure_dofs(four_dof())) if given.modal_model else None
    return partial(paper_dataset, given.cubic_stiffness or 0.0, modal, rng, given.realisations or 1000)


def _frame(
    model: str,
    structure: Structure,
    sensors: tuple[Sensor, ...],
    given: RecordingOptions,
    rng: np.random.Generator,
    faults: list[str],
) -> Callable[[], Dataset]:
    faults += given.useless("realisations", because="is for chains; a frame is pulled and released, repeat --pull")
    texts = given.pull or (BRIDGE_PULLS if model == "bridge" else ())
    releases = all_of(texts, loads_of_pull, faults)
    if not texts:
        faults.append("a frame needs something to let go: give --pull NODE:DIRECTION:FORCE, such as --pull 3:y:-10")
    acquisition = acquisition_of(given, Kind.RELEASED, faults)
    config = ReleaseConfig(
        duration=Kind.RELEASED.duration(given.duration),
        sampling_rate=OVERSAMPLING * acquisition.sampling_rate,
        step=given.step,
        gravity=STANDARD_GRAVITY if given.gravity is None else given.gravity,
    )
    raise_faults(faults + check_release(structure, releases, sensors, acquisition))
    raise_faults(length_faults(config.duration, config.sampling_rate, config.step))

    def simulated() -> Dataset:
        step = time_step(structure, acquisition.band, given.step)
        if not natural_modes(linearise(structure), 1).damping_ratio.any():
            print(NO_DAMPING)
        print(step_line(step), file=sys.stderr if step.frequency_error > TOLERATED_ERROR else sys.stdout)
        return release_dataset(structure, releases, sensors, acquisition, rng, replace(config, step=step.step)).dataset

    return simulated


def _shaken(
    structure: Structure,
    sensors: tuple[Sensor, ...],
    given: RecordingOptions,
    rng: np.random.Generator,
    faults: list[str],
) -> Callable[[], Dataset]:
    """Check and return the simulation of recordings whose base moves."""
    useless = ("pull", "realisations", "duration", "step", "gravity")
    faults += given.useless(*useless, because="goes not with --base, whose files say how long the motion is")
    text, unit = given.base_direction or "x", given.base_unit or SI_UNIT
    direction = noting(faults, "--base-direction", base_direction, text)
    if unit not in BASE_UNITS:
        faults.append(f"--base-unit {unit}: expected {' or '.join(BASE_UNITS)}")
    courses = all_of(given.base or (), base_values, faults)
    acquisition = acquisition_of(given, Kind.DRIVEN, faults)
    raise_faults(faults)
    assert direction is not None  # else there were faults
    excitations = [(BaseMotion(direction, BASE_UNITS[unit] * values),) for values in courses]
    raise_faults(check_driven(structure, excitations, sensors, acquisition))
    return partial(driven_dataset, structure, excitations, sensors, acquisition, rng)


def base_direction(text: str) -> BaseDirection:
    """Return the direction that a text means; `InputError` where it means none."""
    try:
        direction: object = float(text)
    except ValueError:
        direction = text
    unit_vector(direction)
    return direction  # type: ignore[return-value]  # it is one, or there was an error


def base_values(text: str) -> FloatArray:
    """Return the values of FILE[:COLUMN]."""
    file, _, column = text.partition(":") if file_fault(Path(text)) else (text, "", "")
    return load_force(Path(file), column or None)


def step_line(step: TimeStep) -> str:
    """Return what a time step does to the highest mode in the recordings' band; a warning where that is too much."""
    line = (
        f"time step {step.step:.2g} s: the highest mode in the recordings' band, {step.frequency:.4g} Hz, comes out "
        f"{100 * step.frequency_error:.2g} % too low"
    )
    if step.frequency_error <= TOLERATED_ERROR:
        return line[0].upper() + line[1:]
    return (
        f"warning: {line}, which a diagnosis may take for a structure too soft: leave --step out, or give "
        f"{step.longest:.2g} s or less"
    )


def _chain(
    model: str,
    structure: Structure,
    sensors: tuple[Sensor, ...],
    given: RecordingOptions,
    rng: np.random.Generator,
    faults: list[str],
) -> Callable[[], Dataset]:
    faults += given.useless("pull", "gravity", because=f"is for frames; {model} is a chain, see --realisations")
    acquisition = acquisition_of(given, Kind.FREE, faults)
    config = FreeConfig(Kind.FREE.duration(given.duration), acquisition.sampling_rate, given.step)
    raise_faults(faults + check_free(structure, sensors, acquisition))
    needed = free_step(linearise(structure))
    if given.step is not None and given.step > needed:
        print(f"warning: {TOO_LONG.format(step=given.step, needed=needed)}", file=sys.stderr)
    return partial(free_dataset, structure, given.realisations or 1000, sensors, acquisition, rng, config)


def acquisition_of(given: RecordingOptions, kind: Kind, faults: list[str]) -> Acquisition:
    """Return how recordings are made, with what is usual for their ``kind`` where nothing is asked for."""
    noise = noting(faults, "", _noise, given.noise) if given.noise else None
    return kind.acquisition(given.sampling_rate, given.lowpass, noise)


def base_faults(given: RecordingOptions) -> list[str]:
    """Return a fault for each option on the motion of a base where none is given."""
    return given.useless("base_direction", "base_unit", because="is of --base, which is not given")


def _noise(texts: list[str]) -> float | dict[str, float]:
    """Return the noise that texts describe: one number over each channel's, or numbers by unit."""
    found: dict[str, float] = {}
    for text in texts:
        number, _, unit = text.strip().partition(" ")
        try:
            found[unit.strip()] = _number(number)
        except ValueError:
            raise InputError(
                f'--noise {text}: expected a number, such as 0.02, or one with a unit, "0.01 m/s^2"'
            ) from None
    if len(found) < len(texts):
        raise InputError("--noise: give it once, or once for each unit of the sensors")
    if "" not in found:
        return found
    if len(found) > 1:
        raise InputError(
            "--noise: give either one number, over each channel's standard deviation, or each with its unit"
        )
    return found[""]


def all_of(texts: Iterable[str], read: Callable[[str], Value], faults: list[str]) -> tuple[Value, ...]:
    """Return what ``read`` makes of each text, noting the faults of those it cannot read."""
    values = (noting(faults, "", read, text) for text in texts)
    return tuple(value for value in values if value is not None)


def loads_of_pull(text: str) -> tuple[PointLoad, ...]:
    """Return the loads of one release, NODE:DIRECTION:FORCE joined by +."""
    loads = []
    for part in text.split("+"):
        try:
            node, direction, force = part.split(":")
            loads.append(PointLoad(int(node), _one_of(DIRECTIONS, direction), _number(force)))
        except ValueError:
            raise InputError(f"--pull {text}: expected NODE:DIRECTION:FORCE, such as 19:y:-9.81, joined by +") from None
    return tuple(loads)


def sensors_of(given: RecordingOptions, faults: list[str]) -> tuple[Sensor, ...]:
    """Return the sensors of the option, noting those that cannot be read and those that are given twice."""
    sensors = all_of(given.sensor or (), sensor_of, faults)
    times = Counter(sensor.name for sensor in sensors)
    faults += [f"--sensor: {name} is given {count} times; once is enough" for name, count in times.items() if count > 1]
    return sensors


def sensor_of(text: str) -> Sensor:
    """Return the sensor that NODE:DIRECTION[:QUANTITY[:held_out]] describes, named by it: "12:y" of acceleration."""
    parts = text.split(":")
    try:
        node, direction = int(parts[0]), direction_of_text(parts[1])
        quantity = _one_of(QUANTITIES, parts[2] if len(parts) > 2 else "acceleration")
        role = _one_of(ROLES, parts[3] if len(parts) > 3 else "measured")
    except (ValueError, IndexError, InputError):
        parts = []
    if not 2 <= len(parts) <= 4:
        raise InputError(
            f"--sensor {text}: expected NODE:DIRECTION[:QUANTITY[:held_out]], such as 12:y:acceleration; the direction"
            " also as degrees from x towards y, 12:30, or as a vector, 12:3,4"
        )
    name = f"{quantity[0]}{node}{direction if isinstance(direction, str) else f'({parts[1]})'}"
    return Sensor(name, node, direction, quantity, UNITS[quantity, direction in ROTATIONS], role)


def _number(text: str) -> float:
    """Return the number in a text; `ValueError` where it is none that can be computed with."""
    number = float(text)
    if number_fault(number):
        raise ValueError(number_fault(number))
    return number


def _one_of(known: tuple[Word, ...], text: str) -> Word:
    """Return the word of ``known`` that ``text`` is; `ValueError` where it is none."""
    return known[known.index(text)]
