"""Measured modes that no mode of the structure is, by what they look like."""

from dataclasses import dataclass

import numpy as np

from fe_models.arrays import BoolArray, ComplexArray, FloatArray, IntArray
from fe_models.modes import mac
from hybrid.diagnosis.modal.config import PAIRING
from hybrid.diagnosis.modal.evidence import ModalFit
from hybrid.diagnosis.modal.measured_modes import MeasuredModes, is_combined_of
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modal.mode_values import FREQUENCY
from hybrid.diagnosis.modal.pairing import displaced
from hybrid.diagnosis.modal.pairs import predicted_of


@dataclass(frozen=True)
class UnmatchedModes:
    """Numbers of one recording's modes that the structure does not have: those ``exchanged``, of one of its modes'
    frequency and another's shape; ``combinations`` of the frequencies of modes that it has; all ``others``.
    """

    exchanged: tuple[int, ...]
    combinations: tuple[int, ...]
    others: tuple[int, ...]


def unmatched_modes(measured: ModalData, best: ModalFit) -> tuple[UnmatchedModes, ...]:
    """Return, for each recording, the modes that the best fit's structure does not have."""
    predicted, pairs = predicted_of(measured, best.claim, best.theta)
    found = []
    for recording, own in enumerate(measured.recordings):
        alone = np.ones(own.count, dtype=bool)
        alone[pairs.measured[pairs.recording == recording]] = False
        exchanged, combined = np.zeros((2, own.count), dtype=bool)
        modes = predicted.get(best.claim.idle_in(recording))
        if modes is not None:
            exchanged = _exchanged(own, alone, modes.log_omega[0], modes.shapes[0], measured.orders)
            combined = _combined(own, alone) & ~exchanged
        parts = (exchanged, combined, alone & ~exchanged & ~combined)
        found.append(UnmatchedModes(*(tuple(np.flatnonzero(part).tolist()) for part in parts)))
    return tuple(found)


def _exchanged(
    own: MeasuredModes, alone: BoolArray, log_omega: FloatArray, shapes: ComplexArray, orders: IntArray
) -> BoolArray:
    """Return which modes (measured,) of those that stand ``alone`` (measured,) have the frequency of one of the
    structure's, ``log_omega`` (mode,), and of its ``shapes`` (mode, sensor) another's, whose frequency is another's.
    """
    alike = mac(displaced(own.log_omega, own.shapes, orders).T, displaced(log_omega, shapes, orders).T)
    same_shape = alike > 1 - PAIRING.mac_scale
    there = np.abs(own.log_omega[:, None] - log_omega) < PAIRING.frequency_scale
    apart = alone & own.has_shape & ~(there & same_shape).any(axis=1)
    taken = there[apart].any(axis=0)
    return np.asarray(apart & there.any(axis=1) & (same_shape & taken).any(axis=1))


def _combined(own: MeasuredModes, alone: BoolArray) -> BoolArray:
    """Return which modes (measured,) of those that stand ``alone`` (measured,) are at a multiple, a sum or a difference
    of the frequencies of those that do not.
    """
    frequency = np.exp(own.log_omega)
    error = frequency * np.sqrt(own.covariance[:, FREQUENCY, FREQUENCY])
    known = np.flatnonzero(~alone)
    combined = [is_combined_of(line, known, frequency, error) for line in range(own.count)]
    return alone & np.array(combined, dtype=bool)
