"""Frequency response functions under known loads and base motion: measured, with their coherence, and the model's.

    H1(f) = S_xx(f)^-1 S_xy(f)

of loads x and a sensor y, with cross spectra averaged over segments and recordings (Bendat and Piersol, Random Data):
noise of the sensors averages out. The multiple coherence H1^H S_xx H1 / S_yy is the share of a sensor's power that
the loads explain linearly: less is noise, something unknown that pushes, or a structure that is not linear.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import csd

from fe_models.arrays import ComplexArray, FloatArray
from fe_models.errors import InputError, raise_faults
from fe_models.linear import LinearModel
from fe_models.nominal import assumed_structure
from fe_models.recordings import Dataset, Recording
from fe_models.structure import Structure
from hybrid.identification.computed_response import (
    Input,
    computed_response,
    input_name,
    laws_left_out,
    misplaced,
)
from hybrid.identification.config import FREQUENCY_RESPONSE


@dataclass(frozen=True)
class FrequencyResponse:
    """How sensors answer to the ``inputs`` (see `Input`) at ``frequencies`` (line,), Hz, where these have power.

    ``measured`` and those of ``models`` by name, the "nominal" and perhaps the "extended" one, (line, input, sensor),
    in the sensor's unit over N, N m or m/s^2; ``coherence`` (line, sensor); ``averages``: of how many segments.
    ``left_out``: kinds of force laws of the models, which functions cannot have.
    """

    inputs: tuple[str, ...]
    sensors: tuple[str, ...]
    frequencies: FloatArray
    measured: ComplexArray
    models: dict[str, ComplexArray]
    coherence: FloatArray
    averages: int
    left_out: tuple[str, ...] = ()

    def assurance(self, model: ComplexArray) -> FloatArray:
        """Return the frequency response assurance criterion (input, sensor) of a ``model``'s functions.

        As a MAC over frequencies: 1 where the measured one is a number times it.
        """
        cross = np.abs(np.sum(self.measured.conj() * model, axis=0)) ** 2
        return np.asarray(cross / np.sum(np.abs(self.measured) ** 2, axis=0) / np.sum(np.abs(model) ** 2, axis=0))

    def factor(self, model: ComplexArray) -> FloatArray:
        """Return by which factor (input, sensor) a ``model``'s functions come nearest to the measured ones."""
        along = np.sum(model.conj() * self.measured, axis=0).real
        return np.asarray(along / np.sum(np.abs(model) ** 2, axis=0))

    def deviation(self, model: ComplexArray) -> FloatArray:
        """Return ||measured - model|| / ||measured|| over all frequencies, (input, sensor): 0 where they are alike."""
        error = np.sum(np.abs(self.measured - model) ** 2, axis=0)
        return np.asarray(np.sqrt(error / np.sum(np.abs(self.measured) ** 2, axis=0)))


