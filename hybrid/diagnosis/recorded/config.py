"""Numbers of what is asked of recordings before a search, with the reason beside each."""

from dataclasses import dataclass


@dataclass(frozen=True)
class AmountConfig:
    """How much of long recordings a diagnosis goes by."""

    # of the measured sensors, of recordings for training and of those for testing: minutes, and less than 3 GB by four
    most_values: int = 400_000
    least_samples: int = 25_000  # whatever the number of sensors: a usual measurement is used whole
    shortest: int = 5_000  # samples that a motion is cut to at least: those of a usual recording
    program_gb: float = 0.3  # the program with its libraries
    sample_gb: float = 2.4e-5  # of a sample for training: what may be an offset is told by block Hankel matrices ...
    value_gb: float = 3e-6  # ... and of a value: fits beside a force law, two at a time
    trifle_gb: float = 1.0  # what any machine has


@dataclass(frozen=True)
class UnitCheckConfig:
    """Motions that are perhaps in another unit."""

    # times: of m/s^2, mm/s^2 are a thousand, and motions of one campaign hardly differ so much
    min_size_ratio: float = 100.0
    min_motions: int = 3  # motions: of two nobody knows which is the usual one


@dataclass(frozen=True)
class ChannelFaultConfig:
    """Dead, stuck and saturated channels."""

    # equal extreme values in a row: noise makes no two of them equal, rounding rarely three
    min_equal_extremes: int = 3
    # times the longest run of equal values below the extremes: coarsely rounded peaks are no saturation
    min_run_ratio: int = 2
    # that often is an extreme value no chance, where nearly all others differ: a few samples a period reach it
    min_extreme_count: int = 5
    # equal values in a row, where nearly all others differ: a sensor or its logger has stood still
    min_equal_values: int = 5
    min_range_share: float = 0.01  # of a channel's range, within as many samples beside these: else it has come to rest
    min_distinct_share: float = 0.9  # of the other values: rounding makes fewer
    rounding: float = 1e-9  # of a channel's range: values this close are equal
    max_dead_share: float = 0.5  # of the channels that are alive in any recording
    max_levels_listed: int = 4  # that are listed one by one: a sensor clips at two, but recordings may be scaled
    # of a channel's usual size: less is no sensor's noise, but what symmetry leaves of a simulated motion
    silent_share: float = 1e-6


@dataclass(frozen=True)
class MotionlessConfig:
    """Channels that hardly move."""

    # of the largest motion: a sensor that is turned by a twentieth of a degree shows as much of what moves across it,
    # and a beam that sways by more than 2 mm a metre shows its shortening along it
    max_motion_share: float = 0.001
    min_others: int = 2  # channels to be compared with: where there are fewer, each is needed
    # of the largest entry of all mode shapes at these sensors: four times as much, as models are off themselves
    max_shape_share: float = 0.02


@dataclass(frozen=True)
class FilterTransientConfig:
    """Ends of recordings that a low-pass spoils."""

    ringing_periods: float = 2.0  # of the cutoff: until the usual filter's ringing is a hundredth of the jump
    max_cut_share: float = 0.05  # of a recording, at either end: short ones need what they have


@dataclass(frozen=True)
class MotionFreeConfig:
    """Offsets and drifts beside free decays."""

    min_periods: float = 1.5  # of the slowest mode: in shorter recordings a part of an oscillation looks like an offset
    min_samples_per_mode: float = 20.0  # samples a mode: fewer hardly identify poles
    spare_modes: int = 2  # modes identified beside the nominal ones: an offset with a drift, and what is not linear
    min_frequency_share: float = 0.5  # of the slowest mode: what is slower is no motion of the structure
    # slow components of a recording at least, by which an offset in it is judged: motion takes up half a dozen of them
    min_half_waves: int = 16
    max_half_waves: int = 128  # ... and at most: as many judge an offset as well as more, in a hundredth of the time
    min_share_beside_motion: float = 0.1  # of the largest: components with less beside motion are motion's own
    stretch_periods: float = 1.5  # of the slowest mode: as much is looked at together to identify its pole ...
    max_stretch_share: float = 0.3  # ... but no more of the shortest recording ...
    max_stretch_values: int = 1500  # ... and no more values of all sensors: their products must be held
    rounding: float = 1e-9  # of the largest value: recordings without noise have as much
    max_chance_of_offset: float = 1e-6  # so often at most chance makes an offset that is one, or two that differ
    max_chance_of_drift: float = 1e-3  # so often at most chance makes what distinguishes a drift from an offset


