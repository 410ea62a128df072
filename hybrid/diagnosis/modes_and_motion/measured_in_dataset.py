"""The modes that a dataset lists, or that its training recordings show, beside the nominal model."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from fe_models.errors import InputError
from fe_models.recordings import Dataset, derivative_orders
from hybrid.diagnosis.modal.config import LISTED
from hybrid.diagnosis.modal.measured_modes import MeasuredModes
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.nominal.any_model import any_nominal_model_of, followed_as_found
from hybrid.diagnosis.nominal.nominal_model import NominalModel
from hybrid.diagnosis.recorded.batches import measured_columns
from hybrid.identification.identification import Identification, identify


def as_measured(dataset: Dataset) -> Dataset:
    """Return the dataset at its highest sampling rate, or, where it lists its modes, as if it had been sampled fast
    enough for them, and for as many again.
    """
    if not dataset.modes:
        return dataset.of_highest_rate()
    highest = max(mode.frequency for mode in dataset.modes)
    return replace(dataset, sampling_rate=LISTED.samples_a_cycle * highest, lowpass=None, recordings=())


def measured_in(dataset: Dataset, tell: Callable[[str], object]) -> tuple[ModalData, dict[str, Identification]]:
    """Return the modes of all training recordings, listed or else identified, beside the nominal model; and what was
    identified, by the recording's name. ``tell`` hears the name of each.
    """
    nominal = any_nominal_model_of(dataset)
    identified = dict[str, Identification]()
    if dataset.modes:
        found = _listed(dataset)
        if not found:
            raise InputError("modes: none is for training; give one the role 'train' at least")
        sensors = tuple(replace(sensor, quantity="displacement") for sensor in dataset.sensors)
    else:
        sensors = tuple(dataset.sensors[column] for column in measured_columns(dataset))
        identified = _identified(dataset, nominal, tell)
        found = tuple(MeasuredModes.of(name, own.modes) for name, own in identified.items())
        highest = max((float(own.log_omega.max()) for own in found if len(own.log_omega)), default=None)
        if highest is not None:
            nominal = followed_as_found(nominal, dataset, float(np.exp(highest)) / (2 * np.pi))
    return ModalData(nominal, np.zeros(len(nominal.spread)), sensors, dataset.sampling_rate, found), identified


def _listed(dataset: Dataset) -> tuple[MeasuredModes, ...]:
    """Return the modes for training that the dataset lists, by their state; their shapes are those of displacements."""
    own = [mode for mode in dataset.modes if mode.role == "train"]
    states = dict.fromkeys(mode.recording for mode in own)
    count = len(dataset.sensors)
    return tuple(
        MeasuredModes.listed(state, [mode for mode in own if mode.recording == state], count) for state in states
    )


def _identified(dataset: Dataset, nominal: NominalModel, tell: Callable[[str], object]) -> dict[str, Identification]:
    """Return what the training recordings show at the measured sensors, by their names."""
    columns = list(measured_columns(dataset))
    orders = derivative_orders([dataset.sensors[column] for column in columns])
    slowest = float(nominal.modes[0][0]) / (2 * np.pi)
    found = dict[str, Identification]()
    for recording in dataset.select("train"):
        tell(recording.name)
        rate = dataset.rate_of(recording)
        motions = [motion[:, columns] for motion in recording.data]
        if not any((np.ptp(motion, axis=0) > 0).any() for motion in motions):
            raise InputError(f"recording {recording.name!r}: no sensor changes in it: dead sensors? leave it out")
        highest = dataset.lowpass or rate / 2
        found[recording.name] = identify(motions, rate, slowest, highest, orders, recording.excitation)
    return found
