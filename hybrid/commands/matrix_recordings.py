"""Recordings of matrices as the options of `simulate` describe them."""

from collections.abc import Callable
from functools import partial

import numpy as np

from fe_models.base_motion import BaseMotion
from fe_models.errors import noting, raise_faults
from fe_models.files.known_motion import BASE_UNITS, SI_UNIT
from fe_models.linear import LinearModel
from fe_models.linear_recordings import check_linear, driven_recordings, released_recordings
from fe_models.recordings import Dataset
from fe_models.usual_recordings import Kind
from hybrid.commands.recording_options import RecordingOptions
from hybrid.commands.recordings import (
    acquisition_of,
    all_of,
    base_direction,
    base_faults,
    base_values,
    loads_of_pull,
    sensors_of,
)

LINEAR = "is not for matrices, which move linearly: they take --pull or --base, --sensor, rates and noise"


def matrix_recordings(model: LinearModel, given: RecordingOptions, seed: int) -> Callable[[], Dataset]:
    """Check the options on recordings, all at once, and return the simulation that they ask for."""
    faults = given.useless("cubic_stiffness", "modal_model", "gravity", "step", "realisations", because=LINEAR)
    sensors = sensors_of(given, faults)
    if not given.sensor:
        faults.append("recordings need sensors: give at least one --sensor NODE:DIRECTION, such as --sensor 2:x")
    kind, rng = Kind.DRIVEN if given.base else Kind.RELEASED, np.random.default_rng(seed)
    acquisition = acquisition_of(given, kind, faults)
    if given.base:
        faults += given.useless("pull", "duration", because="goes not with --base, whose files say how long it is")
        unit = given.base_unit or SI_UNIT
        if unit not in BASE_UNITS:
            faults.append(f"--base-unit {unit}: expected {' or '.join(BASE_UNITS)}")
        along = noting(faults, "--base-direction", base_direction, given.base_direction or "x")
        courses = all_of(given.base, base_values, faults)
        raise_faults(faults)
        assert along is not None  # else there were faults
        motions = [(BaseMotion(along, BASE_UNITS[unit] * values),) for values in courses]
        return partial(driven_recordings, model, motions, sensors, acquisition, rng)
    faults += base_faults(given)
    releases = all_of(given.pull or (), loads_of_pull, faults)
    if not given.pull:
        faults.append("something must move it: give --pull NODE:DIRECTION:FORCE, such as --pull 3:z:-10, or --base")
    raise_faults([*faults, *check_linear(model, releases, sensors, acquisition)])
    duration = kind.duration(given.duration)
    return partial(released_recordings, model, releases, sensors, acquisition, duration, rng)
