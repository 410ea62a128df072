"""Numbers of the identification of modes from recordings, with the reason beside each."""

from dataclasses import dataclass


@dataclass(frozen=True)
class StabilisationConfig:
    """Poles of realisations of rising order, and which of them stay where they are."""

    lowest_order: int = 4
    highest_order: int = 60  # states: thirty modes, noise among them; a frame's recordings show a dozen
    order_step: int = 2  # a mode more from one order to the next
    block_rows: int = 60
    min_row_periods: float = 1.5  # of the slowest mode, which the block rows span at least
    max_columns: int = 1500  # more cost time and add little
    energy_share: float = 0.95  # of the recording, where the realisation looks: the rest is noise
    # relative difference of frequencies, and MAC, of poles of two orders that are one mode (usual values of the field)
    max_frequency_difference: float = 0.01
    min_mac: float = 0.95
    min_order_share: float = 0.25  # of all orders in which a mode is found; poles of noise are found in few


@dataclass(frozen=True)
class FreeDecayConfig:
    """Modes of free decays."""

    # Hz, or of the lowest natural frequency where that is less than 1 Hz: below are drifts
    min_frequency_hz: float = 0.5
    # modes in a recording of noise alone, if every sample were one chance: roots between lines are many more
    false_alarms: float = 1e-5
    min_phase_collinearity: float = 0.5  # sensors move nearly in phase in a mode (Pappa 1993); in noise they do not
    max_frequency_error: float = 0.01  # relative standard deviation: what is known less well is taken for noise
    max_shape_error: float = 0.5  # of the largest entry: the same, for the usual entry of a shape
    # times the energy that all poles leave: one in no phase that holds more is several modes, not what is left of one
    # whose frequency changes, of which as much is left as such a pole holds
    min_energy_of_several: float = 10.0
    min_mac_of_one_mode: float = 0.9  # MAC at the sensors, from which on poles are one mode ...
    # ... if they lie that close together, relative, or closer than the recording can resolve
    max_relative_separation: float = 0.05
    # a pole with less of the energy of another, as near to it as so many times its decay rate, follows a change of that
    # mode's frequency as it decays, and has a shape that means nothing
    max_satellite_energy: float = 0.05
    max_satellite_distance: float = 4.0
    max_rounds: int = 8  # fits, after each of which modes are left out or joined, and the noise is estimated anew
    noise_tolerance: float = 0.05  # relative change of the noise from one round to the next that is none
    max_damping_ratio: float = 0.2  # more is no vibration
    max_evaluations: int = 30
    step_scale: float = 0.1  # rad/s: of a root's parts, in which one step is as long as another
    max_iterations: int = 12  # of the fit that all channels and motions share
    min_chi2_fall: float = 0.01  # of its sum of squares, below which it has converged
    largest_step: float = 0.3  # of a root, relative: more in one step leads to another mode
    least_noise: float = 1e-9  # of a channel's rms: recordings without noise
    # the band on both sides of a mode in which the noise that it meets is taken: in lines that its decay, or the
    # recording, can tell apart, and of its frequency, whichever is wider
    noise_band_lines: float = 4.0
    noise_band_share: float = 0.02


@dataclass(frozen=True)
class AmbientConfig:
    """Modes of what unknown forces keep moving."""

    # samples a second over the highest frequency looked for: two are the least; more are averaged
    min_rate_ratio: float = 2.5
    row_periods: float = 1.5  # of the slowest mode, which block rows span: about half a correlation's first fall
    # times the block rows there are, that the slowest mode asks for, from which on a band below is looked at by itself
    max_lack_of_rows: float = 2.5
    band_ratio: float = 4.0  # of one band's highest frequency to that of the next below
    band_overlap: float = 0.05  # of a band's end: modes there are looked for in both bands
    max_rows: int = 400  # block rows times sensors: the decomposition takes a quarter of a second
    max_row_share: float = 0.1  # of all samples: block rows times sensors, beyond which noise correlates as modes do
    edge_margin: float = 1.1  # over the correlations of noise, which samples that follow each other exceed a little
    segments: int = 100  # parts of the recording, each of which has a say: the deviation is known to 7 %
    # of the mean power, below which what channels and lags show together is taken for noise: 7 % of the rms. Filtered
    # data, and several channels that one force moves, hold nothing in some of these, whose inverse would be without
    # bounds
    least_noise_power: float = 5e-3
    min_order_share: float = 0.5  # of all orders that can hold all modes: a mode stays, a pole of noise does not
    # states beyond those that the recording shows: there, modes are free of what the others leave to them
    min_further_orders: int = 20
    # relative standard deviation of a frequency: what is known less well is taken for noise; a mode with a damping
    # ratio of 0.02 is known so well after four periods
    max_frequency_error: float = 0.03
    least_energy: float = 1e-4  # share of the recording's: 1 % of its rms, below which modes are noise of others


