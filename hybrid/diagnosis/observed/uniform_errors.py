"""What is off in all modes: frequencies by a sampling rate or a unit, damping by what the simulation assumes of it."""

import numpy as np

from fe_models.arrays import BoolArray
from fe_models.recordings import Uncertainty
from hybrid.diagnosis.observed.config import UNIFORM_ERRORS
from hybrid.diagnosis.observed.observations import Observations


def uniform_frequency_error(shown: Observations, uncertainty: Uncertainty) -> list[str]:
    """Return a note where two modes or more are observed at nearly the same multiple of their nominal frequency.

    Overdamped modes are in neither list, so that of one there may be more than of the other.
    """
    count, clear = _well_observed(shown)
    ratios = (shown.observed.frequencies[:count] / shown.nominal.frequencies[:count])[clear]
    if len(ratios) < 2 or ratios.max() > UNIFORM_ERRORS.max_ratio_spread * ratios.min():
        return []
    usual = float(np.median(ratios))
    far = 1 + max(
        UNIFORM_ERRORS.min_frequency_error,
        UNIFORM_ERRORS.min_frequency_sigma * (uncertainty.stiffness + uncertainty.mass),
    )
    if 1 / far < usual < far:
        return []
    return [
        f"all natural frequencies that are well seen are observed at {usual:.3g} times the nominal ones: "
        "check sampling_rate, and the units of the model's stiffness and mass"
    ]


def uniform_damping_error(shown: Observations, uncertainty: Uncertainty) -> list[str]:
    """Return a note where all modes that are well seen, two or more, are observed damped far more, or far less."""
    count, clear = _well_observed(shown)
    observed, nominal = shown.observed.ratios[:count][clear], shown.nominal.ratios[:count][clear]
    far = max(UNIFORM_ERRORS.min_damping_factor, 1 + UNIFORM_ERRORS.min_damping_sigma * uncertainty.damping)
    if len(observed) < 2 or not (np.all(observed > far * nominal) or np.all(far * observed < nominal)):
        return []
    modes = ", ".join(str(mode + 1) for mode in np.flatnonzero(clear))
    seen, assumed = (", ".join(f"{ratio:.2g}" for ratio in ratios) for ratios in (observed, nominal))
    return [
        f"modes {modes} are observed with damping ratios of {seen} instead of {assumed}: "
        "check the damping that the simulation assumes ([simulation] damping_ratio, or that of the model)"
    ]


def _well_observed(shown: Observations) -> tuple[int, BoolArray]:
    """Return how many modes are in both lists, observed and nominal, and which of these are well seen."""
    count = min(len(modes.frequencies) for modes in (shown.observed, shown.nominal))
    return count, (shown.motion_energy[:count] > UNIFORM_ERRORS.min_motion_share_and_mac[0]) & (
        shown.mac[:count] > UNIFORM_ERRORS.min_motion_share_and_mac[1]
    )
