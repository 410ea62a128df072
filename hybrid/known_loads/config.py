"""Numbers of known loads as they were sampled, with the reason beside each."""

from dataclasses import dataclass


@dataclass(frozen=True)
class PowerBeyondConfig:
    """How much power spectra hold beyond a low-pass."""

    # of the power below the cutoff: a filter of order 4, run both ways, leaves 0.08 at most, and noise that came after
    # it all
    min_power_of_white: float = 0.3
    band_within: tuple[float, float] = (0.75, 0.9)  # of the cutoff: where power is compared
    band_beyond: tuple[float, float] = (1.12, 1.3)  # of the cutoff: where power is compared
    quiet_quantile: float = 0.2  # quantile of the power in a band: of what lies between the lines of motions
    max_spectrum_samples: int = 512  # samples of a spectrum


@dataclass(frozen=True)
class BehindLowpassConfig:
    """Known loads behind a low-pass."""

    # of a load's energy: with more above the recordings' low-pass, the load has not passed it yet, nor with as much on
    # either side of it (`min_power_of_white`)
    max_share_above_lowpass: float = 0.1
    # of the low-pass: the usual filter leaves 0.01 of the power in the second band that it leaves in the first
    bands: tuple[tuple[float, float], ...] = ((0.6, 0.9), (1.25, 1.6))
    # of the power: half a sine of three samples has 0.05 and more
    max_density_ratio_beyond: float = 0.03


@dataclass(frozen=True)
class ShortKnocksConfig:
    """Knocks whose samples do not tell their force."""

    max_samples: int = 12  # of a knock: a longer one is resolved
    min_force_share: float = 0.02  # of the largest force: less is what a load cell shows at rest
    samples_after: int = 2  # after the last strong one: where the force ends between samples
    min_share_left: float = 0.5  # of a recording: with less after its knock it is left as it is
    top_band: float = 0.8  # of half the sampling rate, where power is compared
    # of the power in as wide a band from zero on: half a sine of five samples has 2e-3, and an impulse off by 1 %; of
    # ten 1e-4, and one off by 0.2 %
    max_top_power: float = 1e-4


@dataclass(frozen=True)
class QuietLoadsConfig:
    """Loads that are at rest most of the time."""

    min_acting_sigma: float = 5.0  # standard deviations of the noise at rest: one of a million values is so far off
    min_blow_sigma: float = 50.0  # likewise, of the largest value: a blow; of random forces hardly one reaches six
    max_acting_share: float = 0.2  # of all samples
    min_noise_share: float = 1e-6  # of the largest value: less is what filters leave of a blow, or rounding
    samples_beside: int = 8  # in which a blow rises and a filter's ringing sinks into the noise


@dataclass(frozen=True)
class ModalInputConfig:
    """Known loads on modes."""

    # of what loads do to modes that are not kept: accelerations are up to a sixth derivative of them
    left_out_terms: int = 3
    # of the elastic forces of all modes: eigenvectors leave rounding, a modal model of the user's own more
    max_eigen_residual: float = 1e-4


POWER_BEYOND = PowerBeyondConfig()
BEHIND_LOWPASS = BehindLowpassConfig()
SHORT_KNOCKS = ShortKnocksConfig()
QUIET_LOADS = QuietLoadsConfig()
MODAL_INPUT = ModalInputConfig()
