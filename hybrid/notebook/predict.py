"""Predict the motion of the whole structure from a recording of a few sensors, in one call."""

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from fe_models.arrays import FloatArray
from fe_models.errors import InputError, raise_faults
from fe_models.recordings import Recording
from hybrid.identification.excitation import Course
from hybrid.identification.unstated_excitation import unstated_course
from hybrid.known_loads.short_knocks import after_short_knock
from hybrid.notebook.predicted_field import PredictedField

if TYPE_CHECKING:
    from hybrid.notebook.trained import TrainedModel


def predict(
    trained: "TrainedModel",
    recording: Recording | FloatArray,
    *,
    start: float = 0.0,
    duration: float | None = None,
    whole: bool = False,
) -> PredictedField:
    """Return the motion of all degrees of freedom, with its standard deviation, from a recording.

    ``recording``: a `Recording`, of several motions the first, or its data (time, sensor), with all sensors that the
    model was trained with. The state is estimated from the first samples at ``start`` (s) and carried on for
    ``duration`` (s; None: to the end of the recording, beyond which it may go where no known force acts). ``whole``:
    all samples are used, which takes a model that solves for its states (preset "places"). Loads and base motion of a
    `Recording` drive the forecast. Of one with ``excitation`` "ambient", or without any that does not die away, the
    motion, about its mean, is estimated from all its samples, whatever forces moved it. `InputError` where the
    recording does not fit.
    """
    from hybrid.estimation.uncertainty import banded_field, banded_forecast  # loads PyTorch only where it is needed
    from hybrid.estimation.windows import driving_of
    from hybrid.known_loads.modal_input import input_of
    from hybrid.training.summary import band_warning

    origin, model = trained.checkpoint.origin, trained.model
    given = recording if isinstance(recording, Recording) else Recording("", np.asarray(recording, dtype=float)[None])
    used = after_short_knock(given)
    data, knock = used.data[0], used.skipped - given.skipped
    seen, rate = trained.checkpoint.config.model.encoder_samples, origin.sampling_rate
    first = max(round(start * rate) - knock, 0)
    if data.ndim != 2 or data.shape[1] != len(origin.sensors):
        names = ", ".join(sensor.name for sensor in origin.sensors)
        raise InputError(f"the recording has shape {data.shape}; expected (time, {len(origin.sensors)}): {names}")
    left = len(data) - first
    samples = left if duration is None else round(duration * rate) + 1
    faults = []
    if start < 0 or left < seen:
        faults.append(f"start = {start:g} s; expected 0 to {(len(data) - seen) / rate:g} s: {seen} samples are read")
    slowest = float(origin.modal.frequencies.min())
    course = unstated_course(replace(used, data=used.data[:1]), origin.sensors, rate, origin.lowpass, slowest)
    ambient = used.excitation == "ambient" or course is not None
    bounded = whole or used.is_driven or ambient
    if samples < 1 or (bounded and samples > left):
        why = ", over which the forces are known" if used.is_driven else ""
        span = f"up to {(left - 1) / rate:g} s{why}" if bounded else "0 s or more"
        faults.append(f"duration = {duration} s; expected {span}")
    raise_faults(faults)
    if ambient:
        return _sensed(trained, used, first, samples, course)
    window = data[None, first : first + (samples if whole else seen)]
    forces = input_of(origin.structure, origin.modal, origin.sensors, rate, origin.lowpass, [used])
    driving = driving_of(forces, replace(used, data=used.data[:1]))
    known = None if driving is None else driving.part(first, first + samples)
    banded = banded_forecast(model, window, samples, whole, known)
    field, std = banded_field(model, window, origin.modal.shapes, samples, whole, known)
    return PredictedField(
        time=(start if not knock else (first + knock) / rate) + np.arange(samples) / rate,
        displacement=field[0],
        std=std[0],
        channels=banded.forecast.channels[0],
        channels_std=banded.std[0],
        dofs=origin.modal.dofs,
        sensors=origin.sensors,
        warnings=tuple(band_warning(trained.scores)),
    )


def _sensed(
    trained: "TrainedModel", recording: Recording, first: int, samples: int, course: Course | None
) -> PredictedField:
    """Return the motion under unknown forces, estimated from a whole recording, from its sample ``first`` on.

    ``course``: how it goes on, where nothing was said of what moved it.
    """
    from hybrid.training.sensing import sensed, sensing_scores, too_narrow
    from hybrid.training.trainable import taken_as_ambient

    origin = trained.checkpoint.origin
    found = sensed(trained.model, replace(recording, data=recording.data[:1]))
    own = found[0].hybrid.part(first, first + samples)
    shapes = origin.modal.shapes
    return PredictedField(
        time=(first + np.arange(samples)) / origin.sampling_rate,
        displacement=own.motion.q[0] @ shapes.T,
        std=own.field_std(shapes),
        channels=own.motion.channels[0],
        channels_std=own.channels_std,
        dofs=origin.modal.dofs,
        sensors=origin.sensors,
        warnings=(
            *(() if course is None else (taken_as_ambient(recording.name, course),)),
            *too_narrow(sensing_scores(found, origin.sensors)),
        ),
    )