def frequency_response(dataset: Dataset, extended: Structure | LinearModel | None = None) -> FrequencyResponse:
    """Return the frequency response functions of a dataset's driven recordings; `InputError` where there are none.

    Beside them those of its own model, as its simulation assumes it, and of an ``extended`` one. Loads of recordings in
    which all go with one another cannot be told apart: also an `InputError`.
    """
    driven = [recording for recording in dataset.recordings if recording.is_driven]
    if not driven:
        raise InputError("no recording names loads or base motion: there are no frequency response functions")
    inputs, rate = _inputs(driven), _one_rate(dataset, driven)
    models = {"nominal": assumed_structure(dataset)} | ({} if extended is None else {"extended": extended})
    raise_faults(extended_faults(dataset, extended) if extended is not None else ())
    segment = _segment_length(driven, inputs)
    channels = len(inputs) + len(dataset.sensors)
    spectra, averages = np.zeros((segment // 2 + 1, channels, channels), dtype=np.complex128), 0
    for recording in driven:
        forces = _values(recording, inputs)
        for motion in recording.data:
            frequencies, own, count = _spectra(forces, motion, rate, segment)
            spectra += count * own
            averages += count
    if averages < FREQUENCY_RESPONSE.min_averages * len(inputs):
        raise InputError(
            f"{len(inputs)} inputs and {averages} segments: they need "
            f"{FREQUENCY_RESPONSE.min_averages * len(inputs)}; give longer recordings, or more of them"
        )
    kept = _with_power(frequencies, spectra, len(inputs), dataset.lowpass or rate / 2)
    measured, coherence = _solved(spectra[kept], len(inputs))
    return FrequencyResponse(
        inputs=tuple(input_name(item) for item in inputs),
        sensors=tuple(sensor.name for sensor in dataset.sensors),
        frequencies=frequencies[kept],
        measured=measured,
        models={
            name: computed_response(model, dataset.sensors, inputs, frequencies[kept]) for name, model in models.items()
        },
        coherence=coherence,
        averages=averages,
        left_out=tuple(sorted({kind for model in models.values() for kind in laws_left_out(model)})),
    )


def extended_faults(dataset: Dataset, extended: Structure | LinearModel) -> list[str]:
    """Return why the functions of an ``extended`` model cannot be held against a dataset, a line each."""
    driven = [recording for recording in dataset.recordings if recording.is_driven]
    if not driven:
        return ["it is compared by frequency response functions, and no recording names loads or base motion"]
    return misplaced(extended, dataset.sensors, _inputs(driven))


def _one_rate(dataset: Dataset, driven: Sequence[Recording]) -> float:
    """Return the sampling rate (Hz) of recordings; `InputError` where they have several."""
    rates = sorted({dataset.rate_of(recording) for recording in driven})
    if len(rates) > 1:
        raise InputError(
            f"recordings under known forces were sampled at {' and '.join(f'{rate:g}' for rate in rates)} Hz: frequency"
            " response functions need one rate; make a dataset of each"
        )
    return rates[0]


def _inputs(driven: Sequence[Recording]) -> tuple[Input, ...]:
    loads: set[Input] = {(load.node, load.direction) for recording in driven for load in recording.loads}
    base: set[Input] = {motion.along for recording in driven for motion in recording.base}
    return (*sorted(loads, key=str), *sorted(base, key=str))


def _values(recording: Recording, inputs: tuple[Input, ...]) -> FloatArray:
    """Return what drives a recording, (time, input)."""
    values = np.zeros((recording.data.shape[1], len(inputs)))
    for load in recording.loads:
        values[:, inputs.index((load.node, load.direction))] += load.values
    for motion in recording.base:
        values[:, inputs.index(motion.along)] += motion.values
    return values


def _segment_length(driven: Sequence[Recording], inputs: tuple[Input, ...]) -> int:
    """Return how long segments are: whole recordings of knocks, whose answers die away; of others parts of them."""
    shortest = min(recording.data.shape[1] for recording in driven)
    if all(_is_knock(_values(recording, inputs)) for recording in driven):
        return shortest
    return max(int(FREQUENCY_RESPONSE.segment_share * shortest), min(shortest, FREQUENCY_RESPONSE.min_segment))


def _is_knock(values: FloatArray) -> bool:
    """Return whether forces (time, input) have nearly all of their energy in a short part of a recording."""
    energy = np.sort(np.sum(values**2, axis=1))[::-1]
    short = max(int(FREQUENCY_RESPONSE.knock_share * len(energy)), 1)
    return bool(energy[:short].sum() > FREQUENCY_RESPONSE.knock_energy * energy.sum())


def _spectra(forces: FloatArray, motion: FloatArray, rate: float, segment: int) -> tuple[FloatArray, ComplexArray, int]:
    """Return frequencies (line,), cross spectra (line, channel, channel) of inputs, then sensors, and the number of
    segments.
    """
    channels = np.column_stack([forces, motion]).T
    whole = segment >= channels.shape[1] or _is_knock(forces)
    window, overlap = ("boxcar", 0) if whole else ("hann", segment // 2)
    step = segment - overlap
    frequencies, found = csd(
        channels[:, None], channels[None], rate, window, segment, overlap, detrend=False if whole else "constant"
    )
    count = 1 + (channels.shape[1] - segment) // step
    return np.asarray(frequencies), np.asarray(found).transpose(2, 0, 1), count


def _with_power(frequencies: FloatArray, spectra: ComplexArray, inputs: int, below: float) -> FloatArray:
    """Return which lines (line,) have power of every input, ``below`` (Hz) the recordings' low-pass."""
    power = np.abs(np.diagonal(spectra, axis1=1, axis2=2)[:, :inputs])
    inside = (frequencies > 0) & (frequencies < below)
    strong = power > FREQUENCY_RESPONSE.min_power_share * power[inside].max(axis=0)
    return np.asarray(inside & strong.all(axis=1))


def _solved(spectra: ComplexArray, inputs: int) -> tuple[ComplexArray, FloatArray]:
    """Return H1 (line, input, sensor) and the multiple coherence (line, sensor)."""
    xx, xy = spectra[:, :inputs, :inputs], spectra[:, :inputs, inputs:]
    scale = np.sqrt(np.abs(np.diagonal(xx, axis1=1, axis2=2)))
    alike = xx / scale[:, :, None] / scale[:, None]
    if inputs > 1 and np.median(np.linalg.cond(alike)) > FREQUENCY_RESPONSE.max_condition:
        raise InputError("the loads go with one another in all recordings: what each does cannot be told apart")
    response = np.linalg.solve(xx, xy)
    power = np.abs(np.diagonal(spectra, axis1=1, axis2=2)[:, inputs:])
    explained = np.einsum("fis,fij,fjs->fs", response.conj(), xx, response).real
    return np.asarray(response, dtype=np.complex128), np.asarray(np.clip(explained / power, 0.0, 1.0))
