"""Every measured mode beside those of the structure as it was drawn, and with what was found."""

from dataclasses import dataclass

import numpy as np

from fe_models.modes import mac
from hybrid.diagnosis.modal.evidence import ModalFit
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modal.mode_values import FREQUENCY, RATIO
from hybrid.diagnosis.modal.pairing import displaced
from hybrid.diagnosis.modal.pairs import predicted_of


@dataclass(frozen=True)
class PairedMode:
    """A measured mode beside the structure's: ``recording``; frequencies (Hz) ``measured``, with its standard deviation
    ``error``, by the ``drawn`` structure and with what was found (``extended``); damping ratio ``ratio`` and its
    standard deviation ``ratio_error``; MAC at the sensors with both.
    """

    recording: str
    measured: float
    error: float
    ratio: float
    ratio_error: float
    drawn: float | None
    extended: float | None
    mac_drawn: float | None
    mac_extended: float | None


def paired_modes(measured: ModalData, drawn: ModalFit, best: ModalFit) -> tuple[PairedMode, ...]:
    """Return every measured mode beside those of the drawn and of the extended structure."""
    sides = [_modes_beside(measured, item) for item in (drawn, best)]
    found = []
    for recording, own in enumerate(measured.recordings):
        for k in np.argsort(own.log_omega):
            (before, mac_before), (after, mac_after) = (side.get((recording, int(k)), (None, None)) for side in sides)
            frequency = float(np.exp(own.log_omega[k])) / (2 * np.pi)
            error, ratio_error = (float(np.sqrt(own.covariance[k, i, i])) for i in (FREQUENCY, RATIO))
            found.append(
                PairedMode(
                    own.name,
                    frequency,
                    frequency * error,
                    float(own.ratios[k]),
                    ratio_error,
                    before,
                    after,
                    mac_before,
                    mac_after,
                )
            )
    return tuple(found)


def _modes_beside(measured: ModalData, item: ModalFit) -> dict[tuple[int, int], tuple[float, float | None]]:
    """Return frequency (Hz) and MAC of the structure's mode, by recording and number of the measured one; no MAC where
    no shape was measured.
    """
    found = {}
    predicted, pairs = predicted_of(measured, item.claim, item.theta)
    for recording, k, mode in zip(pairs.recording, pairs.measured, pairs.mode, strict=True):
        modes = predicted[item.claim.idle_in(int(recording))]
        own = measured.recordings[recording]
        seen = displaced(own.log_omega[k], own.shapes[k], measured.orders)
        made = displaced(modes.log_omega[0, mode], modes.shapes[0, mode], measured.orders)
        criterion = mac(seen[:, None], made[:, None])
        frequency = float(np.exp(modes.log_omega[0, mode])) / (2 * np.pi)
        found[int(recording), int(k)] = (frequency, float(criterion[0, 0]) if own.has_shape[k] else None)
    return found
