"""The modes that a claim predicts in each recording: where the same candidates act, they are the same."""

import numpy as np

from fe_models.arrays import FloatArray
from hybrid.diagnosis.modal.claim import Claim
from hybrid.diagnosis.modal.config import FIT
from hybrid.diagnosis.modal.modal_data import ModalData
from hybrid.diagnosis.modal.predicted_modes import PredictedModes, predicted_modes

Predicted = dict[tuple[int, ...], PredictedModes]
"""The modes of a claim, by the numbers of the candidates that do not act."""


def predicted_by(measured: ModalData, claim: Claim, theta: FloatArray) -> Predicted | None:
    """Return the modes at ``theta`` (parameter,), the first variant, and with each parameter moved by a little, the
    others; None where the structure does not stand.
    """
    found = {}
    for idle in dict.fromkeys(claim.idle_in(recording) for recording in range(len(measured.recordings))):
        hypothesis, kept = claim.hypothesis.less(idle), claim.hypothesis.parameters_of(idle)
        own = theta[kept]
        thetas = np.vstack([own, own + np.diag(FIT.difference_step * hypothesis.width)])
        modes = predicted_modes(hypothesis, thetas, measured.outputs, hardly_differ=True)
        if modes is None or not modes.roots.shape[1]:
            return None
        found[idle] = modes
    return found
