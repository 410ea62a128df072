"""Recordings simulated in one call: where the sensors sit, what moves the structure, how noisy the sensors are."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np

from fe_models.base_motion import BaseMotion
from fe_models.dofs import dofs_of
from fe_models.errors import InputError, noting, raise_faults
from fe_models.files.recording_checks import UNITS, check_sensors
from fe_models.linear import LinearModel
from fe_models.linear_recordings import driven_recordings, released_recordings
from fe_models.recordings import Dataset, Load, Quantity, Recording, Sensor
from fe_models.simulation import FreeConfig, ReleaseConfig
from fe_models.statics import PointLoad
from fe_models.structure import ROTATIONS, TRANSLATIONS, Beam, Cable, Structure
from fe_models.synthetic import OVERSAMPLING, Acquisition, driven_dataset, free_dataset, release_dataset
from fe_models.usual_recordings import Kind

QUANTITY_LETTERS: dict[str, Quantity] = {"x": "displacement", "v": "velocity", "a": "acceleration"}
SENSOR_NAME = re.compile(r"([xva])(\d+)(r?[xyz])?")
DEFAULT_MOTIONS = 10  # of a chain: enough to train on and to test with, simulated in a second
Excitation = Load | BaseMotion


def simulate(
    model: Structure | LinearModel,
    sensors: Iterable[str | Sensor],
    *,
    held_out: Iterable[str | Sensor] = (),
    pulls: Sequence[PointLoad | Sequence[PointLoad]] = (),
    excitation: Sequence[Excitation | Sequence[Excitation]] = (),
    motions: int = DEFAULT_MOTIONS,
    duration: float | None = None,
    sampling_rate: float | None = None,
    lowpass: float | None = None,
    noise: float | Mapping[str, float] = Acquisition.noise,
    seed: int = 0,
    progress: bool = False,
) -> Dataset:
    """Return recordings of a structure with all its nonlinearity, or of matrices, each ready for training (see
    `Dataset.split`).

    A chain moves freely from as many random states as there are to be ``motions``; a frame is pulled and let go:
    ``pulls`` holds a load, or several at once, for each recording; so are matrices, which move linearly. With an
    ``excitation`` each starts from rest and is driven: by a `Load` or a `BaseMotion`, or several at once, for each
    recording, one value a sample.

    ``sensors`` are fitted, those ``held_out`` only scored; "a3" is the acceleration of node 3, "x3" its displacement,
    "v3" its velocity, and "a3y" that in y, where nodes move in several directions. ``duration`` (s): 50 for chains, 20
    for others; ``sampling_rate`` (Hz): 10 for chains and 100, of what is driven 100; ``lowpass`` (Hz; 0 for none): none
    for chains, else 0.3 times the sampling rate, of what is driven none. ``noise``: its standard deviation, over that
    of each channel (0.02) or in the sensors' units ({"m/s^2": 0.01}). The dataset's model is the one that moved: give
    `hybrid.diagnose` the design beside it.
    `InputError` with all faults.
    """
    faults = list[str]()
    fitted = _read(sensors, model, faults)
    unseen = (replace(sensor, role="held_out") for sensor in _read(held_out, model, faults))
    channels = (*fitted, *unseen)
    faults += check_sensors(list(channels)) if not faults else []
    raise_faults(faults)
    rng = np.random.default_rng(seed)
    if excitation:
        if pulls or duration is not None:
            raise InputError("an excitation says how long recordings are, and nothing is pulled then: leave that out")
        acquisition = Kind.DRIVEN.acquisition(sampling_rate, lowpass, noise)
        driven = tuple((item,) if isinstance(item, Load | BaseMotion) else tuple(item) for item in excitation)
        if isinstance(model, LinearModel):
            return driven_recordings(model, driven, channels, acquisition, rng)
        return driven_dataset(model, driven, channels, acquisition, rng, progress=progress)
    if isinstance(model, Structure) and not any(isinstance(element, Beam | Cable) for element in model.elements):
        if pulls:
            raise InputError("pulls are for frames; a chain moves from random states, see motions")
        if motions < 1:
            raise InputError(f"motions = {motions}; expected at least 1")
        acquisition = Kind.FREE.acquisition(sampling_rate, lowpass, noise)
        free = FreeConfig(Kind.FREE.duration(duration), acquisition.sampling_rate)
        return _separate(free_dataset(model, motions, channels, acquisition, rng, free, progress))
    if not pulls:
        raise InputError(
            f"{'a frame is' if isinstance(model, Structure) else 'matrices are'} pulled and let go: give pulls, such as"
            " [PointLoad(3, 'y', -10.0)], one for each recording"
        )
    acquisition, length = Kind.RELEASED.acquisition(sampling_rate, lowpass, noise), Kind.RELEASED.duration(duration)
    releases = tuple((pull,) if isinstance(pull, PointLoad) else tuple(pull) for pull in pulls)
    if isinstance(model, LinearModel):
        return _separate(released_recordings(model, releases, channels, acquisition, length, rng))
    release = ReleaseConfig(duration=length, sampling_rate=OVERSAMPLING * acquisition.sampling_rate)
    return _separate(release_dataset(model, releases, channels, acquisition, rng, release, progress).dataset)


def _separate(found: Dataset) -> Dataset:
    """Return a dataset with a recording for each motion, all for training."""
    single = (data[None] for recording in found.recordings for data in recording.data)
    recordings = tuple(Recording(f"motion_{number}", data) for number, data in enumerate(single, start=1))
    return replace(found, recordings=recordings)


def sensor_at(sensor: str | Sensor, model: Structure | LinearModel) -> Sensor:
    """Return the sensor that a name such as "a3" or "a3y" stands for; `InputError` where it stands for none."""
    if isinstance(sensor, Sensor):
        return sensor
    match = SENSOR_NAME.fullmatch(sensor)
    own = set(dofs_of(model).direction.tolist())
    known = [direction for direction in (*TRANSLATIONS, *ROTATIONS) if direction in own]
    if match is None or (match[3] or known[0]) not in known or not (match[3] or len(known) == 1):
        example = '"a3"' if len(known) == 1 else f'"a3{known[0]}"'
        along = "" if len(known) == 1 else f" and a direction ({', '.join(known)})"
        raise InputError(
            f"sensor {sensor!r}: expected x, v or a (displacement, velocity, acceleration), a node{along},"
            f" such as {example}; or a Sensor"
        )
    direction = next(each for each in known if each == (match[3] or known[0]))
    quantity = QUANTITY_LETTERS[match[1]]
    return Sensor(sensor, int(match[2]), direction, quantity, UNITS[quantity, direction in ROTATIONS])


def _read(sensors: Iterable[str | Sensor], model: Structure | LinearModel, faults: list[str]) -> list[Sensor]:
    read = (noting(faults, "", sensor_at, sensor, model) for sensor in sensors)
    return [sensor for sensor in read if sensor is not None]
