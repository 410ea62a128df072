"""Fast modes that recordings without an anti-aliasing filter show at other frequencies: on no list, but reported."""

import numpy as np

from hybrid.diagnosis.contest.setting import Setting
from hybrid.diagnosis.fitting.least_squares import Fit
from hybrid.diagnosis.outcome.config import MENTION
from hybrid.diagnosis.outcome.rest import elsewhere, rests
from hybrid.diagnosis.recorded.noise_model import NoiseModel

FOLDS = (
    "what is left of the recordings stands out near {line:.4g} Hz, where a mode of {mode:.4g} Hz shows without an"
    " anti-aliasing filter, and may be taken for something else: filter before sampling and state the lowpass, or leave"
    " out the beginning of recordings, until fast modes have died away"
)


def folding_of(item: Fit, setting: Setting, noise_model: NoiseModel) -> list[str]:
    """Return a line on the drawn structure's mode above half the sampling rate that a fit seems to leave; none where
    a low-pass has kept such modes out, or nothing stands out.
    """
    rate, nominal = noise_model.rate, setting.nominal
    if setting.dataset.lowpass is not None:
        return []
    line = elsewhere(rests(item, noise_model), nominal.modes[0] / (2 * np.pi), rate)
    if line is None:
        return []
    fast = nominal.all_frequencies / (2 * np.pi)
    fast = fast[fast > rate / 2]
    off = np.abs(np.abs(fast - rate * np.round(fast / rate)) - line) / fast
    return [FOLDS.format(line=line, mode=fast[off.argmin()])] if np.any(off < MENTION.fold_share) else []
