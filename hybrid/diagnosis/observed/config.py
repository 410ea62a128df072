"""Numbers of what is shown before a cause is named, with the reason beside each."""

from dataclasses import dataclass


@dataclass(frozen=True)
class UniformErrorConfig:
    """Errors that all modes share."""

    min_motion_share_and_mac: tuple[float, float] = (0.01, 0.8)  # share of the motion, and MAC, of a mode that counts
    max_ratio_spread: float = 1.05  # largest over smallest ratio: local causes move modes each by its own
    min_frequency_error: float = 0.15  # a uniform error of stiffness that is normal moves them by a few hundredths ...
    # times the nominal damping ratios, or a part of them: no place damps all modes alike ...
    min_damping_factor: float = 1.5
    min_damping_sigma: float = 4.0  # ... and this many times what they are stated to be uncertain by, if that is more
    # ... or by this many times what stiffness and mass are stated to be uncertain by, half of it in frequency
    min_frequency_sigma: float = 1.5


@dataclass(frozen=True)
class ObservationConfig:
    """Observed modes, and their dependence on amplitude."""

    # standard deviation of every factor's logarithm where the recordings alone shall determine frequencies and shapes
    free_factor_std: float = 0.5
    amplitude_levels: int = 3  # sizes that are distinguished
    min_segments_per_level: int = 2  # segments of each
    min_change_sigma: float = 3.0  # standard deviations: a change with amplitude beyond is called one


@dataclass(frozen=True)
class ExampleConfig:
    """The picture of a recording and its forecasts."""

    max_channels: int = 5  # drawn
    padding_share: float = 0.25  # of a channel's range, free above and below it
    max_frequency_ratio: float = 4.0  # times the highest natural frequency: how far the spectra go


UNIFORM_ERRORS = UniformErrorConfig()
OBSERVATION = ObservationConfig()
EXAMPLE = ExampleConfig()
