"""Natural frequencies that are all off alike: a sampling rate or a unit is wrong, rather than something at a place."""

import numpy as np

from fe_models.recordings import Uncertainty
from hybrid.diagnosis.shown.show import Shown

SEEN = (0.01, 0.8)  # share of the motion, and MAC, of a mode that tells
ALIKE = 1.05  # largest over smallest ratio: local causes move modes each by its own
FAR = 0.15  # a uniform error of stiffness that is normal moves them by a few hundredths ...
NORMAL = 1.5  # ... or by this many times what stiffness and mass are stated to be uncertain by, half of it in frequency


def all_off(shown: Shown, uncertainty: Uncertainty) -> list[str]:
    """Return a note where two modes or more are observed at nearly the same multiple of their nominal frequency.

    Overdamped modes are in neither list, so that of one there may be more than of the other.
    """
    count = min(len(modes.frequencies) for modes in (shown.observed, shown.nominal))
    told = (shown.motion_energy[:count] > SEEN[0]) & (shown.mac[:count] > SEEN[1])
    ratios = (shown.observed.frequencies[:count] / shown.nominal.frequencies[:count])[told]
    if len(ratios) < 2 or ratios.max() > ALIKE * ratios.min():
        return []
    usual = float(np.median(ratios))
    far = 1 + max(FAR, NORMAL * (uncertainty.stiffness + uncertainty.mass))
    if 1 / far < usual < far:
        return []
    return [
        f"all natural frequencies that are well seen are observed at {usual:.3g} times the nominal ones: "
        "check sampling_rate, and the units of the model's stiffness and mass"
    ]