@dataclass(frozen=True)
class OffsetConfig:
    """Which offsets of sensors are taken off, and which are reported."""

    # times the standard deviation about it: a mean that no oscillation of two periods or more leaves
    min_mean_over_std: float = 0.25
    # of the mean: how far it may differ between recordings, and move within one; a drift does
    max_relative_change: float = 0.3
    # of a channel's standard deviation: beside noise of 3 % a smaller offset hardly shows in forecasts
    min_share_of_std: float = 0.005
    # of it: offsets that differ by less, as those of one afternoon, are hardly worth a word
    min_difference_share: float = 0.02


@dataclass(frozen=True)
class NoiseConfig:
    """The noise of channels, from frequencies where no motion is, or between spectral lines."""

    band_over_highest: float = 1.6  # times the highest natural frequency: where noise alone is expected
    close_over_highest: float = 1.15  # times it: motion there is not noise alone
    # of half the sampling rate: at least this share of the band is taken as the structure's, where it must be
    max_band_share: float = 0.7
    # of half the sampling rate: where noise is estimated in the recordings themselves, which have harmonics, too
    min_noise_frequency_share: float = 0.5
    harmonics_ratio: float = 2.0  # times the structure's band: likewise ...
    max_noise_frequency_share: float = 0.8  # ... but a fifth of all frequencies is left
    max_lags: int = 100  # samples, up to where autocorrelations are estimated ...
    max_lag_share: float = 1 / 3  # ... but no more of the shortest recording
    min_correlation_sigma: float = 3.0  # standard deviations of what white noise has of one by chance
    quiet_share: float = 0.4  # of a recording, from its end: by then all but the least damped modes have died away
    quantile: float = 0.25  # of the powers there: below it lies what is between the lines
    # lines of a spectrum with a Hann window that are worth one independent one: 1 + 2 (4/9 + 1/36)
    lines_per_independent: float = 1.94
    load_series_terms: int = 5  # powers of 1 / (i omega) in the response to a load far above all natural frequencies
    min_unexplained_share: float = 0.1  # of values: loads explain no more of a spectrum than the rest
    clear_of_lowpass: float = 1.4  # of a low-pass: beyond, a motion is a sixteenth in amplitude
    passed_by_lowpass: float = 0.9  # of a low-pass: up to there it takes nothing away
    max_excess_sigma: float = 4.0  # standard deviations: what is left beyond is no noise


@dataclass(frozen=True)
class NoiseLevelConfig:
    """How noise differs between recordings."""

    values_per_outlier: int = 20  # one value in so many may be astray where noise goes with motion
    max_deviation_sigma: float = 4.0  # standard deviations off: such a value


@dataclass(frozen=True)
class SpectraConfig:
    """Lines in spectra of recordings and residuals."""

    # of a motion's energy: a mode that has less hardly shows, and its damping not at all
    min_energy_share: float = 5e-4
    strongest_modes: int = 3  # modes whose sums and differences are looked at
    # of the lines: multiples and sums of so many frequencies, as stretching that comes with bending makes them
    combination_order: int = 2
    max_chance_of_line: float = 1e-6  # of a line that noise makes, anywhere
    min_line_ratio: float = 3.0  # times the noise: a line that stands out of it
    line_width: float = 1.5  # of a recording's resolution: how far from its place a line may be


AMOUNT = AmountConfig()
UNIT_CHECK = UnitCheckConfig()
CHANNEL_FAULTS = ChannelFaultConfig()
MOTIONLESS = MotionlessConfig()
FILTER_TRANSIENTS = FilterTransientConfig()
MOTION_FREE = MotionFreeConfig()
OFFSETS = OffsetConfig()
NOISE = NoiseConfig()
NOISE_LEVELS = NoiseLevelConfig()
SPECTRA = SpectraConfig()