@dataclass(frozen=True)
class HarmonicConfig:
    """Lines of machines among modes."""

    largest_ratio: float = 2e-3  # damping ratio: steel without joints has as little, and a machine's speed wanders ...
    ratio_sigma: float = 4.0  # ... or what is hardly told from none, in so many standard deviations
    band_lines: int = 40  # that the recording can tell apart: how well a pole says where a line is
    steps: int = 2  # from one such line to the next, in which the highest is looked for
    nearest_lines: float = 2.0  # from a line: Hann's window leaves nothing of it there ...
    farthest_lines: float = 8.0  # ... and a mode's peak has not fallen much
    false_alarms: float = 1e-3  # of a mode without much damping taken for a line
    end_share: int = 20  # of a recording, one in so many samples at either end: there a narrow band rings
    largest_fourth_moment: float = 1.25  # over the squared second: 1 of a sine, 2 of noise, within 0.3 of 40 amplitudes


@dataclass(frozen=True)
class ExcitationConfig:
    """Whether recordings die away."""

    least_decay: float = 3.0  # logarithm of power, from the first third to the last: what dies away less cannot be told
    most_decay: float = 6.0  # after which noise is left
    # of the fall that a free decay has: what forces drive falls by chance, by a small part of it
    largest_fall: float = 0.25
    min_energy_share: float = 0.5  # of the modes', that those have which should have died away
    band_decays: float = 4.0  # decay rates over pi, its peak's own width: nearly all of a mode's power
    band_lines: float = 8.0  # that the recording can tell apart, at least: power over time asks for some
    span_periods: float = 2.0  # of the strongest vibration, in which its power is taken: two modes beat more slowly ...
    min_spans: int = 6  # ... in a recording at least
    span_steps: int = 4  # to a span: where a blow comes within one
    most_motions: int = 4  # of one recording: they are alike
    min_return: float = 0.2  # of the largest power before, that comes back from one span to the next


@dataclass(frozen=True)
class BackboneConfig:
    """Frequency and damping over amplitude."""

    span_periods: float = 12.0  # of the mode, in which a frequency is fitted ...
    max_span_share: float = 0.5  # ... or half of the recording where that is less ...
    # ... but no less than a frequency needs to be distinguished from its damping and an offset
    min_span_periods: float = 1.5
    step_share: float = 0.5  # of a span, from one to the next
    min_amplitude_share: float = 0.02  # of the largest: below, other modes and noise pull at the frequency
    max_frequency_error: float = 0.005  # relative standard deviation: more would hide the changes, of about 1 %


@dataclass(frozen=True)
class AgreementConfig:
    """Whether recordings are of one structure."""

    window_s: float = 5.0  # s: longer ones would ask for the phase of a frequency that moves by thousandths ...
    min_periods: float = 2.0  # ... but no less than so many of the slowest mode, or the shortest recording
    # of a recording's energy by another's model, beyond what their own leave; the same structure stays below 0.2
    max_unexplained_share: float = 0.5


