"""Synthetic recordings: a structure simulated with all its nonlinearity, as its sensors would have recorded it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.assembly import linearise
from fe_models.base_motion import BaseMotion
from fe_models.dofs import structure_dofs
from fe_models.drive import drive_of
from fe_models.errors import InputError, noting, raise_faults
from fe_models.files.recording_checks import check_rates, check_sensor
from fe_models.lowpass import LowPass
from fe_models.measurement import measure, noise_faults
from fe_models.recordings import Dataset, Load, Recording, Sensor
from fe_models.response import Response
from fe_models.simulation import FreeConfig, ReleaseConfig, simulate_driven, simulate_free, simulate_release
from fe_models.simulation_size import length_faults
from fe_models.statics import PointLoad, load_vector
from fe_models.structure import Structure
from fe_models.structure_checks import require_structure
from fe_models.time_step import sampling_faults, time_step

OVERSAMPLING = 5  # samples of a motion to one that is recorded, so that a low-pass acts before
MIN_PASSED_SHARE = 0.1  # share that a low-pass leaves of a mode: what is left of higher ones never misled a diagnosis


@dataclass(frozen=True)
class Synthetic:
    """Simulated recordings and what no real one shows: the true displacement ``fields`` (time, dof) of each, in m."""

    dataset: Dataset
    fields: tuple[FloatArray, ...]


@dataclass(frozen=True)
class Acquisition:
    """How motion is recorded, by default like the laboratory bridge.

    ``sampling_rate`` and ``lowpass`` (Hz, None for none); ``noise``: its standard deviation over that of each channel,
    or by unit of the sensors in that unit: ``{"m/s^2": 0.01}``.
    ``start`` (s): when, after a release, the recording starts. The jump of the release is smeared by the low-pass, and
    is no free vibration of the modes below it, until about three of its periods have passed.
    """

    sampling_rate: float = 100.0
    lowpass: float | None = 30.0
    noise: float | Mapping[str, float] = 0.02
    start: float = 0.1

    @property
    def band(self) -> float:
        """Up to which frequency (Hz) recordings hold motion: half the sampling rate, less where a low-pass acts."""
        nyquist = self.sampling_rate / 2
        return nyquist if self.lowpass is None else min(nyquist, LowPass(self.lowpass).reach(MIN_PASSED_SHARE))


def release_dataset(
    structure: Structure,
    releases: tuple[tuple[PointLoad, ...], ...],
    sensors: tuple[Sensor, ...],
    acquisition: Acquisition,
    rng: np.random.Generator,
    config: ReleaseConfig | None = None,
    progress: bool = True,
) -> Synthetic:
    """Return one recording for each pull-and-release; of several, the last is for testing.

    The dataset's model is the structure itself; the recordings have what its linear model lacks: P-delta, slack cables,
    effects, noise. Where ``config`` has no step, the one that the recordings' band needs is taken (`time_step`).
    """
    if not releases:
        raise InputError("there is nothing to release: give at least one pull")
    raise_faults(check_release(structure, releases, sensors, acquisition))
    config = config or ReleaseConfig()
    columns = len(releases) * len(structure_dofs(structure))
    raise_faults(length_faults(config.duration, config.sampling_rate, config.step, columns))
    step = config.step if config.step is not None else time_step(structure, acquisition.band).step
    config = replace(config, duration=config.duration + acquisition.start, step=step)
    first = round(acquisition.start * acquisition.sampling_rate)
    recordings, fields = [], []
    for number, pulls in enumerate(releases, start=1):
        response = simulate_release(structure, pulls, config, progress)
        data = measure(
            response,
            sensors,
            acquisition.sampling_rate,
            rng,
            acquisition.lowpass,
            acquisition.noise,
            acquisition.start,
        )
        is_test = number == len(releases) > 1
        recordings.append(Recording(f"release_{number}", data[None], "test" if is_test else "train"))
        fields.append(response.displacement[:: round(response.sampling_rate / acquisition.sampling_rate)][first:])
    dataset = Dataset(structure, acquisition.sampling_rate, sensors, tuple(recordings), acquisition.lowpass)
    return Synthetic(dataset, tuple(fields))


def free_dataset(
    structure: Structure,
    realisations: int,
    sensors: tuple[Sensor, ...],
    acquisition: Acquisition,
    rng: np.random.Generator,
    config: FreeConfig | None = None,
    progress: bool = True,
) -> Dataset:
    """Return free motions of a chain from random states, each displacement and velocity ~ N(0, 1) in m and m/s.

    The first 80 % are for training. Where ``config`` is None, 50 s are simulated and sampled as ``acquisition`` says.
    """
    raise_faults(check_free(structure, sensors, acquisition))
    config = config or FreeConfig(sampling_rate=acquisition.sampling_rate)
    columns = realisations * len(structure_dofs(structure))
    raise_faults(length_faults(config.duration, config.sampling_rate, config.step, columns))
    start = rng.standard_normal((2, realisations, len(structure_dofs(structure).free_rows)))
    motion = simulate_free(structure, start[0], start[1], config, progress=progress)
    data = np.stack(
        [
            measure(
                Response(motion.time, x, v, a, motion.dofs),
                sensors,
                acquisition.sampling_rate,
                rng,
                acquisition.lowpass,
                acquisition.noise,
            )
            for x, v, a in zip(motion.displacement, motion.velocity, motion.acceleration, strict=True)
        ]
    )
    return Dataset(structure, acquisition.sampling_rate, sensors, train_and_test(data), acquisition.lowpass)


def driven_dataset(
    structure: Structure,
    excitations: Sequence[Sequence[Load | BaseMotion]],
    sensors: tuple[Sensor, ...],
    acquisition: Acquisition,
    rng: np.random.Generator,
    config: FreeConfig | ReleaseConfig | None = None,
    progress: bool = True,
) -> Dataset:
    """Return one recording from rest under each of the ``excitations``, which have one value a sample; of several
    recordings the last is for testing.

    They have what the structure's linear model lacks, as in `release_dataset`. The loads and the motion of the base
    stand in the dataset as they were given: sensors' filters did not act on them. ``config``: see `simulate_driven`.
    """
    raise_faults(check_driven(structure, excitations, sensors, acquisition))
    rate = acquisition.sampling_rate
    if config is None:
        fine = OVERSAMPLING * rate if acquisition.lowpass else rate
        step = None if structure.is_chain else time_step(structure, acquisition.band).step
        config = FreeConfig(sampling_rate=fine) if structure.is_chain else ReleaseConfig(sampling_rate=fine, step=step)
    recordings = []
    for number, excitation in enumerate(excitations, start=1):
        motion = simulate_driven(structure, drive_of(structure, excitation, rate), config, progress)
        data = measure(motion, sensors, rate, rng, acquisition.lowpass, acquisition.noise)
        loads = tuple(item for item in excitation if isinstance(item, Load))
        base = tuple(item for item in excitation if isinstance(item, BaseMotion))
        is_test = number == len(excitations) > 1
        role: Literal["train", "test"] = "test" if is_test else "train"
        recordings.append(Recording(f"driven_{number}", data[None], role, loads, excitation="measured", base=base))
    return Dataset(structure, rate, sensors, tuple(recordings), acquisition.lowpass)


def train_and_test(data: FloatArray) -> tuple[Recording, ...]:
    """Split ``data`` (realisation, time, sensor): the first 80 % for training, the others for tests."""
    train = max(1, len(data) * 4 // 5)
    parts = (Recording("train", data[:train], "train"), Recording("test", data[train:], "test"))
    return tuple(part for part in parts if len(part.data))


def check_driven(
    structure: Structure,
    excitations: Sequence[Sequence[Load | BaseMotion]],
    sensors: tuple[Sensor, ...],
    acquisition: Acquisition,
) -> list[str]:
    """Return the faults of what is to be driven, before time is spent on it."""
    faults = check_release(structure, (), sensors, acquisition)
    if not excitations:
        faults.append("nothing drives the structure: give loads, or a base motion")
    for number, excitation in enumerate(excitations, start=1):
        noting(faults, f"recording {number}", drive_of, structure, excitation, acquisition.sampling_rate)
    return faults


def check_free(structure: Structure, sensors: tuple[Sensor, ...], acquisition: Acquisition) -> list[str]:
    """Return the faults of a chain that is to move freely, before time is spent on it."""
    faults = check_release(structure, (), sensors, acquisition)
    if not faults:
        faults += sampling_faults(linearise(structure), acquisition.sampling_rate)
    return faults


def check_release(
    structure: Structure,
    releases: tuple[tuple[PointLoad, ...], ...],
    sensors: tuple[Sensor, ...],
    acquisition: Acquisition,
) -> list[str]:
    """Return the faults of what is to be simulated, before time is spent on it."""
    dofs = structure_dofs(require_structure(structure))
    faults = check_rates(acquisition.sampling_rate, acquisition.lowpass)
    for sensor in sensors:
        found = check_sensor(sensor, dofs, len(structure.nodes))
        faults += [f"sensor {sensor.name!r}: {fault}" for fault in found]
    faults += noise_faults(acquisition.noise, sensors)
    for loads in releases:
        noting(faults, "", load_vector, structure, loads)
    return faults
