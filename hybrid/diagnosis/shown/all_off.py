"""Natural frequencies that are all off alike: a sampling rate or a unit is wrong, rather than something at a place."""

import numpy as np

from hybrid.diagnosis.shown.show import Shown

SEEN = (0.01, 0.8)  # share of the motion, and MAC, of a mode that tells
ALIKE = 1.05  # largest over smallest ratio: local causes move modes each by its own
FAR = 1.15  # a uniform error of stiffness that is normal moves them by a few hundredths


def all_off(shown: Shown) -> list[str]:
    """Return a note where two modes or more are observed at nearly the same multiple of their nominal frequency."""
    told = (shown.motion_energy > SEEN[0]) & (shown.mac > SEEN[1])
    ratios = (shown.observed.frequencies / shown.nominal.frequencies)[told]
    if len(ratios) < 2 or ratios.max() > ALIKE * ratios.min():
        return []
    usual = float(np.median(ratios))
    if 1 / FAR < usual < FAR:
        return []
    return [
        f"all natural frequencies that are well seen are observed at {usual:.3g} times the nominal ones: "
        "check sampling_rate, and the units of the model's stiffness and mass"
    ]