@dataclass(frozen=True)
class ComparisonConfig:
    """Recordings beside one another and beside the model."""

    min_periods: float = 2.0  # of a mode: a recording that holds fewer tells too little of it to be shown
    min_mac: float = 0.9  # MAC at the sensors, from which on an identified mode is a nominal one
    # of its frequency: how far off a nominal mode may be where there are too few sensors to tell it by its shape
    max_frequency_difference: float = 0.2
    max_modes: int = 12  # of a recording at most; those beyond carry little
    max_pairs_of: int = 4  # recordings, between each two of which changes are printed; of more, from the first to each
    extra_modes: int = 2  # identified than nominal ones: what a recording shows beside these
    backbone_modes: int = 2  # modes, the strongest, whose backbones are identified
    max_distance_hz: float = 0.06  # Hz: how far from its place a peak may be
    background_hz: float = 0.6  # Hz on both sides: what a peak is held against, less the middle of it
    min_peak_ratio: float = 20.0  # of power to what is round it: noise, and the feet of other peaks, stay below
    # of its frequency, and in standard deviations: how far a mode at a sum or multiple of others may be off that
    sum_distance: float = 5e-4
    sum_sigma: float = 3.0
    same_sign_share: float = 0.8  # of the largest entry of a shape: as large, where its sign is set
    # of a recording's energy: one that is no nominal mode is reported from there on
    min_reported_energy_share: float = 0.003


@dataclass(frozen=True)
class PairingConfig:
    """What speaks against an identified mode as one of the model's; one is as bad in each."""

    mac_scale: float = 0.05  # what a MAC lacks of one: as much as modelling errors and noise take away
    frequency_scale: float = 0.2  # logarithm: how far a frequency usually is from the model's
    least_energy: float = 1e-4  # share of the recording's: what has less is as weak as this; a decade is as bad as one
    max_cost: float = 8.0  # of a pair: as bad in all three as may be, with a frequency at the end of its usual range
    max_chance: float = 0.02  # probability of a shape drawn at random to agree as well: a frequency far off needs less


@dataclass(frozen=True)
class SuspectSensorsConfig:
    """Sensors that keep shapes from being those expected."""

    least_gain: float = 0.03  # of what is expected: less is said to be nothing
    most_left: float = 0.2  # of what a sensor shows, by one gain in all modes: as much as models and noise leave
    most_right: float = 0.5  # of the modes, in which a sensor that has no fault shows what is expected


@dataclass(frozen=True)
class ChangesConfig:
    """What changed from one recording to another."""

    min_mac: float = 0.8  # of one mode in two states: a lost storey or cable leaves so much of most shapes
    max_change: float = 0.15  # logarithm of its frequency: a quarter of the stiffness that it feels
    # of one mode by its shape alone, where the sensors tell it from others: of a frequency that fell to 60 %, with two
    # thirds of the stiffness that it feels
    alone_mac: float = 0.9
    alone_change: float = 0.5  # logarithm
    false_alarms: float = 2e-3  # of two recordings of one state called changed; first-order deviations add a little
    least_error: float = 1e-9  # relative: exact data
    max_recordings: int = 12  # of which each two are compared: 66 pairs


@dataclass(frozen=True)
class RealisationConfig:
    """Linear models that recordings realise."""

    block_rows: int = 20  # samples a column; of 11 to 60, on the bridge's recordings, 20 forecast best on average
    order: int = 20  # states: ten modes, as the hybrid model has


@dataclass(frozen=True)
class FrequencyResponseConfig:
    """Frequency response functions under known loads."""

    segment_share: float = 0.25  # of a recording: with half of it overlapping, seven segments of each
    min_segment: int = 256  # samples, if recordings hold as many: shorter ones resolve no resonance
    min_averages: int = 2  # segments for each input: of fewer, any coherence is one
    # of a load's energy in that share of a recording: a knock, which no window may cut
    knock_energy: float = 0.98
    knock_share: float = 0.1
    min_power_share: float = 0.01  # of a load's largest power: with less at a frequency, noise is divided by nothing
    max_condition: float = 1e6  # of the loads' cross spectra: beyond it they go with one another
    max_modes: int = 100  # of a structure; the others answer statically


STABILISATION = StabilisationConfig()
FREE_DECAY = FreeDecayConfig()
AMBIENT = AmbientConfig()
HARMONIC = HarmonicConfig()
EXCITATION = ExcitationConfig()
BACKBONE = BackboneConfig()
AGREEMENT = AgreementConfig()
COMPARISON = ComparisonConfig()
PAIRING = PairingConfig()
SUSPECT_SENSORS = SuspectSensorsConfig()
CHANGES = ChangesConfig()
REALISATION = RealisationConfig()
FREQUENCY_RESPONSE = FrequencyResponseConfig()
