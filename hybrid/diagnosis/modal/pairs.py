"""Which measured mode is which of those that a claim predicts, in every recording."""

from dataclasses import dataclass

import numpy as np

from fe_models.arrays import BoolArray, FloatArray, IntArray
from hybrid.diagnosis.modal.claim import Claim
from hybrid.diagnosis.modal.config import PAIRING
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modal.modes_of_claim import Predicted, predicted_by
from hybrid.diagnosis.modal.pairing import displaced, paired


@dataclass(frozen=True)
class Pairs:
    """Which measured mode is which: ``recording``, the ``measured`` mode there and the structure's ``mode`` (row,) of
    each pair, and ``reference`` (row,), the sensor over which shapes are taken.
    """

    recording: IntArray
    measured: IntArray
    mode: IntArray
    reference: IntArray

    def __len__(self) -> int:
        return len(self.mode)

    @property
    def places(self) -> list[tuple[int, int]]:
        """The recording of each pair, and which of its measured modes it has."""
        return list(zip(self.recording.tolist(), self.measured.tolist(), strict=True))

    def references_in(self, recording: int, modes: int) -> IntArray:
        """Return the reference (mode,) of each of the measured ``modes`` of a recording, 0 of one without a pair."""
        here, found = self.recording == recording, np.zeros(modes, dtype=int)
        found[self.measured[here]] = self.reference[here]
        return found

    def are_among(self, others: "Pairs") -> BoolArray:
        """Return of which pairs (pair,) the measured mode is in another's, too."""
        known = set(others.places)
        return np.array([place in known for place in self.places], dtype=bool)

    def among(self, others: "Pairs") -> "Pairs":
        """Return those pairs of which the measured mode is in another's, too."""
        return self.take(self.are_among(others))

    def take(self, kept: BoolArray) -> "Pairs":
        """Return some of the pairs, those that are ``kept`` (pair,)."""
        return Pairs(self.recording[kept], self.measured[kept], self.mode[kept], self.reference[kept])


def pairs_of(measured: ModalData, claim: Claim, predicted: Predicted) -> Pairs:
    """Return which measured mode is which of those predicted."""
    found: list[tuple[int, int, int]] = []
    for recording, own in enumerate(measured.recordings):
        modes = predicted[claim.idle_in(recording)]
        mode = paired(own, modes.log_omega[0], modes.shapes[0], measured.orders)
        found += [(recording, int(k), int(mode[k])) for k in np.flatnonzero(mode >= 0)]
    rows = np.array(found, dtype=int).reshape(-1, 3)
    first = predicted[next(iter(predicted))]
    displaced = first.shapes[0] * np.exp(-np.outer(first.log_omega[0], measured.orders))
    largest = np.argmax(np.abs(displaced), axis=1)
    number = np.minimum(rows[:, 2], len(largest) - 1)  # a cause may bring a mode that others do not have
    every = Pairs(rows[:, 0], rows[:, 1], rows[:, 2], largest[number])
    return every.take(_move_at_reference(measured, every))


def _move_at_reference(measured: ModalData, pairs: Pairs) -> BoolArray:
    """Return of which pairs (pair,) the measured shape moves where shapes are taken over: see `PairingConfig`."""
    found = np.ones(len(pairs), dtype=bool)
    for recording, own in enumerate(measured.recordings):
        here = np.flatnonzero(pairs.recording == recording)
        shapes = np.abs(displaced(own.log_omega, own.shapes, measured.orders))[pairs.measured[here]]
        at = shapes[np.arange(len(here)), pairs.reference[here]]
        found[here] = at > PAIRING.min_reference * shapes.max(axis=1, initial=0.0)
    return found


def predicted_of(measured: ModalData, claim: Claim, theta: FloatArray) -> tuple[Predicted, Pairs]:
    """Return a claim's modes at ``theta`` (parameter,), by the candidates that do not act, and which measured one is
    which of them; none where the structure does not stand.
    """
    predicted = predicted_by(measured, claim, theta)
    if predicted is None:
        return {}, Pairs(*np.zeros((4, 0), dtype=int))
    return predicted, pairs_of(measured, claim, predicted)
