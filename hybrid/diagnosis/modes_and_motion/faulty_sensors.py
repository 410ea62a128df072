"""Sensors that no cause on the list makes right: of another quantity than stated, or two in each other's place."""

import numpy as np

from fe_models.arrays import ComplexArray, IntArray
from hybrid.diagnosis.discrepancy.modal_space import roots_of
from hybrid.diagnosis.modal.measured_modes import MeasuredModes
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modal.predicted_modes import PredictedModes, predicted_modes
from hybrid.identification.suspect_sensors import MODELS, SuspectSensors, suspect_sensors


def notes_on_sensors(measured: ModalData) -> tuple[str, ...]:
    """Return a note for each such fault that the shapes of measured modes show, with the recordings that show it.

    What is expected are the modes of the structure as it is drawn: nominal values that were fitted would make up for
    the fault. A gain is a cause of its own, which the search finds.
    """
    drawn = predicted_modes(measured.null.hypothesis, np.zeros((1, len(measured.offset))), measured.outputs)
    if drawn is None:
        return ()
    names = [sensor.name for sensor in measured.sensors]
    shown = dict[str, list[str]]()
    for own in measured.recordings:
        suspect = _suspect(own, drawn, measured.orders)
        if suspect is not None and (suspect.derivative or len(suspect.sensors) > 1):
            shown.setdefault(suspect.words(names, MODELS), []).append(own.name)
    return tuple(f"{', '.join(recordings)}: {words}" for words, recordings in shown.items())


def _suspect(own: MeasuredModes, modes: PredictedModes, orders: IntArray) -> SuspectSensors | None:
    """Return what keeps the shapes of a recording's ``own`` modes from being those of the structure's ``modes``."""
    shown, expected = own.has_shape, _displacements(modes.roots[0], modes.shapes[0], orders)
    largest = np.take_along_axis(expected, np.argmax(np.abs(expected), axis=0)[None], axis=0)
    roots = roots_of(np.exp(own.log_omega[shown]), own.ratios[shown])
    found = _displacements(roots, own.shapes[shown], orders)
    hertz = [np.abs(every) / (2 * np.pi) for every in (modes.roots[0], roots)]
    return suspect_sensors(hertz[0], np.real(expected / largest), hertz[1], found)


def _displacements(roots: ComplexArray, shapes: ComplexArray, orders: IntArray) -> ComplexArray:
    """Return shapes (sensor, mode) of displacements: of ``shapes`` (mode, sensor) each ``orders`` (sensor,) times
    differentiated.
    """
    return np.asarray((shapes / roots[:, None] ** orders).T)
