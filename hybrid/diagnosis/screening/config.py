"""Numbers of the quick look at all candidates, with the reason beside each."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class ScreeningConfig:
    """Score tests of all candidates, harmonic forces among them."""

    confounded_share: float = 1e-9  # of the energy of a response: what the rest of the model leaves of it is rounding
    frequencies_per_line: int = 2  # trial frequencies of a harmonic force within the resolution of a recording
    peaks_per_place: int = 2  # frequencies kept at each place
    # of all energy: a line at a sum or difference of natural frequencies must be stronger on a frame,
    min_combination_share: float = 2.5e-3
    # or be as much of what a fit leaves, and more than its noise: a machine may run there by chance
    min_residual_share: float = 0.5


@dataclass(frozen=True)
class ScanConfig:
    """Sizes at which candidates are tried whose effect is not linear in them."""

    sizes: tuple[float, ...] = (-2.0, -1.0, -0.5, -0.2, 0.2, 0.5, 1.0, 2.0)  # of a prior width, from doing nothing
    # of a support's compliance, of the usual one: it may give way by a hundredth of that or be all but lost, and a
    # start must be within a third: these are within a fifth of any
    compliances: tuple[float, ...] = tuple(np.geomspace(0.006, 20.0, 24))
    # times the energy of noise: what an element that is all but lost makes a fit without it leave, at least
    min_unexplained_ratio: float = 2.0


@dataclass(frozen=True)
class ModalScanConfig:
    """Sizes that are tried against observed frequencies and shapes."""

    difference_step: float = 1e-3  # of a prior width: finite differences of frequencies and shapes
    # of a prior width: small effects, besides those of a scan
    fine_sizes: tuple[float, ...] = (-0.1, -0.05, -0.02, 0.02, 0.05, 0.1)
    refined_sizes: int = 9  # sizes that are tried between the two next to the best
    # relative errors besides: of first order, in factors that are off by a few deviations
    frequency_error: float = 3e-4
    shape_error: float = 0.01


SCREENING = ScreeningConfig()
SCAN = ScanConfig()
MODAL_SCAN = ModalScanConfig()
